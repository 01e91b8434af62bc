; Numbers that change, in one request like fluents.

(deffunction pddl-take-number (?instance ?name ?params ?value)
  "Set the fact of a numeric fluent to that value; returns the fact."
  (bind ?symbol (sym-cat ?name))
  (bind ?symbols (pddl-symbols ?params))
  (do-for-fact ((?f pddl-numeric-fluent)) (and (eq ?f:name ?symbol) (eq ?f:params ?symbols) (eq ?f:instance ?instance))
    (return (modify ?f (value (float ?value)))))
  (assert (pddl-numeric-fluent (instance ?instance) (name ?symbol) (params ?symbols) (value (float ?value)))))

(defrule pddl-send-numeric-changes
  (declare (salience ?*PRIORITY-PDDL-FLUENTS*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?change <- (pddl-numeric-fluent-change (instance ?instance) (state PENDING))
  (time ?)
  =>
  (bind ?changes (if (pddl-was-refused ?change) then (create$ ?change) else
    (find-all-facts ((?c pddl-numeric-fluent-change)) (and (eq ?c:instance ?instance) (eq ?c:state PENDING) (not (pddl-was-refused ?c))))))
  (pddl-send-changes ?node "set_functions" (pddl-request SetFunctions nil nil) "functions" (pddl-change-messages Function ?changes) ?changes
                     ?i NUMERIC-FLUENTS numeric-changes ?instance))

(defrule pddl-numbers-changed
  ?note <- (pddl-asked ?service ?id ?i numeric-changes ?instance)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (bind ?changes (find-all-facts ((?c pddl-numeric-fluent-change)) (and (eq ?c:instance ?instance) (eq ?c:state WAITING))))
  (do-for-all-facts ((?c pddl-numeric-fluent-change)) (and (eq ?c:instance ?instance) (eq ?c:state WAITING))
    (if (neq ?error "") then (pddl-refuse ?c ?error (> (length$ ?changes) 1))
     else
      (pddl-take-number ?instance ?c:name ?c:params ?c:value)
      (retract ?c)))
  (pddl-close-changes)
  (pddl-answered ?i ?message ?response ?note))
