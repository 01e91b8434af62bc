; The names of all actions.

(defrule pddl-ask-action-names
  (declare (salience ?*PRIORITY-PDDL-GET-ACTION-NAMES*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-action-names (instance ?instance) (state PENDING))
  (time ?)
  =>
  (if (pddl-send ?node "get_action_names" (pddl-request GetActionNames ?instance nil) ?i GET-ACTION-NAMES action-names ?ask)
   then (pddl-becomes ?ask WAITING "")))

(defrule pddl-answer-action-names
  ?note <- (pddl-asked ?service ?id ?i action-names ?ask)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (fact-existp ?ask) then (modify ?ask (action-names (pddl-symbols (ros-msgs-get-field ?message "action_names")))))
  (pddl-close ?ask ?error)
  (pddl-answered ?i ?message ?response ?note))
