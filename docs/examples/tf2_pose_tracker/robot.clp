; Stands in for a robot: says where it is, and where its gripper is on it.

(deffunction publish-transform (?topic ?parent ?child ?t ?x ?y)
  "One transform without rotation. A message that is set into another is copied."
  (bind ?stamped (ros-msgs-create-message "geometry_msgs/msg/TransformStamped"))
  (bind ?header (ros-msgs-get-field ?stamped "header"))
  (bind ?stamp (ros-msgs-get-field ?header "stamp"))
  (ros-msgs-set-field ?stamp "sec" (integer ?t))
  (ros-msgs-set-field ?stamp "nanosec" (round (* 1000000000 (- ?t (integer ?t)))))
  (ros-msgs-set-field ?header "frame_id" ?parent)
  (ros-msgs-set-field ?stamped "child_frame_id" ?child)
  (bind ?transform (ros-msgs-get-field ?stamped "transform"))
  (bind ?translation (ros-msgs-get-field ?transform "translation"))
  (ros-msgs-set-field ?translation "x" ?x)
  (ros-msgs-set-field ?translation "y" ?y)
  (bind ?message (ros-msgs-create-message "tf2_msgs/msg/TFMessage"))
  (ros-msgs-set-field ?message "transforms" (create$ ?stamped))
  (ros-msgs-publish ?message ?topic)
  (ros-msgs-destroy-message ?message)
  (ros-msgs-destroy-message ?stamped))

(deffacts start (open))

(defrule open
  "At the start: the gripper is 0.3 m in front of the robot, for good."
  (open)
  =>
  (ros-msgs-create-publisher "/tf" "tf2_msgs/msg/TFMessage")
  (ros-msgs-create-publisher "/tf_static" "tf2_msgs/msg/TFMessage")
  (publish-transform "/tf_static" "robot" "gripper" 0.0 0.3 0.0))

(defrule drive
  "At each refresh the robot is further along x, at 0.5 m/s."
  (time ?t)
  =>
  (publish-transform "/tf" "map" "robot" ?t (* 0.5 ?t) 1.0))

(defrule close
  "The executive ends: close what is open."
  (executive-finalize)
  =>
  (ros-msgs-destroy-publisher "/tf")
  (ros-msgs-destroy-publisher "/tf_static"))
