; Instances: a domain and a problem that the manager loads.

(defrule pddl-instance-load
  (declare (salience ?*PRIORITY-PDDL-INSTANCES*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?instance <- (pddl-instance (name ?name) (domain ?domain) (problem ?problem) (directory ?directory) (state PENDING))
  (time ?)
  =>
  (bind ?request (pddl-request AddPddlInstance nil nil))
  (ros-msgs-set-field ?request "name" (str-cat ?name))
  (ros-msgs-set-field ?request "directory" ?directory)
  (ros-msgs-set-field ?request "domain_file" ?domain)
  (ros-msgs-set-field ?request "problem_file" ?problem)
  (if (pddl-send ?node "add_pddl_instance" ?request instance ?name ?instance) then (pddl-becomes ?instance WAITING "")))

(defrule pddl-instance-loaded
  ?note <- (pddl-asked ?service ?id instance ?name ?instance)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (pddl-becomes ?instance (if (eq ?error "") then LOADED else ERROR) ?error)
  (ros-msgs-destroy-message ?message)
  (retract ?response ?note))

(defrule pddl-instance-free
  "It has been answered, and can be asked the next thing."
  (declare (salience 1))
  ?free <- (pddl-free ?name)
  =>
  (retract ?free)
  (do-for-fact ((?i pddl-instance)) (eq ?i:name ?name) (modify ?i (busy-with FALSE))))
