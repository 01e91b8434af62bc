; A robot that does not move any more is asked off the field, where people repair it; others do its work meanwhile.

(defglobal
  ?*STANDS* = 90.0    ; s: no drive takes as long
  ?*CYCLES* = 2)      ; a third maintenance disqualifies the robot

(deftemplate repair
  "A robot is asked off the field, to be repaired."
  (slot robot (type STRING))
  (slot number (type INTEGER)))

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
  (robot (name ?name) (number ?number) (duty ACTIVE) (cycles ?cycles&:(< ?cycles ?*CYCLES*)))
  (not (repair (robot ?name)))
  (ros-msgs-publisher (topic "/set_robot_maintenance"))
  (time ?now&:(> ?now (+ ?since ?*STANDS*)))
  =>
  (decide (str-cat "ask " ?name " off the field") "it does not move any more")
  (assert (repair (robot ?name) (number ?number)))
  (ask-for-maintenance ?number TRUE))

(defrule repair-back
  "It may come back as soon as it is repaired."
  ?repair <- (repair (robot ?name) (number ?number))
  (robot (name ?name) (duty MAINTENANCE))
  =>
  (retract ?repair)
  (ask-for-maintenance ?number FALSE))
