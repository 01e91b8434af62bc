; The objects of a type.

(defrule pddl-ask-type-objects
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-get-type-objects (instance ?instance) (type ?type) (state PENDING))
  (time ?)
  =>
  (bind ?request (pddl-request GetTypeObjects ?instance nil))
  (ros-msgs-set-field ?request "type" (str-cat ?type))
  (if (pddl-send ?node "get_type_objects" ?request ?i GET-TYPE-OBJECTS type-objects ?instance ?ask ?type)
   then (pddl-becomes ?ask WAITING "")))

(defrule pddl-answer-type-objects
  ?note <- (pddl-asked ?service ?id ?i type-objects ?instance ?ask ?type)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (eq ?error "") then
    (do-for-all-facts ((?f pddl-type-objects)) (and (eq ?f:instance ?instance) (eq ?f:type ?type)) (retract ?f))
    (assert (pddl-type-objects (instance ?instance) (type ?type) (objects (ros-msgs-get-field ?message "objects")))))
  (pddl-close ?ask ?error)
  (pddl-answered ?i ?message ?response ?note))
