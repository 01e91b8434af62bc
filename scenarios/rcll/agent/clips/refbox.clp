; Messages of the factory on the bus become facts.

(deftemplate topic
  (slot name (type STRING))
  (slot type (type STRING)))

(deffacts topics
  (topic (name "/game_state") (type "rcll_interfaces/msg/GameState"))
  (topic (name "/order_info") (type "rcll_interfaces/msg/OrderInfo"))
  (topic (name "/machine_info") (type "rcll_interfaces/msg/MachineInfo"))
  (topic (name "/ring_info") (type "rcll_interfaces/msg/RingInfo"))
  (topic (name "/robot_info") (type "rcll_interfaces/msg/RobotInfo")))

(defrule refbox-subscribe
  (topic (name ?topic) (type ?type))
  (not (ros-msgs-subscription (topic ?topic)))
  (not (executive-finalize))
  =>
  (ros-msgs-create-subscription ?topic ?type))

(defrule refbox-game-state
  ?message <- (ros-msgs-message (topic "/game_state") (msg-ptr ?m))
  =>
  (bind ?phase (sym-cat (ros-msgs-get-field ?m "phase")))
  (bind ?state (sym-cat (ros-msgs-get-field ?m "state")))
  (bind ?begin (- (now) (ros-msgs-get-field ?m "game_time")))
  (bind ?production (ros-msgs-get-field ?m "production_s"))
  (if (> ?production 0) then (bind ?*GAME* ?production))
  (ros-msgs-destroy-message ?m)
  (retract ?message)
  (do-for-all-facts ((?g game)) (neq ?g:phase ?phase) (retract ?g))
  (do-for-fact ((?g game)) (neq ?g:state ?state)
    (if (eq ?state RUNNING) then (postpone (- ?begin ?g:begin)))
    (modify ?g (state ?state) (begin ?begin)))
  (if (not (any-factp ((?g game)) TRUE)) then (assert (game (phase ?phase) (state ?state) (begin ?begin)))))

(deffunction bonus-of (?o ?letter)
  "Points of a competitive order: the team that is first with it gains 10 points, the other one loses them."
  (if (not (ros-msgs-get-field ?o "competitive")) then (return 0))
  (bind ?theirs (if (eq ?letter "C") then "quantity_delivered_magenta" else "quantity_delivered_cyan"))
  (if (> (ros-msgs-get-field ?o ?theirs) 0) then -10 else 10))

(deffunction learn-order (?o ?letter)
  "Note a released order, if it is new; else note what it earns now."
  (bind ?id (ros-msgs-get-field ?o "id"))
  (bind ?bonus (bonus-of ?o ?letter))
  (if (do-for-fact ((?known order)) (= ?known:id ?id) (if (<> ?known:bonus ?bonus) then (modify ?known (bonus ?bonus))) TRUE)
   then (return))
  (assert (order (id ?id)
                 (complexity (ros-msgs-get-field ?o "complexity"))
                 (base (ros-msgs-get-field ?o "base_color"))
                 (rings (ros-msgs-get-field ?o "ring_colors"))
                 (cap (ros-msgs-get-field ?o "cap_color"))
                 (bonus ?bonus)
                 (begin (float (ros-msgs-get-field ?o "delivery_period_begin")))
                 (end (float (ros-msgs-get-field ?o "delivery_period_end"))))))

(defrule refbox-order-info
  "The league reports its orders, and we know which team we are: note them."
  ?message <- (ros-msgs-message (topic "/order_info") (msg-ptr ?m))
  (we-are ?letter)
  =>
  (bind ?orders (ros-msgs-get-field ?m "orders"))
  (foreach ?o ?orders
    (learn-order ?o ?letter)
    (ros-msgs-destroy-message ?o))
  (ros-msgs-destroy-message ?m)
  (retract ?message))

(deffunction learn-works (?name ?type ?rings)
  "Note what a machine can do, when it is first seen. CS1 has grey caps, CS2 black ones."
  (bind ?cap (if (str-index "CS1" ?name) then "CAP_GREY" else "CAP_BLACK"))
  (switch ?type
    (case "DS" then (assert (does (machine ?name) (work "DELIVER"))))
    (case "CS" then (assert (does (machine ?name) (work ?cap)) (cap-station (name ?name) (cap ?cap))))
    (case "RS" then (assert (slide (machine ?name) (spot (str-cat ?name "-SLIDE"))))
                    (foreach ?ring ?rings (assert (does (machine ?name) (work ?ring)))))
    (default none)))

(deffunction zone-x (?zone)
  "The x of the middle of a zone, which is a square of 1 m: 1.5 for C_Z23, -1.5 for M_Z23."
  (* (if (eq (sub-string 1 1 ?zone) "C") then 1 else -1) (- (string-to-field (sub-string 4 4 ?zone)) 0.5)))

(deffunction zone-y (?zone)
  (- (string-to-field (sub-string 5 5 ?zone)) 0.5))

