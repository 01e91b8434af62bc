; Rules that talk to the PDDL manager. Needs the templates of deftemplates.clp and the plugins cx::RosMsgsPlugin and
; cx::CXCxPddlInterfacesPlanTemporalPlugin. An instance is asked one thing at a time: its slot busy-with says which.
; A request that finds no manager stays PENDING and is sent again at the next tick. Where several requests wait for an
; instance, these numbers say which goes first, as in the CLIPS-Executive; agents count on it (objects before the fluents that
; name them, goals before the plan). Questions go at once. Of a template nothing is taken for granted but the slots and states
; that CX has, for an agent may have defined it anew with these alone.

(defglobal
  ?*PDDL-SALIENCE-INSTANCES* = -5100
  ?*PDDL-SALIENCE-ACTION-NAMES* = -5300
  ?*PDDL-SALIENCE-OBJECTS* = -5400
  ?*PDDL-SALIENCE-FLUENTS* = -5500
  ?*PDDL-SALIENCE-EFFECTS* = -5600
  ?*PDDL-SALIENCE-CLEAR-GOALS* = -5700
  ?*PDDL-SALIENCE-CREATE-GOAL* = -5800
  ?*PDDL-SALIENCE-ACTION-FILTER* = -5900
  ?*PDDL-SALIENCE-FLUENT-FILTER* = -6000
  ?*PDDL-SALIENCE-OBJECT-FILTER* = -6100
  ?*PDDL-SALIENCE-SET-GOALS* = -6200
  ?*PDDL-SALIENCE-PLAN* = -6300
  ?*PDDL-SALIENCE-CONDITIONS* = -6400)

; --- Messages

(deffunction pddl-strings (?items)
  "Each item as a string."
  (bind ?texts (create$))
  (foreach ?item ?items (bind ?texts (create$ ?texts (str-cat ?item))))
  ?texts)

(deffunction pddl-symbols (?items)
  "Each item as a symbol."
  (bind ?symbols (create$))
  (foreach ?item ?items (bind ?symbols (create$ ?symbols (sym-cat ?item))))
  ?symbols)

(deffunction pddl-message (?type ?instance ?name ?params)
  "A new Fluent, Function or Action message."
  (bind ?message (ros-msgs-create-message (str-cat "cx_pddl_interfaces/msg/" ?type)))
  (ros-msgs-set-field ?message "pddl_instance" (str-cat ?instance))
  (ros-msgs-set-field ?message "name" (str-cat ?name))
  (ros-msgs-set-field ?message "args" (pddl-strings ?params))
  ?message)

(deffunction pddl-request (?type ?instance ?goal)
  "A new request about an instance, and a goal where there is one."
  (bind ?request (ros-msgs-create-request (str-cat "cx_pddl_interfaces/srv/" ?type)))
  (if (neq ?instance nil) then (ros-msgs-set-field ?request "pddl_instance" (str-cat ?instance)))
  (if (neq ?goal nil) then (ros-msgs-set-field ?request "goal_instance" (str-cat ?goal)))
  ?request)

(deffunction pddl-send (?node ?service ?request $?meta)
  "Sends a request and notes whose it is. FALSE when the manager is not there."
  (bind ?name (str-cat ?node "/" ?service))
  (bind ?id (ros-msgs-async-send-request ?request ?name))
  (ros-msgs-destroy-message ?request)
  (if (eq ?id FALSE) then (return FALSE))
  (assert (pddl-service-request-meta (service ?name) (request-id ?id) (meta ?meta)))
  TRUE)

(deffunction pddl-error-of (?response)
  (if (ros-msgs-get-field ?response "success") then "" else (ros-msgs-get-field ?response "error")))

; --- Requests. They are known by their index, which stays when they are modified.

(deffunction pddl-agrees (?ask ?slot ?value)
  "Whether a request can mean that: its slot has the value or nil, or there is none."
  (or (not (deftemplate-slot-existp (fact-relation ?ask) ?slot)) (eq (fact-slot-value ?ask ?slot) nil) (eq (fact-slot-value ?ask ?slot) ?value)))

(deffunction pddl-is-set (?pointer)
  "FALSE of nil, and of the null pointer with which a slot of external addresses begins."
  (bind ?text (implode$ (create$ ?pointer)))
  (not (or (eq ?pointer nil) (str-index "(nil)" ?text) (str-index "0x0>" ?text))))

(deffunction pddl-put (?ask ?slot ?value)
  "Where the request has such a slot."
  (if (deftemplate-slot-existp (fact-relation ?ask) ?slot) then
    (switch ?slot
      (case error then (modify ?ask (error ?value)))
      (case instance then (modify ?ask (instance ?value))))))

(deffunction pddl-becomes (?ask ?state ?error)
  "The state of a request, if it is still there. Errors are told."
  (if (fact-existp ?ask) then
    (if (eq ?state ERROR) then (printout error (fact-relation ?ask) ": " ?error crlf))
    (pddl-put ?ask error ?error)
    (modify ?ask (state ?state))))

