; Clients of the services of a manager.

(defglobal ?*CX-PDDL-SERVICE-CLIENTS* = (create$
  "add_pddl_instance" "AddPddlInstance" "get_action_names" "GetActionNames" "get_fluents" "GetFluents" "get_functions" "GetFunctions"
  "get_predictes" "GetPredicates" "get_type_objects" "GetTypeObjects" "add_fluents" "AddFluents" "rm_fluents" "RemoveFluents"
  "set_functions" "SetFunctions" "add_objects" "AddObjects" "rm_objects" "RemoveObjects" "set_goals" "SetGoals"
  "clear_goals" "ClearGoals" "create_goal_instance" "CreateGoalInstance" "set_action_filter" "SetActionFilter"
  "set_fluent_filter" "SetFluentFilter" "set_object_filter" "SetObjectFilter" "check_action_condition" "CheckActionCondition"
  "get_action_effects" "GetActionEffects"))

(defrule pddl-manager-connect
  "A manager is named: open clients of all its services. The list of CX misspells get_predicates, so it is added here."
  ?manager <- (pddl-manager (node ?node) (ros-comm-init FALSE))
  =>
  (bind ?pairs (create$ "get_predicates" "GetPredicates" ?*CX-PDDL-SERVICE-CLIENTS*))
  (loop-for-count (?i 1 (div (length$ ?pairs) 2))
    (ros-msgs-create-client (str-cat ?node "/" (nth$ (- (* 2 ?i) 1) ?pairs)) (str-cat "cx_pddl_interfaces/srv/" (nth$ (* 2 ?i) ?pairs))))
  (modify ?manager (ros-comm-init TRUE)))

(defrule pddl-manager-disconnect
  "The executive ends: close the clients."
  (executive-finalize)
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  =>
  (do-for-all-facts ((?c ros-msgs-client)) (eq (str-index (str-cat ?node "/") ?c:service) 1) (ros-msgs-destroy-client ?c:service)))
