; One robot serves C0 orders, one after the other. Each order becomes a list of steps; the first one runs.

(deftemplate order
  "OPEN: not begun. TAKEN: the steps for it run. Windows count seconds from the begin of the game."
  (slot id (type INTEGER))
  (slot base (type STRING))
  (slot cap (type STRING))
  (slot begin (type INTEGER))
  (slot end (type INTEGER))
  (slot state (type SYMBOL) (allowed-values OPEN TAKEN) (default OPEN)))

(deftemplate cap-station
  (slot name (type STRING))
  (slot cap (type STRING))
  (slot shelf (type SYMBOL) (allowed-values LEFT MIDDLE RIGHT) (default LEFT)))  ; where the next carrier stands

(deftemplate step
  "A goal for the robot (pick, place) or for a machine (operation, and what it needs)."
  (slot n (type INTEGER))
  (slot server (type STRING))
  (slot target (type STRING))
  (slot operation (type STRING) (default ""))
  (slot color (type STRING) (default ""))
  (slot order (type INTEGER) (default 0))
  (slot not-before (type INTEGER) (default 0))
  (slot state (type SYMBOL) (allowed-values NEW SENT RUNNING) (default NEW))
  (slot goal (default NONE))
  (slot handle (default NONE)))

(deftemplate server (slot name (type STRING)) (slot type (type STRING)))
(deftemplate topic (slot name (type STRING)) (slot type (type STRING)))

(deffacts the-bus
  (server (name "/robot1/pick") (type "cxlab_skills/action/Pick"))
  (server (name "/robot1/place") (type "cxlab_skills/action/Place"))
  (server (name "/factory/instruct_machine") (type "rcll_interfaces/action/InstructMachine"))
  (topic (name "/order_info") (type "rcll_interfaces/msg/OrderInfo"))
  (topic (name "/game_state") (type "rcll_interfaces/msg/GameState"))
  (cap-station (name "C-CS1") (cap "CAP_GREY"))
  (cap-station (name "C-CS2") (cap "CAP_BLACK")))

(deftemplate game
  (slot begin (type FLOAT)))  ; when production began; the windows of orders count from there

(defglobal ?*last-step* = 0)

; --- The bus

(defrule open-client
  (server (name ?name) (type ?type))
  (not (executive-finalize))
  =>
  (ros-msgs-create-action-client ?name ?type))

(defrule open-topic
  (topic (name ?name) (type ?type))
  (not (executive-finalize))
  =>
  (ros-msgs-create-subscription ?name ?type))

(defrule hear-game-state
  ?fact <- (ros-msgs-message (topic "/game_state") (msg-ptr ?message))
  =>
  (if (and (eq (ros-msgs-get-field ?message "phase") "PRODUCTION") (not (any-factp ((?g game)) TRUE)))
   then (assert (game (begin (- (now) (ros-msgs-get-field ?message "game_time"))))))
  (ros-msgs-destroy-message ?message)
  (retract ?fact))

(defrule hear-orders
  "Note every C0 order that is new."
  ?fact <- (ros-msgs-message (topic "/order_info") (msg-ptr ?message))
  =>
  (foreach ?o (ros-msgs-get-field ?message "orders")
    (bind ?id (ros-msgs-get-field ?o "id"))
    (if (and (eq (ros-msgs-get-field ?o "complexity") "C0")
             (not (any-factp ((?known order)) (= ?known:id ?id))))
     then (assert (order (id ?id)
                         (base (ros-msgs-get-field ?o "base_color"))
                         (cap (ros-msgs-get-field ?o "cap_color"))
                         (begin (ros-msgs-get-field ?o "delivery_period_begin"))
                         (end (ros-msgs-get-field ?o "delivery_period_end")))))
    (ros-msgs-destroy-message ?o))
  (ros-msgs-destroy-message ?message)
  (retract ?fact))

; --- From an order to its steps

(deffunction next-step ()
  (bind ?*last-step* (+ ?*last-step* 1)))

(deffunction carry (?from ?to)
  (assert (step (n (next-step)) (server "/robot1/pick") (target ?from)))
  (assert (step (n (next-step)) (server "/robot1/place") (target ?to))))

(deffunction instruct (?machine ?operation ?color ?order ?not-before)
  (assert (step (n (next-step)) (server "/factory/instruct_machine") (target ?machine)
                (operation ?operation) (color ?color) (order ?order) (not-before ?not-before))))

