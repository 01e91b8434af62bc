; Steps become jobs of robots and instructions of machines. Their reports become effects.

(deffunction apply-effects (?action ?time)
  "Apply the effects of an action at START, at END or both (ALL)."
  (assert (effects (number (new-id)) (action ?action) (time ?time))))

(deffunction apply-action (?name ?params)
  "Apply an instantaneous action: a part of a coarse one, or a failure."
  (bind ?id (gensym*))
  (assert (pddl-action (instance production) (id ?id) (plan part) (name ?name) (params ?params)))
  (apply-effects ?id ALL))

(deffunction apply-part (?action ?part ?params)
  (apply-action (sym-cat ?action - ?part) ?params))

(defrule effects-next
  "Effects wait: apply them action by action in the order of events, so that a failure frees what its step has claimed."
  (declare (salience 10))
  (effects (number ?number) (action ?action) (time ?time))
  (not (effects (number ?earlier&:(< ?earlier ?number))))
  (not (pddl-action-get-effect (action ?action) (effect-type ?time)))
  =>
  (assert (pddl-action-get-effect (action ?action) (effect-type ?time) (apply TRUE))))

(defrule effects-known
  (declare (salience 10))
  ?effects <- (effects (action ?action) (time ?time))
  (pddl-action-get-effect (action ?action) (effect-type ?time) (state DONE|ERROR))
  =>
  (retract ?effects))

(defrule effects-applied
  "Effects were applied, so the world has changed: steps that were held back are looked at again."
  (planning (state ~END))
  ?effect <- (pddl-action-get-effect (action ?action) (state DONE|ERROR))
  (not (pddl-fluent-change (instance production)))
  (not (pddl-numeric-fluent-change (instance production)))
  =>
  (retract ?effect)
  (look-again)
  (do-for-all-facts ((?a pddl-action)) (and (eq ?a:id ?action) (eq ?a:plan part)) (retract ?a)))

(deffunction add-step (?action ?params)
  "Add a step with its PDDL action; returns its fact."
  (bind ?id (gensym*))
  (assert (pddl-action (instance production) (id ?id) (plan current) (name ?action) (params ?params)))
  (assert (step (id ?id) (action ?action) (params ?params) (worker (worker-of ?action)))))

; --- Robots

(deffunction full-shelf-spot (?machine)
  "The first slot of the shelf that has a carrier."
  (bind ?first "")
  (do-for-all-facts ((?s shelf)) (and (eq ?s:machine ?machine) (eq ?s:state FULL))
    (if (or (eq ?first "") (< (str-compare ?s:spot ?first) 0)) then (bind ?first ?s:spot)))
  ?first)

(deffunction robot-job (?purpose ?order ?from ?to $?held-up)
  (bind ?id (create-job ?purpose 3 ?order ?from ?to))
  (hold-up ?id ?held-up)
  ?id)

(deffunction ring-of (?order ?step)
  (do-for-fact ((?o order)) (= ?o:id ?order) (return (nth$ (+ 1 (string-to-field (sub-string 2 2 ?step))) ?o:rings)))
  "")

(deffunction instruct (?machine ?operation ?color ?order)
  (bind ?id (new-id))
  (assert (instruction (id ?id) (machine ?machine) (operation ?operation) (color ?color) (order ?order)))
  ?id)

(deffunction instruct-delivery (?station ?order)
  "Have the product of an order delivered, unless the station was told so already; returns the number of the instruction."
  (delayed-do-for-all-facts ((?i instruction)) (and (eq ?i:operation "DELIVER") (= ?i:order ?order))
    (if (neq ?i:state FAILED) then (return ?i:id))
    (retract ?i))
  (instruct ?station "DELIVER" "" ?order))

(deffunction begin-work (?action ?params)
  "Begin the job or instruction of an action; returns its number."
  (bind ?a (nth$ 1 ?params))
  (bind ?b (if (> (length$ ?params) 1) then (machine-named (nth$ 2 ?params)) else ""))
  (bind ?c (if (> (length$ ?params) 2) then (machine-named (nth$ 3 ?params)) else ""))
  (bind ?m (machine-named ?a))
  (switch ?action
    (case bring-base then (robot-job MOVE (order-of ?a) (output-of ?b) (input-of ?c) GO-FETCH FETCH))
    (case transport then (robot-job MOVE (order-of ?a) (output-of ?b) (input-of ?c)))
    (case bring-to-delivery then (robot-job MOVE (order-of ?a) (output-of ?b) (input-of ?c)))
    (case fetch-carrier then
      (bind ?spot (full-shelf-spot ?m))
      (do-for-fact ((?s shelf)) (eq ?s:spot ?spot) (modify ?s (state TAKEN)))
      (robot-job BUFFER 0 ?spot (input-of ?m)))
    (case pay-with-bare-base then (robot-job CLEAR 0 (output-of ?m) (str-cat ?b "-SLIDE")))
    (case discard-bare-base then (robot-job CLEAR 0 (output-of ?m) (input-of ?b)))
    (case pay-with-new-base then (robot-job PAY 0 (output-of ?m) (str-cat ?b "-SLIDE") GO-FETCH FETCH))
    (case retrieve-cap then (instruct ?m "RETRIEVE_CAP" "" 0))
    (case mount-ring then (instruct ?b "MOUNT_RING" (ring-of (order-of ?a) (nth$ 3 ?params)) 0))
    (case mount-cap then (instruct ?b "MOUNT_CAP" "" 0))
    (case deliver then (instruct-delivery ?b (order-of ?a)))
    (default 0)))

