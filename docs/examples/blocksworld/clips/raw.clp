; Builds a tower of three blocks with the services of the PDDL manager alone. One request is open at a time; the
; step of the work says which answer comes next.

(deftemplate work (slot step (type SYMBOL) (default CONNECT)) (slot action (type INTEGER) (default 0)) (slot until (type FLOAT) (default 0.0)))
(deftemplate planned (slot number (type INTEGER)) (slot name) (multislot params) (slot duration (type FLOAT)))
(deftemplate change (slot point) (slot add) (slot name) (multislot params))

(deffacts start (work))

(deffunction service (?name) (str-cat "/pddl_manager/" ?name))

(deffunction ask-manager (?name ?request)
  (ros-msgs-async-send-request ?request (service ?name))
  (ros-msgs-destroy-message ?request))

(deffunction fluent (?name ?params)
  (bind ?fluent (ros-msgs-create-message "cx_pddl_interfaces/msg/Fluent"))
  (ros-msgs-set-field ?fluent "pddl_instance" "blocks")
  (ros-msgs-set-field ?fluent "name" ?name)
  (ros-msgs-set-field ?fluent "args" ?params)
  ?fluent)

(deffunction send-action (?name ?type ?action ?params)
  "A question about one step."
  (bind ?message (ros-msgs-create-message "cx_pddl_interfaces/msg/Action"))
  (ros-msgs-set-field ?message "pddl_instance" "blocks")
  (ros-msgs-set-field ?message "name" ?action)
  (ros-msgs-set-field ?message "args" ?params)
  (bind ?request (ros-msgs-create-request ?type))
  (ros-msgs-set-field ?request "action" ?message)
  (ros-msgs-destroy-message ?message)
  (ask-manager ?name ?request))

(deffunction send-changes (?name ?type ?point ?add)
  "All changes of one time point; those that were sent are gone."
  (bind ?fluents (create$))
  (do-for-all-facts ((?c change)) (and (eq ?c:point ?point) (eq ?c:add ?add))
    (bind ?fluents (create$ ?fluents (fluent ?c:name ?c:params)))
    (retract ?c))
  (bind ?request (ros-msgs-create-request ?type))
  (ros-msgs-set-field ?request "fluents" ?fluents)
  (foreach ?fluent ?fluents (ros-msgs-destroy-message ?fluent))
  (ask-manager ?name ?request))

(deffunction answered (?response ?message)
  "Whether it went well; the answer is gone."
  (bind ?success (ros-msgs-get-field ?message "success"))
  (if (not ?success) then (printout error (ros-msgs-get-field ?message "error") crlf))
  (ros-msgs-destroy-message ?message)
  (retract ?response)
  ?success)

(defrule connect
  "At the start: clients, and the problem."
  ?work <- (work (step CONNECT))
  =>
  (foreach ?pair (create$ "add_pddl_instance AddPddlInstance" "set_goals SetGoals" "check_action_condition CheckActionCondition"
                          "get_action_effects GetActionEffects" "add_fluents AddFluents" "rm_fluents RemoveFluents")
    (bind ?words (explode$ ?pair))
    (ros-msgs-create-client (service (nth$ 1 ?words)) (str-cat "cx_pddl_interfaces/srv/" (nth$ 2 ?words))))
  (ros-msgs-create-action-client (service "temp_plan") "cx_pddl_interfaces/action/PlanTemporal")
  (bind ?request (ros-msgs-create-request "cx_pddl_interfaces/srv/AddPddlInstance"))
  (ros-msgs-set-field ?request "name" "blocks")
  (ros-msgs-set-field ?request "directory" (str-cat (ament-index-get-package-share-directory "blocksworld") "/pddl"))
  (ros-msgs-set-field ?request "domain_file" "domain.pddl")
  (ros-msgs-set-field ?request "problem_file" "problem.pddl")
  (ask-manager "add_pddl_instance" ?request)
  (modify ?work (step LOAD)))

(defrule loaded
  "The problem exists: set the goal, a on b and b on c."
  ?work <- (work (step LOAD))
  ?response <- (ros-msgs-response (service "/pddl_manager/add_pddl_instance") (msg-ptr ?message))
  =>
  (if (answered ?response ?message) then
    (bind ?fluents (create$ (fluent "on" (create$ "a" "b")) (fluent "on" (create$ "b" "c"))))
    (bind ?request (ros-msgs-create-request "cx_pddl_interfaces/srv/SetGoals"))
    (ros-msgs-set-field ?request "goal_instance" "base")
    (ros-msgs-set-field ?request "fluents" ?fluents)
    (foreach ?fluent ?fluents (ros-msgs-destroy-message ?fluent))
    (ask-manager "set_goals" ?request)
    (modify ?work (step AIM))))

(defrule aimed
  "The goal is set: plan."
  ?work <- (work (step AIM))
  ?response <- (ros-msgs-response (service "/pddl_manager/set_goals") (msg-ptr ?message))
  =>
  (if (answered ?response ?message) then
    (bind ?goal (ros-msgs-create-goal-request "cx_pddl_interfaces/action/PlanTemporal"))
    (ros-msgs-set-field ?goal "pddl_instance" "blocks")
    (ros-msgs-set-field ?goal "goal_instance" "base")
    (ros-msgs-async-send-goal ?goal (service "temp_plan"))
    (assert (goal-message ?goal))
    (modify ?work (step PLAN))))