(deffunction pddl-close (?ask ?error)
  "A question or request is DONE, or ERROR."
  (pddl-becomes ?ask (if (eq ?error "") then DONE else ERROR) ?error))

(deffunction pddl-sent (?i ?busy ?ask ?state)
  "The instance is busy with the request."
  (modify ?i (busy-with ?busy))
  (pddl-becomes ?ask ?state ""))

(deffunction pddl-answered (?instance ?message ?response ?meta)
  "The answer was taken: it goes, and the instance can be asked the next thing."
  (ros-msgs-destroy-message ?message)
  (retract ?response ?meta)
  (do-for-fact ((?i pddl-instance)) (eq ?i:name ?instance) (modify ?i (busy-with FALSE))))

(deffunction pddl-apply-op (?op ?value ?new)
  "The value after an effect: = sets it, + and - change it."
  (switch (str-cat ?op)
    (case "+" then (+ ?value ?new))
    (case "-" then (- ?value ?new))
    (default ?new)))

(deffunction pddl-value-of (?instance ?name ?params)
  "The numeric fluent as it is known here; 0 where it is not."
  (do-for-fact ((?f pddl-numeric-fluent)) (and (eq ?f:instance ?instance) (eq ?f:name ?name) (eq ?f:params ?params)) (return ?f:value))
  0.0)

; --- Fluents as they are known here

(deffunction pddl-take-fluent (?instance ?name ?params)
  "The fluent is known; its fact."
  (assert (pddl-fluent (instance ?instance) (name (sym-cat ?name)) (params (pddl-symbols ?params)))))

(deffunction pddl-drop-fluent (?instance ?name ?params)
  "The fluent is known no more."
  (bind ?symbol (sym-cat ?name))
  (bind ?symbols (pddl-symbols ?params))
  (do-for-all-facts ((?f pddl-fluent)) (and (eq ?f:instance ?instance) (eq ?f:name ?symbol) (eq ?f:params ?symbols)) (retract ?f)))

(deffunction pddl-take-number (?instance ?name ?params ?value)
  "The numeric fluent is known with that value; its fact."
  (bind ?symbol (sym-cat ?name))
  (bind ?symbols (pddl-symbols ?params))
  (do-for-fact ((?f pddl-numeric-fluent)) (and (eq ?f:instance ?instance) (eq ?f:name ?symbol) (eq ?f:params ?symbols))
    (return (modify ?f (value (float ?value)))))
  (assert (pddl-numeric-fluent (instance ?instance) (name ?symbol) (params ?symbols) (value (float ?value)))))

; --- The manager

(defrule pddl-manager-connect
  "A manager is named: clients of all that it serves."
  ?manager <- (pddl-manager (node ?node) (ros-comm-init FALSE))
  =>
  (foreach ?pair (create$ "add_pddl_instance AddPddlInstance" "get_action_names GetActionNames" "get_fluents GetFluents"
      "get_functions GetFunctions" "get_predicates GetPredicates" "get_type_objects GetTypeObjects" "add_fluents AddFluents"
      "rm_fluents RemoveFluents" "set_functions SetFunctions" "add_objects AddObjects" "rm_objects RemoveObjects"
      "set_goals SetGoals" "clear_goals ClearGoals" "create_goal_instance CreateGoalInstance"
      "set_action_filter SetActionFilter" "set_fluent_filter SetFluentFilter" "set_object_filter SetObjectFilter"
      "check_action_condition CheckActionCondition" "get_action_effects GetActionEffects")
    (bind ?words (explode$ ?pair))
    (ros-msgs-create-client (str-cat ?node "/" (nth$ 1 ?words)) (str-cat "cx_pddl_interfaces/srv/" (nth$ 2 ?words))))
  (cx-pddl-interfaces-plan-temporal-create-client (str-cat ?node "/temp_plan"))
  (modify ?manager (ros-comm-init TRUE)))

(defrule pddl-manager-disconnect
  "The executive ends: the clients go."
  (executive-finalize)
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  =>
  (do-for-all-facts ((?c ros-msgs-client)) (eq (str-index (str-cat ?node "/") ?c:service) 1) (ros-msgs-destroy-client ?c:service))
  (do-for-all-facts ((?g pddl-plan-goal)) TRUE (cx-pddl-interfaces-plan-temporal-goal-destroy ?g:goal-ptr))
  (cx-pddl-interfaces-plan-temporal-destroy-client (str-cat ?node "/temp_plan")))

; --- Instances

