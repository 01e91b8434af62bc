; A robot that does not move any more is asked off the field, where people repair it; others do its work meanwhile.

(defglobal
  ?*STANDS* = 90.0    ; s: no drive takes as long
  ?*REPAIRS* = 2)     ; a third one disqualifies the robot

(deftemplate repair
  "A robot is to be repaired: it is asked off the field (LEAVE), then back (DONE)."
  (slot robot (type STRING))
  (slot number (type INTEGER))
  (slot cycle (type INTEGER) (default 1))
  (slot state (type SYMBOL) (allowed-values LEAVE DONE) (default LEAVE)))

(defrule repair-publisher
  (exists (robot))
  (not (ros-msgs-publisher (topic "/set_robot_maintenance")))
  (not (executive-finalize))
  =>
  (ros-msgs-create-publisher "/set_robot_maintenance" "rcll_interfaces/msg/SetRobotMaintenance"))

(deffunction ask-for-maintenance (?number ?off-field)
  (bind ?message (ros-msgs-create-message "rcll_interfaces/msg/SetRobotMaintenance"))
  (ros-msgs-set-field ?message "robot_number" ?number)
  (ros-msgs-set-field ?message "maintenance" ?off-field)
  (ros-msgs-set-field ?message "team_color" (if (any-factp ((?w we-are)) (eq ?w:implied (create$ "C"))) then "CYAN" else "MAGENTA"))
  (ros-msgs-publish ?message "/set_robot_maintenance")
  (ros-msgs-destroy-message ?message))

(deffunction repairs-of (?name)
  (length$ (find-all-facts ((?r repair)) (eq ?r:robot ?name))))

(defrule repair-under-way
  (command (state RUNNING) (goal-id ?goal))
  (not (under-way (goal-id ?goal)))
  (time ?now)
  =>
  (assert (under-way (goal-id ?goal) (since ?now))))

(defrule repair-over
  ?under-way <- (under-way (goal-id ?goal))
  (not (command (goal-id ?goal)))
  =>
  (retract ?under-way))

(defrule repair-ask
  "It could not move (201), and tried for long."
  (declare (salience 10))
  (command (robot ?name) (state FAILED) (error-code 201) (goal-id ?goal))
  (under-way (goal-id ?goal) (since ?since))
  (robot (name ?name) (number ?number) (duty ACTIVE))
  (not (repair (robot ?name) (state LEAVE)))
  (test (< (repairs-of ?name) ?*REPAIRS*))
  (ros-msgs-publisher (topic "/set_robot_maintenance"))
  (time ?now&:(> ?now (+ ?since ?*STANDS*)))
  =>
  (decide (str-cat "ask " ?name " off the field") "it does not move any more")
  (assert (repair (robot ?name) (number ?number) (cycle (+ (repairs-of ?name) 1))))
  (ask-for-maintenance ?number TRUE))

(defrule repair-back
  "It may come back as soon as it is repaired."
  ?repair <- (repair (robot ?name) (number ?number) (state LEAVE))
  (robot (name ?name) (duty MAINTENANCE))
  =>
  (modify ?repair (state DONE))
  (ask-for-maintenance ?number FALSE))
