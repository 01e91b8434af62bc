; What the planner sees of an instance. The fact goes when it was answered; an error is told.

(deffunction pddl-send-filter (?node ?i ?filter ?instance ?goal ?names ?service ?type ?field ?busy)
  (bind ?request (pddl-request ?type ?instance ?goal))
  (ros-msgs-set-field ?request ?field (pddl-strings ?names))
  (pddl-send ?node ?service ?request ?i ?busy filter ?filter))

(defrule pddl-send-action-filter
  (declare (salience ?*PRIORITY-PDDL-SET-ACTION-FILTER*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?f <- (pddl-planning-filter (type ACTIONS) (instance ?instance) (goal ?goal) (filter $?names))
  (time ?)
  =>
  (pddl-send-filter ?node ?i ?f ?instance ?goal ?names "set_action_filter" SetActionFilter "actions" SET-ACTION-FILTER))

(defrule pddl-send-fluent-filter
  (declare (salience ?*PRIORITY-PDDL-SET-FLUENT-FILTER*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?f <- (pddl-planning-filter (type FLUENTS) (instance ?instance) (goal ?goal) (filter $?names))
  (time ?)
  =>
  (pddl-send-filter ?node ?i ?f ?instance ?goal ?names "set_fluent_filter" SetFluentFilter "fluents" SET-FLUENT-FILTER))

(defrule pddl-send-object-filter
  (declare (salience ?*PRIORITY-PDDL-SET-OBJECT-FILTER*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?f <- (pddl-planning-filter (type OBJECTS) (instance ?instance) (goal ?goal) (filter $?names))
  (time ?)
  =>
  (pddl-send-filter ?node ?i ?f ?instance ?goal ?names "set_object_filter" SetObjectFilter "objects" SET-OBJECT-FILTER))

(defrule pddl-filter-answered
  ?note <- (pddl-asked ?service ?id ?i filter ?filter)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (eq ?error "") then (printout green TRUE " " ?error crlf) else (printout error "pddl-planning-filter: " ?error crlf))
  (if (fact-existp ?filter) then (retract ?filter))
  (pddl-answered ?i ?message ?response ?note))
