; Commands become goals on the bus, results become facts again. The rest of the agent asserts
; (command ...) or (instruction ...) and waits for its state SUCCEEDED or FAILED.

(deftemplate command
  "A skill that a robot has to do."
  (slot id (type INTEGER))
  (slot robot (type STRING))
  (slot skill (type SYMBOL) (allowed-values drive_to pick place explore transport))
  (slot from (type STRING) (default ""))   ; of a transport
  (slot target (type STRING))
  (slot part (type STRING) (default ""))   ; of a transport: drive_from, pick, drive_to, place
  (slot server (type STRING) (default ""))
  (slot goal (default NONE))
  (slot handle (default NONE))
  (slot goal-id (type SYMBOL) (default NONE))
  (slot state (type SYMBOL) (allowed-values NEW SENT RUNNING SUCCEEDED FAILED) (default NEW))
  (slot error-code (type INTEGER) (default 0))
  (slot error (type STRING) (default "")))

(deftemplate skill-type
  (slot skill (type SYMBOL))
  (slot type (type STRING)))

(deftemplate skill-client
  "An action client that exists."
  (slot robot (type STRING))
  (slot skill (type SYMBOL))
  (slot server (type STRING))
  (slot type (type STRING)))

(deffacts skill-types
  (skill-type (skill drive_to) (type "cxlab_skills/action/DriveTo"))
  (skill-type (skill pick) (type "cxlab_skills/action/Pick"))
  (skill-type (skill place) (type "cxlab_skills/action/Place"))
  (skill-type (skill explore) (type "cxlab_skills/action/Explore"))
  (skill-type (skill transport) (type "cxlab_skills/action/Transport")))

(defrule skill-client-create
  "A robot is known: create one action client for each of its skills."
  (robot (name ?robot))
  (skill-type (skill ?skill) (type ?type))
  (not (skill-client (robot ?robot) (skill ?skill)))
  =>
  (bind ?server (str-cat "/" ?robot "/" ?skill))
  (ros-msgs-create-action-client ?server ?type)
  (assert (skill-client (robot ?robot) (skill ?skill) (server ?server) (type ?type))))

(defrule skill-send-goal
  "A command is new: send its goal to the robot's server. Only one goal at a time waits for its answer."
  ?c <- (command (robot ?robot) (skill ?skill) (from ?from) (target ?target) (state NEW))
  (skill-client (robot ?robot) (skill ?skill) (server ?server) (type ?type))
  (not (command (server ?server) (state SENT)))
  =>
  (bind ?goal (ros-msgs-create-goal-request ?type))
  (if (eq ?from "")
   then (ros-msgs-set-field ?goal "target" ?target)
   else (ros-msgs-set-field ?goal "from" ?from)
        (ros-msgs-set-field ?goal "to" ?target))
  (ros-msgs-async-send-goal ?goal ?server)
  (modify ?c (state SENT) (server ?server) (goal ?goal)))

(deffunction is-null (?handle)
  "Whether a handle points nowhere, as the handle of a rejected goal does."
  (eq (implode$ (create$ ?handle)) "<Pointer-C-(nil)>"))

(defrule skill-goal-rejected
  "The robot rejected the goal, because it is busy with a goal that is not ours: the command has failed."
  ?c <- (command (server ?server) (state SENT) (goal ?goal))
  ?response <- (ros-msgs-goal-response (server ?server) (client-goal-handle-ptr ?handle&:(is-null ?handle)))
  =>
  (ros-msgs-destroy-message ?goal)
  (retract ?response)
  (modify ?c (state FAILED) (goal NONE) (error "the goal was rejected")))

(defrule skill-goal-answered
  "The server accepted the goal: the command is running."
  ?c <- (command (server ?server) (state SENT) (goal ?goal))
  ?response <- (ros-msgs-goal-response (server ?server) (client-goal-handle-ptr ?handle&:(not (is-null ?handle))))
  =>
  (bind ?goal-id (ros-msgs-client-goal-handle-get-goal-id ?handle))
  (ros-msgs-destroy-message ?goal)
  (retract ?response)
  (modify ?c (state RUNNING) (goal NONE) (handle ?handle) (goal-id ?goal-id)))

(defrule skill-result
  "The skill ended: write its result into the command with the same goal."
  ?c <- (command (state RUNNING) (skill ?skill) (goal-id ?goal-id) (handle ?handle))
  ?wrapped <- (ros-msgs-wrapped-result (goal-id ?goal-id) (code ?code) (result-ptr ?result))
  =>
  (bind ?error-code (ros-msgs-get-field ?result "error_code"))
  (bind ?error (ros-msgs-get-field ?result "error"))
  (bind ?part (if (neq ?skill transport) then "" else (if (eq ?code SUCCEEDED) then "place" else (ros-msgs-get-field ?result "sub_action"))))
  (ros-msgs-destroy-message ?result)
  (ros-msgs-destroy-client-goal-handle ?handle)
  (retract ?wrapped)
  (modify ?c (handle NONE) (part ?part) (state (if (eq ?code SUCCEEDED) then SUCCEEDED else FAILED)) (error-code ?error-code) (error ?error)))