(defrule planned
  "The plan is there: its steps become facts."
  ?work <- (work (step PLAN))
  ?goal <- (goal-message ?goal-message)
  ?response <- (ros-msgs-goal-response (client-goal-handle-ptr ?handle))
  ?end <- (ros-msgs-wrapped-result (code ?code) (result-ptr ?result))
  =>
  (bind ?number 0)
  (if (and (eq ?code SUCCEEDED) (ros-msgs-get-field ?result "success")) then
    (foreach ?action (ros-msgs-get-field ?result "actions")
      (assert (planned (number ?number) (name (ros-msgs-get-field ?action "name")) (params (ros-msgs-get-field ?action "args"))
                       (duration (ros-msgs-get-field ?action "duration"))))
      (bind ?number (+ ?number 1)))
    (modify ?work (step NEXT))
   else (printout error "there is no plan: " ?code crlf))
  (ros-msgs-destroy-message ?result)
  (ros-msgs-destroy-message ?goal-message)
  (ros-msgs-destroy-client-goal-handle ?handle)
  (retract ?goal ?response ?end))

(defrule next
  "May the next step begin?"
  ?work <- (work (step NEXT) (action ?number))
  (planned (number ?number) (name ?name) (params $?params))
  =>
  (send-action "check_action_condition" "cx_pddl_interfaces/srv/CheckActionCondition" ?name ?params)
  (modify ?work (step CHECK)))

(defrule checked
  "It may: what does it change?"
  ?work <- (work (step CHECK) (action ?number))
  (planned (number ?number) (name ?name) (params $?params))
  ?response <- (ros-msgs-response (service "/pddl_manager/check_action_condition") (msg-ptr ?message))
  =>
  (bind ?sat (ros-msgs-get-field ?message "sat"))
  (if (not ?sat) then (printout error ?name ": " (ros-msgs-get-field ?message "unsatisfied_conditions") crlf))
  (if (and (answered ?response ?message) ?sat) then
    (println "start " ?name " " (implode$ ?params))
    (send-action "get_action_effects" "cx_pddl_interfaces/srv/GetActionEffects" ?name ?params)
    (modify ?work (step EFFECTS))))

(defrule effects
  "Its changes become facts; those at the start are made, the deletes first."
  ?work <- (work (step EFFECTS))
  ?response <- (ros-msgs-response (service "/pddl_manager/get_action_effects") (msg-ptr ?message))
  =>
  (foreach ?effect (ros-msgs-get-field ?message "fluent_effects")
    (bind ?fluent (ros-msgs-get-field ?effect "fluent"))
    (assert (change (point (sym-cat (ros-msgs-get-field ?effect "time_point"))) (add (ros-msgs-get-field ?effect "value"))
                    (name (ros-msgs-get-field ?fluent "name")) (params (ros-msgs-get-field ?fluent "args")))))
  (answered ?response ?message)
  (send-changes "rm_fluents" "cx_pddl_interfaces/srv/RemoveFluents" START FALSE)
  (modify ?work (step RM-START)))

(defrule removed
  "The deletes are made: the adds."
  ?work <- (work (step ?step&RM-START|RM-END))
  ?response <- (ros-msgs-response (service "/pddl_manager/rm_fluents") (msg-ptr ?message))
  =>
  (answered ?response ?message)
  (send-changes "add_fluents" "cx_pddl_interfaces/srv/AddFluents" (if (eq ?step RM-START) then START else END) TRUE)
  (modify ?work (step (if (eq ?step RM-START) then ADD-START else ADD-END))))

(defrule begun
  "The step has begun: it takes its time."
  ?work <- (work (step ADD-START) (action ?number))
  (planned (number ?number) (duration ?duration))
  ?response <- (ros-msgs-response (service "/pddl_manager/add_fluents") (msg-ptr ?message))
  =>
  (answered ?response ?message)
  (modify ?work (step RUN) (until (+ (now) ?duration))))

(defrule over
  "Its time is over: the changes at the end."
  ?work <- (work (step RUN) (until ?until))
  (time ?now&:(>= ?now ?until))
  =>
  (send-changes "rm_fluents" "cx_pddl_interfaces/srv/RemoveFluents" END FALSE)
  (modify ?work (step RM-END)))

(defrule ended
  "They are made: the next step."
  ?work <- (work (step ADD-END) (action ?number))
  ?response <- (ros-msgs-response (service "/pddl_manager/add_fluents") (msg-ptr ?message))
  =>
  (answered ?response ?message)
  (modify ?work (step NEXT) (action (+ ?number 1))))

(defrule built
  "No step is left."
  ?work <- (work (step NEXT) (action ?number&:(> ?number 0)))
  (not (planned (number ?number)))
  =>
  (println "the tower stands after " ?number " steps, " (format nil "%.1f" (now)) " s")
  (modify ?work (step DONE)))

(defrule close
  "The executive ends: close what is open."
  (executive-finalize)
  =>
  (do-for-all-facts ((?c ros-msgs-client)) TRUE (ros-msgs-destroy-client ?c:service))
  (ros-msgs-destroy-action-client (service "temp_plan")))