(defrule pddl-instance-load
  (declare (salience ?*PDDL-SALIENCE-INSTANCES*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?instance <- (pddl-instance (name ?name) (domain ?domain) (problem ?problem) (directory ?directory) (state PENDING))
  =>
  (bind ?request (pddl-request AddPddlInstance nil nil))
  (ros-msgs-set-field ?request "name" (str-cat ?name))
  (ros-msgs-set-field ?request "directory" ?directory)
  (ros-msgs-set-field ?request "domain_file" ?domain)
  (ros-msgs-set-field ?request "problem_file" ?problem)
  (if (pddl-send ?node "add_pddl_instance" ?request instance ?name (fact-index ?instance)) then (pddl-becomes ?instance WAITING "")))

(defrule pddl-instance-loaded
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta instance ?name ?instance))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (pddl-becomes ?instance (if (eq ?error "") then LOADED else ERROR) ?error)
  (ros-msgs-destroy-message ?message)
  (retract ?response ?meta))

; --- Questions. meta: what, instance, more

(defrule pddl-ask-action-names
  (declare (salience ?*PDDL-SALIENCE-ACTION-NAMES*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-action-names (instance ?instance) (state PENDING))
  =>
  (if (pddl-send ?node "get_action_names" (pddl-request GetActionNames ?instance nil) action-names ?instance (fact-index ?ask))
   then (pddl-sent ?i GET-ACTION-NAMES ?ask WAITING)))

(defrule pddl-answer-action-names
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta action-names ?instance ?ask))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (fact-existp ?ask) then (modify ?ask (action-names (pddl-symbols (ros-msgs-get-field ?message "action_names")))))
  (pddl-close ?ask ?error)
  (pddl-answered ?instance ?message ?response ?meta))

(defrule pddl-ask-fluents
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-get-fluents (instance ?instance) (state PENDING))
  =>
  (if (pddl-send ?node "get_fluents" (pddl-request GetFluents ?instance nil) fluents ?instance (fact-index ?ask))
   then (pddl-sent ?i GET-FLUENTS ?ask WAITING)))

(defrule pddl-answer-fluents
  "The facts of the instance are those of the manager, no more and no less; those that were known stay as they are."
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta fluents ?instance ?ask))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (eq ?error "") then
    (bind ?now (create$))
    (foreach ?fluent (ros-msgs-get-field ?message "fluents")
      (bind ?now (create$ ?now (pddl-take-fluent ?instance (ros-msgs-get-field ?fluent "name") (ros-msgs-get-field ?fluent "args")))))
    (do-for-all-facts ((?f pddl-fluent)) (and (eq ?f:instance ?instance) (not (member$ ?f ?now))) (retract ?f)))
  (pddl-close ?ask ?error)
  (pddl-answered ?instance ?message ?response ?meta))

(defrule pddl-ask-numeric-fluents
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-get-numeric-fluents (instance ?instance) (state PENDING))
  =>
  (if (pddl-send ?node "get_functions" (pddl-request GetFunctions ?instance nil) functions ?instance (fact-index ?ask))
   then (pddl-sent ?i GET-NUMERIC-FLUENTS ?ask WAITING)))

(defrule pddl-answer-numeric-fluents
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta functions ?instance ?ask))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (eq ?error "") then
    (bind ?now (create$))
    (foreach ?function (ros-msgs-get-field ?message "functions")
      (bind ?now (create$ ?now (pddl-take-number ?instance (ros-msgs-get-field ?function "name") (ros-msgs-get-field ?function "args")
                                                 (ros-msgs-get-field ?function "value")))))
    (do-for-all-facts ((?f pddl-numeric-fluent)) (and (eq ?f:instance ?instance) (not (member$ ?f ?now))) (retract ?f)))
  (pddl-close ?ask ?error)
  (pddl-answered ?instance ?message ?response ?meta))

(defrule pddl-ask-predicates
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-get-predicates (instance ?instance) (state PENDING))
  =>
  (if (pddl-send ?node "get_predicates" (pddl-request GetPredicates ?instance nil) predicates ?instance (fact-index ?ask))
   then (pddl-sent ?i GET-PREDICATES ?ask WAITING)))

(defrule pddl-answer-predicates
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta predicates ?instance ?ask))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (foreach ?predicate (ros-msgs-get-field ?message "predicates")
    (assert (pddl-predicate (instance ?instance) (name (sym-cat (ros-msgs-get-field ?predicate "name")))
                            (param-types (pddl-symbols (ros-msgs-get-field ?predicate "param_types")))
                            (param-names (pddl-symbols (ros-msgs-get-field ?predicate "param_names"))))))
  (pddl-close ?ask ?error)
  (pddl-answered ?instance ?message ?response ?meta))

(defrule pddl-ask-type-objects
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-get-type-objects (instance ?instance) (type ?type) (state PENDING))
  =>
  (bind ?request (pddl-request GetTypeObjects ?instance nil))
  (ros-msgs-set-field ?request "type" (str-cat ?type))
  (if (pddl-send ?node "get_type_objects" ?request type-objects ?instance (fact-index ?ask) ?type)
   then (pddl-sent ?i GET-TYPE-OBJECTS ?ask WAITING)))

