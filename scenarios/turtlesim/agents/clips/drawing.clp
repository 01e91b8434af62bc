; How a turtle goes from corner to corner: it turns on the spot, then goes ahead and corrects its heading on the way.

(defglobal
  ?*CLOSE* = 0.02
  ?*ALIGNED* = 0.02
  ?*TURN-GAIN* = 5.0
  ?*TURN-MAX* = 2.5
  ?*SPEED-GAIN* = 4.0
  ?*SPEED-MAX* = 2.0)

(deffunction limited (?value ?most)
  (max (- 0 ?most) (min ?most ?value)))

(deffunction heading-error (?theta ?dx ?dy)
  "The angle from the heading ?theta to the direction ?dx ?dy, rad."
  (bind ?length (max 1e-9 (sqrt (+ (* ?dx ?dx) (* ?dy ?dy)))))
  (bind ?ahead (/ (+ (* (cos ?theta) ?dx) (* (sin ?theta) ?dy)) ?length))
  (bind ?left (/ (- (* (cos ?theta) ?dy) (* (sin ?theta) ?dx)) ?length))
  (bind ?angle (acos (limited ?ahead 1.0)))
  (if (< ?left 0) then (- 0 ?angle) else ?angle))

(deffunction drive (?turtle ?speed ?turn)
  (bind ?linear (ros-msgs-create-message "geometry_msgs/msg/Vector3"))
  (ros-msgs-set-field ?linear "x" ?speed)
  (bind ?angular (ros-msgs-create-message "geometry_msgs/msg/Vector3"))
  (ros-msgs-set-field ?angular "z" ?turn)
  (bind ?twist (ros-msgs-create-message "geometry_msgs/msg/Twist"))
  (ros-msgs-set-field ?twist "linear" ?linear)
  (ros-msgs-set-field ?twist "angular" ?angular)
  (ros-msgs-publish ?twist (str-cat ?turtle "/cmd_vel"))
  (ros-msgs-destroy-message ?linear)
  (ros-msgs-destroy-message ?angular)
  (ros-msgs-destroy-message ?twist))

(deffunction drive-towards (?turtle ?x ?y ?theta ?goal-x ?goal-y)
  "Steer a turtle towards a corner. Returns TRUE when the turtle is there."
  (bind ?dx (- ?goal-x ?x))
  (bind ?dy (- ?goal-y ?y))
  (bind ?distance (sqrt (+ (* ?dx ?dx) (* ?dy ?dy))))
  (if (< ?distance ?*CLOSE*) then (return TRUE))
  (bind ?error (heading-error ?theta ?dx ?dy))
  (bind ?speed (if (< (abs ?error) ?*ALIGNED*) then (min ?*SPEED-MAX* (* ?*SPEED-GAIN* ?distance)) else 0.0))
  (drive ?turtle ?speed (limited (* ?*TURN-GAIN* ?error) ?*TURN-MAX*))
  FALSE)

(defrule drop-older-pose
  "A newer pose of the turtle has come: drop the older one."
  ?newer <- (ros-msgs-message (topic ?topic))
  ?older <- (ros-msgs-message (topic ?topic) (msg-ptr ?msg))
  (test (< (fact-index ?older) (fact-index ?newer)))
  =>
  (ros-msgs-destroy-message ?msg)
  (retract ?older))

(defrule draw-towards-corner
  "A drawing turtle has sent its pose: steer it to its next corner; when it is there, go on to the corner after that."
  ?figure <- (figure (name ?name) (turtle ?turtle) (state DRAWING) (corner ?number))
  (corner (figure ?name) (number ?number) (x ?goal-x) (y ?goal-y))
  ?pose <- (ros-msgs-message (topic ?topic&:(eq ?topic (str-cat ?turtle "/pose"))) (msg-ptr ?msg))
  (not (ros-msgs-message (topic ?topic) (msg-ptr ~?msg)))
  =>
  (bind ?there (drive-towards ?turtle (ros-msgs-get-field ?msg "x") (ros-msgs-get-field ?msg "y") (ros-msgs-get-field ?msg "theta")
                              ?goal-x ?goal-y))
  (ros-msgs-destroy-message ?msg)
  (retract ?pose)
  (if ?there then (modify ?figure (corner (+ ?number 1)))))

(defrule figure-is-done
  "No corner is left: the figure is done."
  ?figure <- (figure (name ?name) (turtle ?turtle) (state DRAWING) (corner ?number))
  (not (corner (figure ?name) (number ?number)))
  =>
  (printout info "the " ?name " is done" crlf)
  (drive ?turtle 0.0 0.0)
  (ros-msgs-destroy-subscription (str-cat ?turtle "/pose"))
  (ros-msgs-destroy-publisher (str-cat ?turtle "/cmd_vel"))
  (ros-msgs-destroy-client (str-cat ?turtle "/set_pen"))
  (modify ?figure (state DONE)))

(defrule drop-pose-of-idle-turtle
  "A turtle that does not draw has sent its pose: drop it."
  ?pose <- (ros-msgs-message (topic ?topic) (msg-ptr ?msg))
  (not (and (figure (turtle ?turtle) (state DRAWING))
            (test (eq ?topic (str-cat ?turtle "/pose")))))
  =>
  (ros-msgs-destroy-message ?msg)
  (retract ?pose))

(defrule studio-stops-turtle
  "The executive ends while a turtle draws: close what the turtle has open."
  (executive-finalize)
  (figure (turtle ?turtle) (state SPAWNED|PEN-ASKED|DRAWING))
  =>
  (ros-msgs-destroy-subscription (str-cat ?turtle "/pose"))
  (ros-msgs-destroy-publisher (str-cat ?turtle "/cmd_vel"))
  (ros-msgs-destroy-client (str-cat ?turtle "/set_pen")))

(defrule studio-drops-response
  "The executive ends: a response that nobody took is dropped."
  (executive-finalize)
  ?fact <- (ros-msgs-response (msg-ptr ?msg))
  =>
  (ros-msgs-destroy-message ?msg)
  (retract ?fact))

(defrule studio-closes
  "The executive ends: close the clients of the services."
  (executive-finalize)
  =>
  (ros-msgs-destroy-client "kill")
  (ros-msgs-destroy-client "spawn"))
