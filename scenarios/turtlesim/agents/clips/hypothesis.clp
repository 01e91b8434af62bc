; What both environments do with their hypothesis: predict where turtle1 will be half a second later, compare, and publish
; what they think of it. `predicted` and ?*HYPOTHESIS* come from the file of the hypothesis.

(defglobal
  ?*AHEAD* = 0.5
  ?*TOLERANCE* = 0.1
  ?*PROOF* = 3)

(deftemplate seen
  "The newest pose of the turtle."
  (slot at (type FLOAT))
  (slot x (type FLOAT))
  (slot y (type FLOAT))
  (slot theta (type FLOAT))
  (slot speed (type FLOAT))
  (slot turn (type FLOAT)))

(deftemplate prediction
  "The pose on which a prediction is based, and the time at which it is compared."
  (slot made (type FLOAT))
  (slot due (type FLOAT))
  (slot x (type FLOAT))
  (slot y (type FLOAT))
  (slot theta (type FLOAT))
  (slot speed (type FLOAT))
  (slot turn (type FLOAT)))

(deftemplate comparison
  "The distance between the turtle and its predicted place, m."
  (slot error (type FLOAT)))

(deftemplate belief
  "How often in a row the hypothesis was right or wrong, and the conclusion."
  (slot right (type INTEGER) (default 0))
  (slot wrong (type INTEGER) (default 0))
  (slot verdict (type SYMBOL) (allowed-values OPEN SUPPORTED REFUTED) (default OPEN)))

(deffacts hypothesis-start
  (hypothesis-open)
  (belief))

(defrule hypothesis-open
  "At the start: subscribe to the turtle's pose, and open a publisher for the verdict."
  (hypothesis-open)
  =>
  (ros-msgs-create-subscription "turtle1/pose" "turtlesim/msg/Pose")
  (ros-msgs-create-publisher "hypotheses" "std_msgs/msg/String"))

(defrule drop-older-pose
  "A newer pose has come: drop the older one."
  ?newer <- (ros-msgs-message (topic "turtle1/pose"))
  ?older <- (ros-msgs-message (topic "turtle1/pose") (msg-ptr ?msg))
  (test (< (fact-index ?older) (fact-index ?newer)))
  =>
  (ros-msgs-destroy-message ?msg)
  (retract ?older))

(defrule see-pose
  "A pose has come: remember where the turtle is and how it moves."
  (time ?now)
  ?pose <- (ros-msgs-message (topic "turtle1/pose") (msg-ptr ?msg))
  (not (ros-msgs-message (topic "turtle1/pose") (msg-ptr ~?msg)))
  =>
  (do-for-all-facts ((?old seen)) TRUE (retract ?old))
  (assert (seen (at ?now)
                (x (ros-msgs-get-field ?msg "x")) (y (ros-msgs-get-field ?msg "y")) (theta (ros-msgs-get-field ?msg "theta"))
                (speed (ros-msgs-get-field ?msg "linear_velocity")) (turn (ros-msgs-get-field ?msg "angular_velocity"))))
  (ros-msgs-destroy-message ?msg)
  (retract ?pose))

(defrule predict
  "The turtle moves, and no prediction is open: predict from this pose."
  (not (prediction))
  (seen (at ?at) (x ?x) (y ?y) (theta ?theta) (speed ?speed&:(> ?speed 0.0)) (turn ?turn))
  =>
  (assert (prediction (made ?at) (due (+ ?at ?*AHEAD*)) (x ?x) (y ?y) (theta ?theta) (speed ?speed) (turn ?turn))))

(defrule compare
  "The time of the prediction has come: compare the turtle's place with it."
  (seen (at ?at) (x ?x) (y ?y) (speed ?now&:(> ?now 0.0)))
  ?prediction <- (prediction (made ?made) (due ?due&:(>= ?at ?due)) (x ?from-x) (y ?from-y) (theta ?theta) (speed ?speed) (turn ?turn))
  =>
  (bind ?place (predicted ?from-x ?from-y ?theta ?speed ?turn (- ?at ?made)))
  (retract ?prediction)
  (assert (comparison (error (sqrt (+ (** (- ?x (nth$ 1 ?place)) 2) (** (- ?y (nth$ 2 ?place)) 2)))))))

(defrule prediction-was-right
  "The turtle is where it was predicted: count it for the hypothesis."
  ?comparison <- (comparison (error ?error&:(<= ?error ?*TOLERANCE*)))
  ?belief <- (belief (right ?right))
  =>
  (retract ?comparison)
  (modify ?belief (right (+ ?right 1)) (wrong 0)))

(defrule prediction-was-wrong
  "The turtle is elsewhere: count it against the hypothesis."
  ?comparison <- (comparison (error ?error&:(> ?error ?*TOLERANCE*)))
  ?belief <- (belief (wrong ?wrong))
  =>
  (retract ?comparison)
  (modify ?belief (wrong (+ ?wrong 1)) (right 0)))

(defrule prediction-lapses
  "The turtle stands still: forget the prediction, which cannot be compared."
  (seen (speed ?speed&:(<= ?speed 0.0)))
  ?prediction <- (prediction)
  =>
  (retract ?prediction))

(deffunction publish-verdict (?verdict)
  (printout info "hypothesis '" ?*HYPOTHESIS* "': " ?verdict crlf)
  (bind ?message (ros-msgs-create-message "std_msgs/msg/String"))
  (ros-msgs-set-field ?message "data" (str-cat ?*HYPOTHESIS* " " ?verdict))
  (ros-msgs-publish ?message "hypotheses")
  (ros-msgs-destroy-message ?message))

(defrule hypothesis-is-supported
  "The hypothesis was right often enough in a row: support it."
  ?belief <- (belief (right ?right&:(>= ?right ?*PROOF*)) (verdict OPEN|REFUTED))
  =>
  (publish-verdict SUPPORTED)
  (modify ?belief (verdict SUPPORTED)))

(defrule hypothesis-is-refuted
  "The hypothesis was wrong often enough in a row: refute it."
  ?belief <- (belief (wrong ?wrong&:(>= ?wrong ?*PROOF*)) (verdict OPEN|SUPPORTED))
  =>
  (publish-verdict REFUTED)
  (modify ?belief (verdict REFUTED)))

(defrule hypothesis-close
  "The executive ends: close all that is open."
  (executive-finalize)
  =>
  (ros-msgs-destroy-subscription "turtle1/pose")
  (ros-msgs-destroy-publisher "hypotheses"))

(defrule drop-message-at-the-end
  "The executive ends: a pose that nobody took is dropped."
  (executive-finalize)
  ?fact <- (ros-msgs-message (msg-ptr ?msg))
  =>
  (ros-msgs-destroy-message ?msg)
  (retract ?fact))
