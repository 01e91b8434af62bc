; May a step begin now?

(defrule pddl-send-condition
  (declare (salience ?*PRIORITY-PDDL-CHECK-CONDITION*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-action-condition (instance ?instance) (action ?action) (state PENDING))
  (pddl-action (instance ?instance) (id ?action) (plan ?plan&:(pddl-agrees ?ask plan ?plan)) (name ?name) (params $?params))
  (time ?)
  =>
  (bind ?message (pddl-message Action ?instance ?name ?params))
  (bind ?request (pddl-request CheckActionCondition nil nil))
  (ros-msgs-set-field ?request "action" ?message)
  (ros-msgs-destroy-message ?message)
  (if (pddl-send ?node "check_action_condition" ?request ?i CHECK-CONDITIONS condition ?ask)
   then (pddl-becomes ?ask CHECK-CONDITION "")))

(defrule pddl-condition-checked
  ?note <- (pddl-asked ?service ?id ?i condition ?ask)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (bind ?missing (create$))
  (foreach ?condition (ros-msgs-get-field ?message "unsatisfied_conditions") (bind ?missing (create$ ?condition ?missing)))
  (bind ?state (if (ros-msgs-get-field ?message "sat") then CONDITION-SAT else CONDITION-UNSAT))
  (if (fact-existp ?ask) then (modify ?ask (unsatisfied-conditions ?missing)))
  (pddl-becomes ?ask (if (eq ?error "") then ?state else ERROR) ?error)
  (pddl-answered ?i ?message ?response ?note))
