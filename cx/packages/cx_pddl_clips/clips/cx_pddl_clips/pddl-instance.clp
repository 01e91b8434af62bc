; Instances: a domain and a problem that the manager loads.

(defrule pddl-instance-load
  (declare (salience ?*PRIORITY-PDDL-INSTANCES*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?name) (domain ?domain) (problem ?problem) (directory ?directory) (state PENDING))
  (time ?)
  =>
  (bind ?request (pddl-request AddPddlInstance nil nil))
  (ros-msgs-set-field ?request "name" (str-cat ?name))
  (ros-msgs-set-field ?request "directory" ?directory)
  (ros-msgs-set-field ?request "domain_file" ?domain)
  (ros-msgs-set-field ?request "problem_file" ?problem)
  (if (pddl-send ?node "add_pddl_instance" ?request ?i FALSE instance) then (pddl-becomes ?i WAITING "")))

(defrule pddl-instance-loaded
  ?note <- (pddl-asked ?service ?id ?i instance)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (pddl-becomes ?i (if (eq ?error "") then LOADED else ERROR) ?error)
  (pddl-answered ?i ?message ?response ?note))