(defrule skill-feedback
  "A transport reports which part it is at: note it. Phases are for the journal, not for the agent."
  ?f <- (ros-msgs-feedback (server ?server) (feedback-ptr ?feedback))
  =>
  (do-for-fact ((?c command)) (and (eq ?c:server ?server) (eq ?c:skill transport))
    (modify ?c (part (ros-msgs-get-field ?feedback "sub_action"))))
  (ros-msgs-destroy-message ?feedback)
  (retract ?f))

; --- Machines

(defglobal ?*INSTRUCT* = "/factory/instruct_machine")

(deftemplate instruction
  "An instruction for a machine."
  (slot id (type INTEGER))
  (slot machine (type STRING))
  (slot operation (type STRING))
  (slot side (type STRING) (default ""))
  (slot color (type STRING) (default ""))  ; of a base or ring
  (slot order (type INTEGER) (default 0))
  (slot goal (default NONE))
  (slot handle (default NONE))
  (slot goal-id (type SYMBOL) (default NONE))
  (slot state (type SYMBOL) (allowed-values NEW SENT RUNNING SUCCEEDED FAILED) (default NEW))
  (slot tries (type INTEGER) (default 0))
  (slot error (type STRING) (default "")))

(defrule instruct-client-create
  (machine)
  (not (ros-msgs-action-client (server "/factory/instruct_machine")))
  (not (executive-finalize))
  =>
  (ros-msgs-create-action-client ?*INSTRUCT* "rcll_interfaces/action/InstructMachine"))

(defrule instruct-send
  "An instruction is new, its machine is idle and the game is not
   paused: send it. A reset does not wait for the machine."
  ?i <- (instruction (machine ?machine) (operation ?operation) (side ?side) (color ?color) (order ?order) (state NEW))
  (machine (name ?machine) (state ?machine-state&:(or (eq ?machine-state IDLE)
                                                      (and (eq ?operation "RESET") (neq ?machine-state BROKEN)))))
  (ros-msgs-action-client (server "/factory/instruct_machine"))
  (not (instruction (state SENT)))
  (not (game (state PAUSED)))
  =>
  (bind ?goal (ros-msgs-create-goal-request "rcll_interfaces/action/InstructMachine"))
  (ros-msgs-set-field ?goal "machine" ?machine)
  (ros-msgs-set-field ?goal "operation" ?operation)
  (ros-msgs-set-field ?goal "side" ?side)
  (ros-msgs-set-field ?goal (if (str-index "RING" ?color) then "ring_color" else "base_color") ?color)
  (ros-msgs-set-field ?goal "order_id" ?order)
  (ros-msgs-async-send-goal ?goal ?*INSTRUCT*)
  (modify ?i (state SENT) (goal ?goal)))

(defrule instruct-answered
  ?i <- (instruction (state SENT) (goal ?goal))
  ?response <- (ros-msgs-goal-response (server "/factory/instruct_machine") (client-goal-handle-ptr ?handle))
  =>
  (bind ?goal-id (ros-msgs-client-goal-handle-get-goal-id ?handle))
  (ros-msgs-destroy-message ?goal)
  (retract ?response)
  (modify ?i (state RUNNING) (goal NONE) (handle ?handle) (goal-id ?goal-id)))

(defrule instruct-result
  "The instruction ended. If the machine was not ready for it, the instruction waits for the machine again. If the machine
   did not hear it, the instruction is sent again."
  ?i <- (instruction (operation ?operation) (state RUNNING) (goal-id ?goal-id) (handle ?handle) (tries ?tries))
  ?wrapped <- (ros-msgs-wrapped-result (server "/factory/instruct_machine") (goal-id ?goal-id) (code ?code) (result-ptr ?result))
  =>
  (bind ?error-code (ros-msgs-get-field ?result "error_code"))
  (bind ?error (ros-msgs-get-field ?result "error"))
  (ros-msgs-destroy-message ?result)
  (ros-msgs-destroy-client-goal-handle ?handle)
  (retract ?wrapped)
  (bind ?again (and (< ?tries 5) (or (= ?error-code 2) (and (= ?error-code 209) (neq ?operation "RESET")))))
  (modify ?i (handle NONE) (goal-id NONE) (tries (+ ?tries 1)) (error ?error)
             (state (if ?again then NEW else (if (eq ?code SUCCEEDED) then SUCCEEDED else FAILED)))))

(defrule instruct-reset-done
  "The machine is BROKEN, or it cannot be reset: the instruction to reset it is done."
  ?i <- (instruction (machine ?machine) (operation "RESET") (state ?state))
  (machine (name ?machine) (state ?machine-state))
  (test (or (eq ?state FAILED) (and (neq ?state SENT) (neq ?state RUNNING) (eq ?machine-state BROKEN))))
  =>
  (retract ?i))