(defrule pddl-answer-type-objects
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta type-objects ?instance ?ask ?type))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (eq ?error "") then
    (do-for-all-facts ((?f pddl-type-objects)) (and (eq ?f:instance ?instance) (eq ?f:type ?type)) (retract ?f))
    (assert (pddl-type-objects (instance ?instance) (type ?type) (objects (pddl-symbols (ros-msgs-get-field ?message "objects"))))))
  (pddl-close ?ask ?error)
  (pddl-answered ?instance ?message ?response ?meta))

; --- Changes. All that are pending of one kind go in one request; deletes go first. What the manager refuses is tried again
; one at a time, so that a wrong change does not hold up the others.

(deffunction pddl-change-messages (?type ?changes)
  "A message for each change."
  (bind ?messages (create$))
  (foreach ?change ?changes
    (bind ?message (pddl-message ?type (fact-slot-value ?change instance) (fact-slot-value ?change name) (fact-slot-value ?change params)))
    (if (eq ?type Function) then (ros-msgs-set-field ?message "value" (float (fact-slot-value ?change value))))
    (bind ?messages (create$ ?messages ?message)))
  ?messages)

(deffunction pddl-send-changes (?node ?service ?request ?field ?messages ?changes ?i ?busy $?meta)
  "Sends the changes together."
  (ros-msgs-set-field ?request ?field ?messages)
  (foreach ?message ?messages (ros-msgs-destroy-message ?message))
  (if (pddl-send ?node ?service ?request ?meta) then
    (modify ?i (busy-with ?busy))
    (foreach ?change ?changes (pddl-becomes ?change WAITING ""))))

(deffunction pddl-refuse (?change ?error ?together)
  "The manager did not take it; of several each is tried alone."
  (if ?together then
    (assert (pddl-refused (change (fact-index ?change))))
    (pddl-becomes ?change PENDING ?error)
   else (pddl-becomes ?change ERROR ?error)))

(deffunction pddl-was-refused (?change)
  (any-factp ((?r pddl-refused)) (eq ?r:change (fact-index ?change))))

(deffunction pddl-close-changes ()
  "What was tried alone has been answered."
  (do-for-all-facts ((?r pddl-refused)) (or (not (fact-existp ?r:change)) (neq (fact-slot-value ?r:change state) PENDING)) (retract ?r)))

(defrule pddl-send-fluent-changes
  (declare (salience ?*PDDL-SALIENCE-FLUENTS*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?change <- (pddl-fluent-change (instance ?instance) (delete ?delete) (state PENDING))
  (or (test (eq ?delete TRUE))
      (not (pddl-fluent-change (instance ?instance) (delete TRUE) (state PENDING))))
  =>
  (bind ?changes (if (pddl-was-refused ?change) then (create$ ?change) else
    (find-all-facts ((?c pddl-fluent-change)) (and (eq ?c:instance ?instance) (eq ?c:delete ?delete) (eq ?c:state PENDING) (not (pddl-was-refused ?c))))))
  (pddl-send-changes ?node (if ?delete then "rm_fluents" else "add_fluents") (pddl-request (if ?delete then RemoveFluents else AddFluents) nil nil)
                     "fluents" (pddl-change-messages Fluent ?changes) ?changes ?i FLUENTS fluent-changes ?instance))

(defrule pddl-fluents-changed
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta fluent-changes ?instance))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (bind ?changes (find-all-facts ((?c pddl-fluent-change)) (and (eq ?c:instance ?instance) (eq ?c:state WAITING))))
  (do-for-all-facts ((?c pddl-fluent-change)) (and (eq ?c:instance ?instance) (eq ?c:state WAITING))
    (if (neq ?error "") then (pddl-refuse ?c ?error (> (length$ ?changes) 1))
     else
      (if ?c:delete then (pddl-drop-fluent ?instance ?c:name ?c:params) else (pddl-take-fluent ?instance ?c:name ?c:params))
      (retract ?c)))
  (pddl-close-changes)
  (pddl-answered ?instance ?message ?response ?meta))

(defrule pddl-send-numeric-changes
  (declare (salience ?*PDDL-SALIENCE-FLUENTS*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?change <- (pddl-numeric-fluent-change (instance ?instance) (state PENDING))
  =>
  (bind ?changes (if (pddl-was-refused ?change) then (create$ ?change) else
    (find-all-facts ((?c pddl-numeric-fluent-change)) (and (eq ?c:instance ?instance) (eq ?c:state PENDING) (not (pddl-was-refused ?c))))))
  (pddl-send-changes ?node "set_functions" (pddl-request SetFunctions nil nil) "functions" (pddl-change-messages Function ?changes) ?changes
                     ?i NUMERIC-FLUENTS numeric-changes ?instance))

(defrule pddl-numbers-changed
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta numeric-changes ?instance))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (bind ?changes (find-all-facts ((?c pddl-numeric-fluent-change)) (and (eq ?c:instance ?instance) (eq ?c:state WAITING))))
  (do-for-all-facts ((?c pddl-numeric-fluent-change)) (and (eq ?c:instance ?instance) (eq ?c:state WAITING))
    (if (neq ?error "") then (pddl-refuse ?c ?error (> (length$ ?changes) 1))
     else
      (pddl-take-number ?instance ?c:name ?c:params ?c:value)
      (retract ?c)))
  (pddl-close-changes)
  (pddl-answered ?instance ?message ?response ?meta))

