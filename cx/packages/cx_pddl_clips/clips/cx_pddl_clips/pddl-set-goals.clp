; A goal instance gets the goals that its pddl-goal-fluent and pddl-goal-numeric-fluent facts say.

(defrule pddl-send-set-goals
  (declare (salience ?*PRIORITY-PDDL-SET-GOALS*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-set-goals (instance ?instance) (goal ?goal) (state PENDING))
  (time ?)
  =>
  (bind ?fluents (create$))
  (do-for-all-facts ((?g pddl-goal-fluent)) (and (eq ?g:instance ?instance) (eq ?g:goal ?goal))
    (bind ?fluents (create$ ?fluents (pddl-message Fluent ?instance ?g:name ?g:params))))
  (bind ?functions (create$))
  (do-for-all-facts ((?g pddl-goal-numeric-fluent)) (and (eq ?g:instance ?instance) (eq ?g:goal ?goal))
    (bind ?function (pddl-message Function ?instance ?g:name ?g:params))
    (ros-msgs-set-field ?function "value" (float ?g:value))
    (bind ?functions (create$ ?functions ?function)))
  (bind ?request (pddl-request SetGoals nil ?goal))
  (ros-msgs-set-field ?request "fluents" ?fluents)
  (ros-msgs-set-field ?request "functions" ?functions)
  (foreach ?part (create$ ?fluents ?functions) (ros-msgs-destroy-message ?part))
  (if (pddl-send ?node "set_goals" ?request ?i SET-GOALS set-goals ?ask)
   then (pddl-becomes ?ask WAITING "")))

(defrule pddl-goals-were-set
  ?note <- (pddl-asked ?service ?id ?i set-goals ?ask)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (pddl-close ?ask (pddl-error-of ?message))
  (pddl-answered ?i ?message ?response ?note))
