; Objects that come and go.

(defrule pddl-send-object-change
  (declare (salience ?*PRIORITY-PDDL-OBJECTS*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?change <- (pddl-object-change (instance ?instance) (name ?name) (type ?type) (delete ?delete) (state PENDING))
  (time ?)
  =>
  (bind ?object (ros-msgs-create-message "cx_pddl_interfaces/msg/Object"))
  (ros-msgs-set-field ?object "pddl_instance" (str-cat ?instance))
  (ros-msgs-set-field ?object "name" (str-cat ?name))
  (if (neq ?type nil) then (ros-msgs-set-field ?object "type" (str-cat ?type)))
  (bind ?request (pddl-request (if ?delete then RemoveObjects else AddObjects) nil nil))
  (ros-msgs-set-field ?request "objects" (create$ ?object))
  (ros-msgs-destroy-message ?object)
  (bind ?id (pddl-send ?node (if ?delete then "rm_objects" else "add_objects") ?request ?i OBJECTS object-change ?instance ?change ?name ?delete))
  (if ?id then (pddl-waits ?change ?id)))

(defrule pddl-object-changed
  ?note <- (pddl-asked ?service ?id ?i object-change ?instance ?change ?name ?delete)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (neq ?error "") then (pddl-becomes ?change ERROR ?error) else (if (fact-existp ?change) then (retract ?change)))
  (if (and ?delete (eq ?error "")) then
    (do-for-all-facts ((?f pddl-fluent)) (and (eq ?f:instance ?instance) (member$ (sym-cat ?name) ?f:params)) (retract ?f))
    (do-for-all-facts ((?f pddl-numeric-fluent)) (and (eq ?f:instance ?instance) (member$ (sym-cat ?name) ?f:params)) (retract ?f)))
  (pddl-answered ?i ?message ?response ?note))
