; A new goal instance.

(defrule pddl-send-create-goal-instance
  (declare (salience ?*PRIORITY-PDDL-CREATE-GOAL-INSTANCE*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-create-goal-instance (instance ?instance) (goal ?goal) (state PENDING))
  (time ?)
  =>
  (if (pddl-send ?node "create_goal_instance" (pddl-request CreateGoalInstance ?instance ?goal) ?i CREATE-GOAL-INSTANCE create-goal-instance ?ask)
   then (pddl-becomes ?ask WAITING "")))

(defrule pddl-goal-instance-created
  ?note <- (pddl-asked ?service ?id ?i create-goal-instance ?ask)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (pddl-close ?ask (pddl-error-of ?message))
  (pddl-answered ?i ?message ?response ?note))