(defrule pddl-send-object-change
  (declare (salience ?*PDDL-SALIENCE-OBJECTS*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?change <- (pddl-object-change (instance ?instance) (name ?name) (type ?type) (delete ?delete) (state PENDING))
  =>
  (bind ?object (ros-msgs-create-message "cx_pddl_interfaces/msg/Object"))
  (ros-msgs-set-field ?object "pddl_instance" (str-cat ?instance))
  (ros-msgs-set-field ?object "name" (str-cat ?name))
  (if (neq ?type nil) then (ros-msgs-set-field ?object "type" (str-cat ?type)))
  (bind ?request (pddl-request (if ?delete then RemoveObjects else AddObjects) nil nil))
  (ros-msgs-set-field ?request "objects" (create$ ?object))
  (ros-msgs-destroy-message ?object)
  (if (pddl-send ?node (if ?delete then "rm_objects" else "add_objects") ?request object-change ?instance (fact-index ?change) ?name ?delete)
   then (pddl-sent ?i OBJECTS ?change WAITING)))

(defrule pddl-object-changed
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta object-change ?instance ?change ?name ?delete))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (neq ?error "") then (pddl-becomes ?change ERROR ?error) else (if (fact-existp ?change) then (retract ?change)))
  (if (and ?delete (eq ?error "")) then
    (do-for-all-facts ((?f pddl-fluent)) (and (eq ?f:instance ?instance) (member$ (sym-cat ?name) ?f:params)) (retract ?f))
    (do-for-all-facts ((?f pddl-numeric-fluent)) (and (eq ?f:instance ?instance) (member$ (sym-cat ?name) ?f:params)) (retract ?f)))
  (pddl-answered ?instance ?message ?response ?meta))

; --- Goals and filters

