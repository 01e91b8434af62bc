; Fluents that become true or false. All that are pending go in one request, deletes first. What the manager refuses is tried
; again one at a time, so that a wrong change does not hold up the others.

(defrule pddl-drop-fluent
  "A fluent is no longer true: remove its fact before any other rule fires."
  (declare (salience 10000))
  (pddl-dropped ?instance ?name $?params)
  ?fluent <- (pddl-fluent (instance ?instance) (name ?name) (params $?params))
  =>
  (retract ?fluent))

(defrule pddl-dropped-done
  (declare (salience 9999))
  ?dropped <- (pddl-dropped $?)
  =>
  (retract ?dropped))

(defrule pddl-send-fluent-changes
  (declare (salience ?*PRIORITY-PDDL-FLUENTS*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?change <- (pddl-fluent-change (instance ?instance) (delete ?delete) (state PENDING))
  (or (test (eq ?delete TRUE))
      (not (pddl-fluent-change (instance ?instance) (delete TRUE) (state PENDING))))
  (time ?)
  =>
  (bind ?changes (if (pddl-was-refused ?change) then (create$ ?change) else
    (find-all-facts ((?c pddl-fluent-change)) (and (eq ?c:instance ?instance) (eq ?c:delete ?delete) (eq ?c:state PENDING) (not (pddl-was-refused ?c))))))
  (pddl-send-changes ?node (if ?delete then "rm_fluents" else "add_fluents") (pddl-request (if ?delete then RemoveFluents else AddFluents) nil nil)
                     "fluents" (pddl-change-messages Fluent ?changes) ?changes ?i FLUENTS fluent-changes ?instance))

(defrule pddl-fluents-changed
  ?note <- (pddl-asked ?service ?id ?i fluent-changes ?instance)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (bind ?changes (find-all-facts ((?c pddl-fluent-change)) (and (eq ?c:instance ?instance) (eq ?c:state WAITING))))
  (do-for-all-facts ((?c pddl-fluent-change)) (and (eq ?c:instance ?instance) (eq ?c:state WAITING))
    (if (neq ?error "") then (pddl-refuse ?c ?error (> (length$ ?changes) 1))
     else
      (if ?c:delete then (assert (pddl-dropped ?instance (sym-cat ?c:name) (pddl-symbols ?c:params)))
       else (assert (pddl-fluent (instance ?instance) (name (sym-cat ?c:name)) (params (pddl-symbols ?c:params)))))
      (retract ?c)))
  (pddl-close-changes)
  (pddl-answered ?i ?message ?response ?note))
