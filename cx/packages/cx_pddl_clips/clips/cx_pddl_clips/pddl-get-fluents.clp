; The fluents that are true now.

(defrule pddl-ask-fluents
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-get-fluents (instance ?instance) (state PENDING))
  (time ?)
  =>
  (if (pddl-send ?node "get_fluents" (pddl-request GetFluents ?instance nil) ?i GET-FLUENTS fluents ?instance ?ask)
   then (pddl-becomes ?ask WAITING "")))

(defrule pddl-answer-fluents
  "The manager has told all fluents of an instance: make the facts the same. Facts that were right stay as they are."
  ?note <- (pddl-asked ?service ?id ?i fluents ?instance ?ask)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (eq ?error "") then
    (bind ?now (create$))
    (foreach ?fluent (ros-msgs-get-field ?message "fluents")
      (bind ?now (create$ ?now (assert (pddl-fluent (instance ?instance) (name (sym-cat (ros-msgs-get-field ?fluent "name")))
                                                     (params (pddl-symbols (ros-msgs-get-field ?fluent "args"))))))))
    (do-for-all-facts ((?f pddl-fluent)) (and (eq ?f:instance ?instance) (not (member$ ?f ?now))) (retract ?f)))
  (pddl-close ?ask ?error)
  (pddl-answered ?i ?message ?response ?note))
