; Figures, their artists, and how the artists come: turtle1 leaves, each figure gets a turtle of its own with its pen.

(deftemplate figure
  (slot name (type SYMBOL))
  (slot turtle (type STRING))
  (slot red (type INTEGER))
  (slot green (type INTEGER))
  (slot blue (type INTEGER))
  (slot state (type SYMBOL) (allowed-values PLANNED SPAWNING SPAWNED PEN-ASKED DRAWING DONE) (default PLANNED))
  (slot corner (type INTEGER) (default 2)))

(deftemplate corner
  "A corner of a figure. The turtle begins at corner 1 and goes to corners 2, 3, ... in turn."
  (slot figure (type SYMBOL))
  (slot number (type INTEGER))
  (slot x (type FLOAT))
  (slot y (type FLOAT)))

(deffacts square
  (figure (name square) (turtle "square") (red 255) (green 220) (blue 120))
  (corner (figure square) (number 1) (x 1.0) (y 1.0))
  (corner (figure square) (number 2) (x 4.5) (y 1.0))
  (corner (figure square) (number 3) (x 4.5) (y 4.5))
  (corner (figure square) (number 4) (x 1.0) (y 4.5))
  (corner (figure square) (number 5) (x 1.0) (y 1.0)))

(deffacts star
  (figure (name star) (turtle "star") (red 255) (green 255) (blue 255))
  (corner (figure star) (number 1) (x 7.500) (y 10.200))
  (corner (figure star) (number 2) (x 5.737) (y 4.773))
  (corner (figure star) (number 3) (x 10.353) (y 8.127))
  (corner (figure star) (number 4) (x 4.647) (y 8.127))
  (corner (figure star) (number 5) (x 9.263) (y 4.773))
  (corner (figure star) (number 6) (x 7.500) (y 10.200)))

(deffacts studio-start
  (studio-open))

(defrule studio-open
  "At the start: open clients of the services by which turtles come and go."
  (studio-open)
  =>
  (ros-msgs-create-client "kill" "turtlesim/srv/Kill")
  (ros-msgs-create-client "spawn" "turtlesim/srv/Spawn"))

(defrule first-turtle-leaves
  "turtle1 stands in the way: have it removed."
  (time ?)
  (ros-msgs-client (service "kill"))
  (not (first-turtle-left))
  =>
  (bind ?request (ros-msgs-create-request "turtlesim/srv/Kill"))
  (ros-msgs-set-field ?request "name" "turtle1")
  (if (ros-msgs-async-send-request ?request "kill") then
    (assert (first-turtle-left)))
  (ros-msgs-destroy-message ?request))

(defrule artist-is-called
  "A figure has no turtle: spawn one where the figure begins. Only one at a time, because the response names no figure."
  (time ?)
  (first-turtle-left)
  (ros-msgs-client (service "spawn"))
  ?figure <- (figure (name ?name) (turtle ?turtle) (state PLANNED))
  (corner (figure ?name) (number 1) (x ?x) (y ?y))
  (not (figure (state SPAWNING)))
  =>
  (bind ?request (ros-msgs-create-request "turtlesim/srv/Spawn"))
  (ros-msgs-set-field ?request "x" ?x)
  (ros-msgs-set-field ?request "y" ?y)
  (ros-msgs-set-field ?request "name" ?turtle)
  (if (ros-msgs-async-send-request ?request "spawn") then
    (modify ?figure (state SPAWNING)))
  (ros-msgs-destroy-message ?request))

(defrule artist-has-come
  "The turtle of a figure has come: open what it needs."
  ?response <- (ros-msgs-response (service "spawn") (msg-ptr ?msg))
  ?figure <- (figure (turtle ?turtle) (state SPAWNING))
  =>
  (ros-msgs-destroy-message ?msg)
  (retract ?response)
  (ros-msgs-create-client (str-cat ?turtle "/set_pen") "turtlesim/srv/SetPen")
  (ros-msgs-create-subscription (str-cat ?turtle "/pose") "turtlesim/msg/Pose")
  (ros-msgs-create-publisher (str-cat ?turtle "/cmd_vel") "geometry_msgs/msg/Twist")
  (modify ?figure (state SPAWNED)))

(defrule artist-asks-for-its-pen
  "A turtle has no pen yet: ask for the pen of its figure."
  (time ?)
  ?figure <- (figure (turtle ?turtle) (state SPAWNED) (red ?r) (green ?g) (blue ?b))
  =>
  (bind ?request (ros-msgs-create-request "turtlesim/srv/SetPen"))
  (ros-msgs-set-field ?request "r" ?r)
  (ros-msgs-set-field ?request "g" ?g)
  (ros-msgs-set-field ?request "b" ?b)
  (ros-msgs-set-field ?request "width" 4)
  (if (ros-msgs-async-send-request ?request (str-cat ?turtle "/set_pen")) then
    (modify ?figure (state PEN-ASKED)))
  (ros-msgs-destroy-message ?request))

(defrule artist-has-its-pen
  "The turtle has its pen: it begins to draw."
  ?figure <- (figure (name ?name) (turtle ?turtle) (state PEN-ASKED))
  ?response <- (ros-msgs-response (service ?service&:(eq ?service (str-cat ?turtle "/set_pen"))) (msg-ptr ?msg))
  =>
  (printout info "drawing the " ?name crlf)
  (ros-msgs-destroy-message ?msg)
  (retract ?response)
  (modify ?figure (state DRAWING)))

(defrule drop-answer-of-kill
  "turtle1 has left: drop the answer."
  ?response <- (ros-msgs-response (service "kill") (msg-ptr ?msg))
  =>
  (ros-msgs-destroy-message ?msg)
  (retract ?response))
