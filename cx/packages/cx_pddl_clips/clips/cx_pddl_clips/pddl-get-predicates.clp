; The predicates of a domain.

(defrule pddl-ask-predicates
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-get-predicates (instance ?instance) (state PENDING))
  (time ?)
  =>
  (if (pddl-send ?node "get_predicates" (pddl-request GetPredicates ?instance nil) ?i GET-PREDICATES predicates ?instance ?ask)
   then (pddl-becomes ?ask WAITING "")))

(defrule pddl-answer-predicates
  ?note <- (pddl-asked ?service ?id ?i predicates ?instance ?ask)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (foreach ?predicate (ros-msgs-get-field ?message "predicates")
    (assert (pddl-predicate (instance ?instance) (name (sym-cat (ros-msgs-get-field ?predicate "name")))
                            (param-types (pddl-symbols (ros-msgs-get-field ?predicate "param_types")))
                            (param-names (pddl-symbols (ros-msgs-get-field ?predicate "param_names"))))))
  (pddl-close ?ask ?error)
  (pddl-answered ?i ?message ?response ?note))