(defrule work-at-once
  "Nothing holds the piece up: one skill drives there, fetches the piece and brings it."
  (declare (salience 10))
  ?job <- (job (id ?id) (step GO-FETCH) (moving NO) (robot ~""))
  (not (held-up (job ?id)))
  (not (trouble (job ?id)))
  (test (eq ?*TRANSPORT* TRUE))
  =>
  (modify ?job (step FETCH)))

(defrule work-picked
  "A robot has picked up the piece of its step: note it at once, because a job with waste is soon forgotten."
  (declare (salience 10))
  (step (id ?id) (action ?action) (params $?params) (state RUNNING) (worker ROBOT) (work ?work))
  (job (id ?work) (step GO-PUT|PUT|DONE))
  (not (picked ?id))
  =>
  (assert (picked ?id))
  (if ?*SUB-ACTIONS* then (apply-part ?action pick ?params)))

(defrule work-deliver-at-once
  "A product has come to the idle delivery station: instruct the station before the PDDL manager has been asked, because
   somebody may take what lies on the belt."
  (declare (salience 10))
  (step (action bring-to-delivery) (params ?product ? ?ds ?) (state RUNNING) (work ?work))
  (job (id ?work) (step DONE) (purpose MOVE))
  (machine (name =(machine-named ?ds)) (state IDLE))
  =>
  (instruct-delivery (machine-named ?ds) (order-of ?product)))

(deffunction piece-placed (?step ?id)
  "Note that the piece of a step lies at its place: the step is done."
  (do-for-all-facts ((?p picked)) (eq ?p:implied (create$ ?id)) (retract ?p))
  (note-brought (fact-slot-value ?step action))
  (if ?*SUB-ACTIONS*
   then (apply-part (fact-slot-value ?step action) place (fact-slot-value ?step params))
   else (apply-effects ?id END))
  (modify ?step (state DONE)))

(defrule work-placed
  "The job of a step is done: the piece lies at its place."
  ?step <- (step (id ?id) (action ~discard-bare-base) (state RUNNING) (worker ROBOT) (work ?work))
  ?job <- (job (id ?work) (step DONE) (robot ""))
  =>
  (retract ?job)
  (piece-placed ?step ?id))

(defrule work-discarded
  "The delivery station has thrown the base away: the step is done."
  ?step <- (step (id ?id) (action discard-bare-base) (state RUNNING) (work ?work))
  ?instruction <- (instruction (id ?work) (operation "DELIVER") (state SUCCEEDED|FAILED))
  (picked ?id)
  =>
  (retract ?instruction)
  (piece-placed ?step ?id))

(defrule work-waste-gone
  "A piece of no step was thrown away, and nobody had reserved the delivery station for it: forget the instruction."
  ?instruction <- (instruction (id ?work) (operation "DELIVER") (order 0) (state SUCCEEDED|FAILED))
  (not (reserved (job ?work)))
  (not (step (work ?work)))
  =>
  (retract ?instruction))

; --- Machines

(defrule work-instructed
  "The machine has done its work: apply the effects, and the step is done."
  ?step <- (step (id ?id) (state RUNNING) (worker MACHINE) (work ?work))
  ?instruction <- (instruction (id ?work) (state SUCCEEDED))
  =>
  (retract ?instruction)
  (apply-effects ?id END)
  (modify ?step (state DONE)))

(defrule work-delivered
  (step (action deliver) (params ?product $?) (state DONE))
  ?order <- (order (id ?id&:(eq ?product (product-of ?id))) (state ~DONE))
  =>
  (modify ?order (state DONE))
  (assert (product-done ?id)))

; --- The agent itself

(defrule work-window-near
  ?step <- (step (id ?id) (action wait-for-window) (params ?product) (state RUNNING))
  (order (id ?o&:(eq ?product (product-of ?o))) (begin ?begin))
  (game (begin ?zero))
  (time ?now&:(>= ?now (- (+ ?zero ?begin) ?*WINDOW-LEAD*)))
  =>
  (apply-effects ?id END)
  (modify ?step (state DONE)))

(defrule work-in-order
  "The machine of a waiting step works: the wait is over."
  ?step <- (step (id ?id) (action wait-until-it-works) (params ?name) (state RUNNING))
  (pddl-fluent (instance production) (name working) (params ?name))
  =>
  (apply-effects ?id END)
  (modify ?step (state DONE)))

(defrule work-forgotten
  "A step is done and no other step waits for it: forget it."
  (planning (state IDLE))
  ?step <- (step (id ?id) (action ~deliver) (state DONE) (group ?group))
  (not (waits-for (for ?id)))
  (not (step (state ~DONE) (group ?g&:(<= ?g ?group))))
  (not (effects (action ?id)))
  (not (pddl-action-get-effect (action ?id)))
  =>
  (do-for-all-facts ((?a pddl-action)) (eq ?a:id ?id) (retract ?a))
  (retract ?step))