(defrule take-order
  "The robot is free: begin the order whose window ends first. A cap comes off a carrier, whose base is thrown away;
   a base gets the cap and is delivered when the window is open."
  (game (begin ?zero))
  (not (step))
  ?order <- (order (id ?id) (base ?base) (cap ?cap) (begin ?begin) (end ?end) (state OPEN))
  (time ?now&:(< ?now (+ ?zero ?end)))
  (not (order (state OPEN) (end ?sooner&:(and (< ?sooner ?end) (< ?now (+ ?zero ?sooner))))))
  ?station <- (cap-station (name ?cs) (cap ?cap) (shelf ?shelf))
  =>
  (modify ?order (state TAKEN))
  (modify ?station (shelf (switch ?shelf (case LEFT then MIDDLE) (case MIDDLE then RIGHT) (default LEFT))))
  (carry (str-cat ?cs "-SHELF-" ?shelf) (str-cat ?cs "-INPUT"))
  (instruct ?cs "RETRIEVE_CAP" "" 0 0)
  (carry (str-cat ?cs "-OUTPUT") "C-DS-INPUT")
  (instruct "C-DS" "DELIVER" "" 0 0)
  (instruct "C-BS" "DISPENSE_BASE" ?base 0 0)
  (carry "C-BS-OUTPUT" (str-cat ?cs "-INPUT"))
  (instruct ?cs "MOUNT_CAP" "" 0 0)
  (carry (str-cat ?cs "-OUTPUT") "C-DS-INPUT")
  (instruct "C-DS" "DELIVER" "" ?id ?begin))

; --- One step

(defrule send-goal
  ?step <- (step (n ?n) (server ?server) (target ?target) (operation ?operation) (color ?color) (order ?order)
                 (not-before ?opens) (state NEW))
  (not (step (n ?earlier&:(< ?earlier ?n))))
  (game (begin ?zero))
  (time ?now&:(>= ?now (+ ?zero ?opens)))
  (server (name ?server) (type ?type))
  =>
  (bind ?goal (ros-msgs-create-goal-request ?type))
  (if (eq ?operation "")
   then (ros-msgs-set-field ?goal "target" ?target)
   else (ros-msgs-set-field ?goal "machine" ?target)
        (ros-msgs-set-field ?goal "operation" ?operation)
        (ros-msgs-set-field ?goal "side" "OUTPUT")
        (ros-msgs-set-field ?goal "base_color" ?color)
        (ros-msgs-set-field ?goal "order_id" ?order))
  (ros-msgs-async-send-goal ?goal ?server)
  (modify ?step (state SENT) (goal ?goal)))

(defrule goal-answered
  ?step <- (step (state SENT) (server ?server) (goal ?goal))
  ?response <- (ros-msgs-goal-response (server ?server) (client-goal-handle-ptr ?handle))
  =>
  (ros-msgs-destroy-message ?goal)
  (retract ?response)
  (modify ?step (state RUNNING) (goal NONE) (handle ?handle)))

(defrule step-ended
  "On to the next step; one that failed is tried again."
  ?step <- (step (state RUNNING) (server ?server) (target ?target) (handle ?handle))
  ?ended <- (ros-msgs-wrapped-result (server ?server) (code ?code) (result-ptr ?result))
  =>
  (if (eq ?code SUCCEEDED)
   then (retract ?step)
   else (printout warn ?server " " ?target " failed: " (ros-msgs-get-field ?result "error") crlf)
        (modify ?step (state NEW) (handle NONE)))
  (ros-msgs-destroy-message ?result)
  (ros-msgs-destroy-client-goal-handle ?handle)
  (retract ?ended))

(defrule ignore-feedback
  ?fact <- (ros-msgs-feedback (feedback-ptr ?feedback))
  =>
  (ros-msgs-destroy-message ?feedback)
  (retract ?fact))

; --- The end: give back what was opened

(defrule close-clients
  (executive-finalize)
  (server (name ?name))
  =>
  (ros-msgs-destroy-action-client ?name))

(defrule close-topics
  (executive-finalize)
  (topic (name ?name))
  =>
  (ros-msgs-destroy-subscription ?name))

(defrule close-step
  (executive-finalize)
  (step (goal ?goal) (handle ?handle))
  =>
  (if (neq ?goal NONE) then (ros-msgs-destroy-message ?goal))
  (if (neq ?handle NONE) then (ros-msgs-destroy-client-goal-handle ?handle)))
