; A goal instance loses its goals.

(defrule pddl-send-clear-goals
  (declare (salience ?*PRIORITY-PDDL-CLEAR-GOALS*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-clear-goals (instance ?instance) (goal ?goal) (state PENDING))
  (time ?)
  =>
  (if (pddl-send ?node "clear_goals" (pddl-request ClearGoals ?instance ?goal) ?i CLEAR-GOALS clear-goals ?ask)
   then (pddl-becomes ?ask WAITING "")))

(defrule pddl-goals-cleared
  ?note <- (pddl-asked ?service ?id ?i clear-goals ?ask)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (pddl-close ?ask (pddl-error-of ?message))
  (pddl-answered ?i ?message ?response ?note))