(deffunction learn-machine (?message)
  "Note the state of a machine of our team. Before it takes instructions, we must find and report it. A machine that breaks
   forgets its payments."
  (bind ?name (ros-msgs-get-field ?message "name"))
  (bind ?state (sym-cat (ros-msgs-get-field ?message "state")))
  (if (eq ?state BROKEN) then (do-for-fact ((?s slide)) (eq ?s:machine ?name) (modify ?s (loaded 0))))
  (if (do-for-fact ((?m machine)) (eq ?m:name ?name) (modify ?m (state ?state)) TRUE) then (return))
  (bind ?zone (ros-msgs-get-field ?message "zone"))
  (if (or (eq ?zone "") (and (not (ros-msgs-get-field ?message "correctly_reported"))
                             (eq (ros-msgs-get-field ?message "exploration_zone_state") "NO_REPORT")))
   then (assert (to-find ?name))
        (if (neq ?zone "")
         then (assert (sighting (zone ?zone) (machine ?name) (rotation (ros-msgs-get-field ?message "rotation")))))
        (return))
  (assert (machine (name ?name) (kind (sym-cat (ros-msgs-get-field ?message "type"))) (state ?state)
                   (x (zone-x ?zone)) (y (zone-y ?zone)) (rotation (ros-msgs-get-field ?message "rotation"))))
  (learn-works ?name (ros-msgs-get-field ?message "type") (ros-msgs-get-field ?message "ring_colors")))

(defrule refbox-machine-info
  ?message <- (ros-msgs-message (topic "/machine_info") (msg-ptr ?m))
  =>
  (bind ?machines (ros-msgs-get-field ?m "machines"))
  (bind ?team (ros-msgs-get-field ?m "team_color"))
  (foreach ?machine ?machines
    (if (eq ?team (ros-msgs-get-field ?machine "team_color")) then (learn-machine ?machine))
    (ros-msgs-destroy-message ?machine))
  (assert (we-are (sub-string 1 1 ?team)))
  (ros-msgs-destroy-message ?m)
  (retract ?message))

(defrule refbox-ring-info
  ?message <- (ros-msgs-message (topic "/ring_info") (msg-ptr ?m))
  =>
  (foreach ?ring (ros-msgs-get-field ?m "rings")
    (bind ?price (ros-msgs-get-field ?ring "raw_material"))
    (do-for-fact ((?d does)) (eq ?d:work (ros-msgs-get-field ?ring "ring_color")) (modify ?d (price ?price)))
    (ros-msgs-destroy-message ?ring))
  (ros-msgs-destroy-message ?m)
  (retract ?message))

(deffunction learn-robot (?message ?letter)
  "Note a robot of our team. Robot 1 starts in zone 51, robot 2 in 61, robot 3 in 71."
  (bind ?name (ros-msgs-get-field ?message "name"))
  (bind ?duty (sym-cat (ros-msgs-get-field ?message "state")))
  (bind ?cycles (ros-msgs-get-field ?message "maintenance_cycles"))
  (if (or (do-for-fact ((?r robot)) (eq ?r:name ?name) (modify ?r (duty ?duty) (cycles ?cycles)) TRUE)
          (neq (sub-string 1 1 (ros-msgs-get-field ?message "team_color")) ?letter))
   then (return))
  (bind ?number (ros-msgs-get-field ?message "number"))
  (bind ?home (str-cat ?letter "_Z" (+ 4 ?number) "1"))
  (assert (robot (name ?name) (number ?number) (x (zone-x ?home)) (y (zone-y ?home)) (home ?home) (place ?home)
                 (duty ?duty) (cycles ?cycles))))

(defrule refbox-robot-info
  "The league reports its robots, and we know which team we are: note ours."
  ?message <- (ros-msgs-message (topic "/robot_info") (msg-ptr ?m))
  (we-are ?letter)
  =>
  (bind ?robots (ros-msgs-get-field ?m "robots"))
  (foreach ?r ?robots
    (learn-robot ?r ?letter)
    (ros-msgs-destroy-message ?r))
  (ros-msgs-destroy-message ?m)
  (retract ?message))

; --- What follows from the machines of the game

(defrule shelf-of-cap-station
  (cap-station (name ?name))
  (not (shelf (machine ?name)))
  =>
  (assert (shelf (machine ?name) (spot (str-cat ?name "-SHELF-LEFT")))
          (shelf (machine ?name) (spot (str-cat ?name "-SHELF-MIDDLE")))
          (shelf (machine ?name) (spot (str-cat ?name "-SHELF-RIGHT")))))

(defrule team-counted
  "One of our robots is on the field: count it."
  (robot (name ?name) (state ~OFF-FIELD))
  (not (counted ?name))
  =>
  (assert (counted ?name))
  (if (not (do-for-fact ((?t team)) TRUE (modify ?t (size (+ ?t:size 1))) TRUE)) then (assert (team (size 1)))))

; --- The end: give back what we hold

(defrule finalize-subscriptions
  (executive-finalize)
  (ros-msgs-subscription (topic ?topic))
  =>
  (ros-msgs-destroy-subscription ?topic))

(defrule finalize-action-clients
  (executive-finalize)
  (ros-msgs-action-client (server ?server))
  =>
  (ros-msgs-destroy-action-client ?server))

(defrule finalize-goals
  (executive-finalize)
  (or (command (goal ?goal&~NONE)) (instruction (goal ?goal&~NONE)))
  =>
  (ros-msgs-destroy-message ?goal))

(defrule finalize-goal-handles
  (executive-finalize)
  (or (command (handle ?handle&~NONE)) (instruction (handle ?handle&~NONE)))
  =>
  (ros-msgs-destroy-client-goal-handle ?handle))