(defrule pddl-send-clear-goals
  (declare (salience ?*PDDL-SALIENCE-CLEAR-GOALS*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-clear-goals (instance ?instance) (goal ?goal) (state PENDING))
  =>
  (if (pddl-send ?node "clear_goals" (pddl-request ClearGoals ?instance ?goal) clear-goals ?instance (fact-index ?ask))
   then (pddl-sent ?i CLEAR-GOALS ?ask WAITING)))

(defrule pddl-send-create-goal-instance
  (declare (salience ?*PDDL-SALIENCE-CREATE-GOAL*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-create-goal-instance (instance ?instance) (goal ?goal) (state PENDING))
  =>
  (if (pddl-send ?node "create_goal_instance" (pddl-request CreateGoalInstance ?instance ?goal) create-goal-instance ?instance (fact-index ?ask))
   then (pddl-sent ?i CREATE-GOAL-INSTANCE ?ask WAITING)))

(defrule pddl-send-set-goals
  (declare (salience ?*PDDL-SALIENCE-SET-GOALS*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-set-goals (instance ?instance) (goal ?goal) (state PENDING))
  =>
  (bind ?fluents (create$))
  (do-for-all-facts ((?g pddl-goal-fluent)) (and (eq ?g:instance ?instance) (eq ?g:goal ?goal))
    (bind ?fluents (create$ ?fluents (pddl-message Fluent ?instance ?g:name ?g:params))))
  (bind ?functions (create$))
  (do-for-all-facts ((?g pddl-goal-numeric-fluent)) (and (eq ?g:instance ?instance) (eq ?g:goal ?goal))
    (bind ?function (pddl-message Function ?instance ?g:name ?g:params))
    (ros-msgs-set-field ?function "value" (float ?g:value))
    (bind ?functions (create$ ?functions ?function)))
  (bind ?request (pddl-request SetGoals nil ?goal))
  (ros-msgs-set-field ?request "fluents" ?fluents)
  (ros-msgs-set-field ?request "functions" ?functions)
  (foreach ?part (create$ ?fluents ?functions) (ros-msgs-destroy-message ?part))
  (if (pddl-send ?node "set_goals" ?request set-goals ?instance (fact-index ?ask))
   then (pddl-sent ?i SET-GOALS ?ask WAITING)))

(defrule pddl-goals-answered
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta ?what&clear-goals|create-goal-instance|set-goals ?instance ?ask))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (pddl-close ?ask ?error)
  (pddl-answered ?instance ?message ?response ?meta))

(deffunction pddl-send-filter (?node ?i ?filter ?instance ?goal ?names ?service ?type ?field ?busy)
  (bind ?request (pddl-request ?type ?instance ?goal))
  (ros-msgs-set-field ?request ?field (pddl-strings ?names))
  (if (pddl-send ?node ?service ?request filter ?instance (fact-index ?filter))
   then (pddl-sent ?i ?busy ?filter WAITING)))

(defrule pddl-send-action-filter
  (declare (salience ?*PDDL-SALIENCE-ACTION-FILTER*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?f <- (pddl-planning-filter (type ACTIONS) (instance ?instance) (goal ?goal) (filter $?names) (state PENDING))
  =>
  (pddl-send-filter ?node ?i ?f ?instance ?goal ?names "set_action_filter" SetActionFilter "actions" SET-ACTION-FILTER))

(defrule pddl-send-fluent-filter
  (declare (salience ?*PDDL-SALIENCE-FLUENT-FILTER*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?f <- (pddl-planning-filter (type FLUENTS) (instance ?instance) (goal ?goal) (filter $?names) (state PENDING))
  =>
  (pddl-send-filter ?node ?i ?f ?instance ?goal ?names "set_fluent_filter" SetFluentFilter "fluents" SET-FLUENT-FILTER))

(defrule pddl-send-object-filter
  (declare (salience ?*PDDL-SALIENCE-OBJECT-FILTER*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?f <- (pddl-planning-filter (type OBJECTS) (instance ?instance) (goal ?goal) (filter $?names) (state PENDING))
  =>
  (pddl-send-filter ?node ?i ?f ?instance ?goal ?names "set_object_filter" SetObjectFilter "objects" SET-OBJECT-FILTER))

(defrule pddl-filter-answered
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta filter ?instance ?filter))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (eq ?error "") then
    (printout green TRUE " " ?error crlf)
    (if (fact-existp ?filter) then (retract ?filter))
   else
    (pddl-becomes ?filter ERROR ?error))
  (pddl-answered ?instance ?message ?response ?meta))

; --- Plans. A goal's response does not say which goal it means, so one goal at a time waits for it (it has no handle yet);
; many are PLANNING. A plan may be retracted meanwhile: its goal is still answered, and the answer dropped.

(deffunction pddl-plan-becomes (?plan ?state ?goal ?handle)
  (modify ?plan (state ?state) (goal-ptr ?goal) (goal-handle ?handle)))

(defrule pddl-send-plan
  (declare (salience ?*PDDL-SALIENCE-PLAN*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?plan <- (pddl-plan (instance ?instance) (goal ?goal) (output-dir ?directory) (state PENDING))
  (not (pddl-plan-goal (goal-handle nil)))
  =>
  (bind ?wanted (cx-pddl-interfaces-plan-temporal-goal-create))
  (cx-pddl-interfaces-plan-temporal-goal-set-field ?wanted "pddl_instance" (str-cat ?instance))
  (cx-pddl-interfaces-plan-temporal-goal-set-field ?wanted "goal_instance" (str-cat ?goal))
  (cx-pddl-interfaces-plan-temporal-goal-set-field ?wanted "output_dir" ?directory)
  (cx-pddl-interfaces-plan-temporal-send-goal ?wanted (str-cat ?node "/temp_plan"))
  (assert (pddl-plan-goal (goal-ptr ?wanted)))
  (modify ?plan (state WAITING) (goal-ptr ?wanted)))

(defrule pddl-plan-accepted
  (pddl-manager (node ?node))
  ?response <- (cx-pddl-interfaces-plan-temporal-goal-response (server ?server) (client-goal-handle-ptr ?handle))
  (test (eq ?server (str-cat ?node "/temp_plan")))
  ?sent <- (pddl-plan-goal (goal-ptr ?goal) (goal-handle nil))
  =>
  (retract ?response)
  (if (pddl-is-set ?handle) then
    (do-for-fact ((?plan pddl-plan)) (eq ?plan:goal-ptr ?goal) (pddl-plan-becomes ?plan (if (eq ?plan:state WAITING) then PLANNING else ?plan:state) ?goal ?handle))
    (modify ?sent (goal-handle ?handle))
   else
    (printout red "plan was refused!" crlf)
    (do-for-fact ((?plan pddl-plan)) (eq ?plan:goal-ptr ?goal) (pddl-plan-becomes ?plan FAILED nil nil))
    (cx-pddl-interfaces-plan-temporal-goal-destroy ?goal)
    (retract ?sent)))

(defrule pddl-plan-cancel
  (pddl-manager (node ?node))
  ?plan <- (pddl-plan (goal-handle ?handle&:(pddl-is-set ?handle)) (state REQUEST-CANCELING))
  =>
  (cx-pddl-interfaces-plan-temporal-client-cancel-goal (str-cat ?node "/temp_plan") ?handle)
  (modify ?plan (state CANCELING)))

(defrule pddl-plan-cancel-unsent
  "It has not reached the manager yet."
  ?plan <- (pddl-plan (goal-handle ?handle&:(not (pddl-is-set ?handle))) (goal-ptr ?goal&:(not (pddl-is-set ?goal))) (state REQUEST-CANCELING))
  =>
  (modify ?plan (state CANCELED)))

(defrule pddl-plan-cancel-answered
  ?response <- (cx-pddl-interfaces-plan-temporal-cancel-goal-response)
  =>
  (do-for-all-facts ((?e cx-pddl-interfaces-plan-temporal-cancel-goal-entry)) TRUE (retract ?e))
  (retract ?response))

(deffunction pddl-take-steps (?result ?plan ?instance)
  "The plan's steps become facts; they count from 0."
  (bind ?number 0)
  (foreach ?action (cx-pddl-interfaces-plan-temporal-result-get-field ?result "actions")
    (assert (pddl-action (instance ?instance) (plan ?plan) (id ?number)
                         (name (sym-cat (ros-msgs-get-field ?action "name"))) (params (ros-msgs-get-field ?action "args"))
                         (planned-start-time (ros-msgs-get-field ?action "start_time"))
                         (planned-duration (ros-msgs-get-field ?action "duration"))))
    (bind ?number (+ ?number 1))))

(deffunction pddl-end-of-plan (?code ?result)
  "What became of a plan."
  (if (eq ?code CANCELED) then (return CANCELED))
  (if (and (eq ?code SUCCEEDED) (cx-pddl-interfaces-plan-temporal-result-get-field ?result "success")) then SUCCESS else FAILED))

(defrule pddl-plan-ended
  ?end <- (cx-pddl-interfaces-plan-temporal-wrapped-result (goal-id ?uuid) (code ?code) (result-ptr ?result))
  ?sent <- (pddl-plan-goal (goal-ptr ?goal) (goal-handle ?handle&~nil))
  (test (eq ?uuid (cx-pddl-interfaces-plan-temporal-client-goal-handle-get-goal-id ?handle)))
  =>
  (bind ?state (pddl-end-of-plan ?code ?result))
  (do-for-fact ((?plan pddl-plan)) (eq ?plan:goal-ptr ?goal)
    (switch ?state
      (case SUCCESS then (pddl-take-steps ?result ?plan:id ?plan:instance))
      (case FAILED then (printout red "plan not found!" crlf)))
    (pddl-plan-becomes ?plan ?state nil nil))
  (retract ?sent)
  (cx-pddl-interfaces-plan-temporal-goal-destroy ?goal)
  (cx-pddl-interfaces-plan-temporal-client-goal-handle-destroy ?handle)
  (cx-pddl-interfaces-plan-temporal-result-destroy ?result)
  (retract ?end))

; --- Conditions and effects of a step

(defrule pddl-send-condition
  (declare (salience ?*PDDL-SALIENCE-CONDITIONS*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-action-condition (instance ?instance) (action ?action) (state PENDING))
  (pddl-action (instance ?instance) (id ?action) (plan ?plan&:(pddl-agrees ?ask plan ?plan)) (name ?name) (params $?params))
  =>
  (bind ?message (pddl-message Action ?instance ?name ?params))
  (bind ?request (pddl-request CheckActionCondition nil nil))
  (ros-msgs-set-field ?request "action" ?message)
  (ros-msgs-destroy-message ?message)
  (if (pddl-send ?node "check_action_condition" ?request condition ?instance (fact-index ?ask))
   then (pddl-sent ?i CHECK-CONDITIONS ?ask CHECK-CONDITION)))

(defrule pddl-condition-checked
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta condition ?instance ?ask))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (bind ?missing (create$))
  (foreach ?condition (ros-msgs-get-field ?message "unsatisfied_conditions") (bind ?missing (create$ ?condition ?missing)))
  (bind ?state (if (ros-msgs-get-field ?message "sat") then CONDITION-SAT else CONDITION-UNSAT))
  (if (fact-existp ?ask) then (modify ?ask (unsatisfied-conditions ?missing)))
  (pddl-becomes ?ask (if (eq ?error "") then ?state else ERROR) ?error)
  (pddl-answered ?instance ?message ?response ?meta))

(defrule pddl-send-get-effect
  "The effects at the end are asked for when those at the start have come true."
  (declare (salience ?*PDDL-SALIENCE-EFFECTS*))
  (time ?) (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-action-get-effect (action ?action) (state ?state&PENDING|START-EFFECT-APPLIED))
  (test (pddl-agrees ?ask instance ?instance))
  (pddl-action (instance ?instance) (id ?action) (plan ?plan&:(pddl-agrees ?ask plan ?plan)) (name ?name) (params $?params))
  (not (pddl-fluent-change (instance ?instance) (state PENDING)))
  (not (pddl-numeric-fluent-change (instance ?instance) (state PENDING)))
  =>
  (bind ?message (pddl-message Action ?instance ?name ?params))
  (bind ?request (pddl-request GetActionEffects nil nil))
  (ros-msgs-set-field ?request "action" ?message)
  (ros-msgs-destroy-message ?message)
  (if (pddl-send ?node "get_action_effects" ?request effects ?instance (fact-index ?ask) (if (eq ?state PENDING) then START else END))
   then
    (pddl-put ?ask instance ?instance)
    (pddl-sent ?i ACTION-EFFECTS ?ask WAITING)))

(deffunction pddl-take-fluent-effect (?instance ?action ?fluent ?value ?apply ?point)
  "A change to make, or a fact to look at where the fluent becomes true."
  (bind ?name (sym-cat (ros-msgs-get-field ?fluent "name")))
  (bind ?params (pddl-symbols (ros-msgs-get-field ?fluent "args")))
  (if ?apply then (assert (pddl-fluent-change (instance ?instance) (name ?name) (params ?params) (delete (not ?value))))
   else (if ?value then (assert (pddl-effect-fluent (instance ?instance) (action ?action) (name ?name) (params ?params) (effect-type ?point))))))

(deffunction pddl-take-number-effect (?instance ?action ?function ?op ?new ?apply ?point)
  "A change to make, or a fact to look at; with the value afterwards."
  (bind ?name (sym-cat (ros-msgs-get-field ?function "name")))
  (bind ?params (pddl-symbols (ros-msgs-get-field ?function "args")))
  (bind ?value (pddl-apply-op ?op (pddl-value-of ?instance ?name ?params) ?new))
  (if ?apply then (assert (pddl-numeric-fluent-change (instance ?instance) (name ?name) (params ?params) (value ?value)))
   else (assert (pddl-effect-numeric-fluent (instance ?instance) (action ?action) (name ?name) (params ?params) (value ?value) (effect-type ?point)))))

(deffunction pddl-take-effects (?message ?instance ?action ?apply ?point)
  "The effects of one time point."
  (foreach ?effect (ros-msgs-get-field ?message "fluent_effects")
    (if (eq (ros-msgs-get-field ?effect "time_point") (str-cat ?point)) then
      (pddl-take-fluent-effect ?instance ?action (ros-msgs-get-field ?effect "fluent") (ros-msgs-get-field ?effect "value") ?apply ?point)))
  (foreach ?effect (ros-msgs-get-field ?message "function_effects")
    (if (eq (ros-msgs-get-field ?effect "time_point") (str-cat ?point)) then
      (pddl-take-number-effect ?instance ?action (ros-msgs-get-field ?effect "function") (ros-msgs-get-field ?effect "operator_type")
                               (ros-msgs-get-field ?effect "value") ?apply ?point))))

(deffunction pddl-number-missing (?message ?instance)
  "Whether an effect changes a number by something that is not known here, though it may be asked for."
  (if (any-factp ((?ask pddl-get-numeric-fluents)) (and (eq ?ask:instance ?instance) (member$ ?ask:state (create$ DONE ERROR)))) then (return FALSE))
  (foreach ?effect (ros-msgs-get-field ?message "function_effects")
    (bind ?function (ros-msgs-get-field ?effect "function"))
    (bind ?name (sym-cat (ros-msgs-get-field ?function "name")))
    (bind ?params (pddl-symbols (ros-msgs-get-field ?function "args")))
    (if (and (neq (ros-msgs-get-field ?effect "operator_type") "=")
             (not (any-factp ((?f pddl-numeric-fluent)) (and (eq ?f:instance ?instance) (eq ?f:name ?name) (eq ?f:params ?params)))))
     then (return TRUE)))
  FALSE)

(deffunction pddl-tell-effects (?message ?instance ?action ?type ?apply ?asked)
  "What is due becomes changes, or facts; the state of the question afterwards. Numbers that it needs are asked for first.
  Asked for were the effects from START on, or the rest from END on."
  (if (pddl-number-missing ?message ?instance) then
    (assert (pddl-get-numeric-fluents (instance ?instance)))
    (return (if (eq ?asked START) then PENDING else START-EFFECT-APPLIED)))
  (if (and (neq ?type END) (eq ?asked START)) then (pddl-take-effects ?message ?instance ?action ?apply START))
  (if (and (eq ?type ALL) ?apply (eq ?asked START)) then (return START-EFFECT-APPLIED))
  (if (neq ?type START) then (pddl-take-effects ?message ?instance ?action ?apply END))
  DONE)

(defrule pddl-effects-told
  ?meta <- (pddl-service-request-meta (service ?service) (request-id ?id) (meta effects ?instance ?ask ?asked))
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (fact-existp ?ask) then
    (pddl-becomes ?ask (if (neq ?error "") then ERROR
                        else (pddl-tell-effects ?message ?instance (fact-slot-value ?ask action) (fact-slot-value ?ask effect-type)
                                                (fact-slot-value ?ask apply) ?asked)) ?error))
  (pddl-answered ?instance ?message ?response ?meta))
