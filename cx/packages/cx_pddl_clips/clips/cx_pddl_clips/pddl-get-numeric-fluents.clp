; All numbers.

(defrule pddl-ask-numeric-fluents
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-get-numeric-fluents (instance ?instance) (state PENDING))
  (time ?)
  =>
  (if (pddl-send ?node "get_functions" (pddl-request GetFunctions ?instance nil) ?i GET-NUMERIC-FLUENTS functions ?instance ?ask)
   then (pddl-becomes ?ask WAITING "")))

(defrule pddl-answer-numeric-fluents
  ?note <- (pddl-asked ?service ?id ?i functions ?instance ?ask)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (eq ?error "") then
    (bind ?now (create$))
    (foreach ?function (ros-msgs-get-field ?message "functions")
      (bind ?now (create$ ?now (assert (pddl-numeric-fluent (instance ?instance) (name (sym-cat (ros-msgs-get-field ?function "name")))
                                                             (params (pddl-symbols (ros-msgs-get-field ?function "args")))
                                                             (value (float (ros-msgs-get-field ?function "value"))))))))
    (do-for-all-facts ((?f pddl-numeric-fluent)) (and (eq ?f:instance ?instance) (not (member$ ?f ?now))) (retract ?f)))
  (pddl-close ?ask ?error)
  (pddl-answered ?i ?message ?response ?note))
