; The agent asks people to take a robot that does not move any more off the field and repair it. Others do its work meanwhile. The
; agent also ends skills and instructions that take longer than they can.

(defglobal
  ?*STANDS* = 90.0    ; s, longer than any drive takes
  ?*FOR-GOOD* = 150.0 ; s, after which a robot does not move again by itself
  ?*LONGEST* = 180.0  ; s, longer than any skill takes
  ?*ANSWER* = 20.0    ; s for the answer to a cancel
  ?*DEAF* = 60.0      ; s, after which an idle machine has not heard its instruction
  ?*CYCLES* = 2)      ; a third maintenance disqualifies the robot

(deftemplate repair
  "The agent asked for a robot to be taken off the field and repaired."
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
  (or (command (state RUNNING) (goal-id ?goal))
      (instruction (state RUNNING) (goal-id ?goal)))
  (not (under-way (goal-id ?goal)))
  (time ?now)
  =>
  (assert (under-way (goal-id ?goal) (since ?now))))

(defrule repair-over
  ?under-way <- (under-way (goal-id ?goal))
  (not (command (goal-id ?goal)))
  (not (instruction (goal-id ?goal)))
  =>
  (retract ?under-way))

(defrule repair-ask
  "A robot could not move (code 201), and its skill tried for long: ask people to take it off the field and repair it."
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

; --- A robot that was repaired twice, and does not move again

(defrule repair-stands
  (declare (salience 20))
  (command (robot ?name) (state FAILED) (error-code 201) (goal-id ?goal))
  (under-way (goal-id ?goal) (since ?since))
  (not (stands ?name ?))
  (time ?now&:(> ?now (+ ?since ?*STANDS*)))
  =>
  (assert (stands ?name ?since)))

(defrule repair-stands-no-more
  (declare (salience 20))
  (command (robot ?name) (state SUCCEEDED))
  ?stands <- (stands ?name ?)
  =>
  (retract ?stands))

(defrule repair-off-for-good
  "A robot that was repaired twice stands in the way of the others, which is worse than its loss: have it taken away."
  (declare (salience 10))
  (command (robot ?name) (state FAILED) (error-code 201))
  (robot (name ?name) (number ?number) (duty ACTIVE) (cycles ?cycles&:(>= ?cycles ?*CYCLES*)))
  (not (repair (robot ?name)))
  (stands ?name ?since)
  (ros-msgs-publisher (topic "/set_robot_maintenance"))
  (time ?now&:(> ?now (+ ?since ?*FOR-GOOD*)))
  =>
  (decide (str-cat "have " ?name " taken off the field for good") "it does not move again")
  (assert (repair (robot ?name) (number ?number)))
  (ask-for-maintenance ?number TRUE))

; --- What takes longer than it can

(defrule repair-cancel
  "A skill runs longer than any skill takes: ask the robot to stop."
  (command (robot ?name) (skill ?skill) (server ?server) (state RUNNING) (handle ?handle) (goal-id ?goal))
  (under-way (goal-id ?goal) (since ?since))
  (not (cancelled ?goal))
  (time ?now&:(> ?now (+ ?since ?*LONGEST*)))
  =>
  (decide (str-cat "cancel " ?skill " of " ?name) "no skill takes as long")
  (assert (cancelled ?goal))
  (ros-msgs-async-cancel-goal ?server ?handle))

(defrule repair-cancel-answered
  ?response <- (ros-msgs-cancel-response (cancel-response-ptr ?answer))
  =>
  (ros-msgs-destroy-message ?answer)
  (retract ?response))

(defrule repair-cancel-over
  ?cancelled <- (cancelled ?goal)
  (not (command (goal-id ?goal)))
  =>
  (retract ?cancelled))

(defrule repair-no-answer
  "The robot does not answer that it has stopped: count its skill as failed."
  ?command <- (command (robot ?name) (state RUNNING) (handle ?handle) (goal-id ?goal))
  (under-way (goal-id ?goal) (since ?since))
  (time ?now&:(> ?now (+ ?since ?*LONGEST* ?*ANSWER*)))
  =>
  (decide (str-cat "wait no more for " ?name) "it does not answer")
  (ros-msgs-destroy-client-goal-handle ?handle)
  (modify ?command (handle NONE) (goal-id NONE) (state FAILED) (error "no answer")))

(defrule repair-instruct-again
  "A machine stays idle although it was instructed: it has not heard the instruction, so send it again."
  ?instruction <- (instruction (machine ?machine) (operation ?operation&~"RESET") (state RUNNING) (handle ?handle) (goal-id ?goal))
  (under-way (goal-id ?goal) (since ?since))
  (machine (name ?machine) (state IDLE))
  (time ?now&:(> ?now (+ ?since ?*DEAF*)))
  =>
  (decide (str-cat "say " ?operation " to " ?machine " again") "it is idle")
  (ros-msgs-destroy-client-goal-handle ?handle)
  (modify ?instruction (handle NONE) (goal-id NONE) (state NEW)))

(defrule repair-late-result
  "A result belongs to a skill or instruction for which nobody waits any more: drop it."
  (declare (salience -10))
  ?wrapped <- (ros-msgs-wrapped-result (goal-id ?goal) (result-ptr ?result))
  (not (command (state SENT)))
  (not (instruction (state SENT)))
  (not (command (goal-id ?goal)))
  (not (instruction (goal-id ?goal)))
  =>
  (ros-msgs-destroy-message ?result)
  (retract ?wrapped))

; --- Back on the field

(defrule repair-back
  "The robot is in maintenance: ask that it come back as soon as it is repaired."
  ?repair <- (repair (robot ?name) (number ?number))
  (robot (name ?name) (duty MAINTENANCE))
  =>
  (retract ?repair)
  (ask-for-maintenance ?number FALSE))
