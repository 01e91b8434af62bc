; Turns the turtle to each visitor, and draws with a thick pen once it has. One condition is wrong on purpose: docs/tutorials/bag-to-story.md
; finds it in a recording.

(deftemplate visitor
  "Somebody has come and waits."
  (slot direction (type FLOAT)))

(deffacts start (open))

(defrule open
  "At the start the agent subscribes to visitors, and becomes able to turn the turtle."
  (open)
  =>
  (ros-msgs-create-subscription "visitor" "std_msgs/msg/Float32")
  (ros-msgs-create-action-client "turtle1/rotate_absolute" "turtlesim/action/RotateAbsolute")
  (ros-msgs-create-client "turtle1/set_pen" "turtlesim/srv/SetPen"))

(defrule hear-visitor
  "A message has come: remember the visitor, and drop the message."
  ?heard <- (ros-msgs-message (topic "visitor") (msg-ptr ?message))
  =>
  (assert (visitor (direction (ros-msgs-get-field ?message "data"))))
  (ros-msgs-destroy-message ?message)
  (retract ?heard))

(defrule turn-to-visitor
  "A visitor waits and the turtle stands: turn it."
  ?visitor <- (visitor (direction ?direction&:(> ?direction 0.0)))
  (not (turning))
  =>
  (bind ?goal (ros-msgs-create-goal-request "turtlesim/action/RotateAbsolute"))
  (ros-msgs-set-field ?goal "theta" ?direction)
  (ros-msgs-async-send-goal ?goal "turtle1/rotate_absolute")
  (ros-msgs-destroy-message ?goal)
  (assert (turning))
  (retract ?visitor))

(defrule drop-feedback
  "How far the turtle has turned is of no interest."
  ?feedback <- (ros-msgs-feedback (server "turtle1/rotate_absolute") (feedback-ptr ?message))
  =>
  (ros-msgs-destroy-message ?message)
  (retract ?feedback))

(defrule greet
  "The turtle looks at the visitor: ask for a thick pen."
  ?result <- (ros-msgs-wrapped-result (server "turtle1/rotate_absolute") (code SUCCEEDED) (result-ptr ?message))
  ?response <- (ros-msgs-goal-response (server "turtle1/rotate_absolute") (client-goal-handle-ptr ?handle))
  ?turning <- (turning)
  =>
  (bind ?request (ros-msgs-create-request "turtlesim/srv/SetPen"))
  (ros-msgs-set-field ?request "width" 5)
  (ros-msgs-async-send-request ?request "turtle1/set_pen")
  (ros-msgs-destroy-message ?request)
  (ros-msgs-destroy-message ?message)
  (ros-msgs-destroy-client-goal-handle ?handle)
  (retract ?result ?response ?turning))

(defrule visitor-is-greeted
  "The pen is thick."
  ?response <- (ros-msgs-response (service "turtle1/set_pen") (msg-ptr ?message))
  =>
  (printout info "a visitor is greeted" crlf)
  (ros-msgs-destroy-message ?message)
  (retract ?response))

(defrule close
  "The executive ends: close what is open."
  (executive-finalize)
  =>
  (ros-msgs-destroy-subscription "visitor")
  (ros-msgs-destroy-action-client "turtle1/rotate_absolute")
  (ros-msgs-destroy-client "turtle1/set_pen"))
