; The effects of a step: as changes, or as facts to look at.

(deffunction pddl-apply-op (?op ?value ?new)
  "The value after an effect: = sets it, + and - change it."
  (switch (str-cat ?op)
    (case "+" then (+ ?value ?new))
    (case "-" then (- ?value ?new))
    (default ?new)))

(deffunction pddl-value-of (?instance ?name ?params)
  "The numeric fluent as it is known here; 0 if it is not known."
  (do-for-fact ((?f pddl-numeric-fluent)) (and (eq ?f:instance ?instance) (eq ?f:name ?name) (eq ?f:params ?params)) (return ?f:value))
  0.0)

(deffunction pddl-is-about (?ask ?instance)
  "Put the instance of the action into the slot `instance`, if the template has it."
  (if (deftemplate-slot-existp (fact-relation ?ask) instance) then (modify ?ask (instance ?instance))))

(defrule pddl-send-get-effect
  "A question about effects waits: send it. Effects at the end are asked for when those at the start have become true."
  (declare (salience ?*PRIORITY-PDDL-APPLY-EFFECT*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  ?i <- (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?ask <- (pddl-action-get-effect (action ?action) (state ?state&PENDING|START-EFFECT-APPLIED))
  (test (pddl-agrees ?ask instance ?instance))
  (pddl-action (instance ?instance) (id ?action) (plan ?plan&:(pddl-agrees ?ask plan ?plan)) (name ?name) (params $?params))
  (not (pddl-fluent-change (instance ?instance) (state PENDING)))
  (not (pddl-numeric-fluent-change (instance ?instance) (state PENDING)))
  (time ?)
  =>
  (bind ?message (pddl-message Action ?instance ?name ?params))
  (bind ?request (pddl-request GetActionEffects nil nil))
  (ros-msgs-set-field ?request "action" ?message)
  (ros-msgs-destroy-message ?message)
  (if (pddl-send ?node "get_action_effects" ?request ?i ACTION-EFFECTS effects ?instance ?ask (if (eq ?state PENDING) then START else END))
   then
    (pddl-is-about ?ask ?instance)
    (pddl-becomes ?ask WAITING "")))

(deffunction pddl-take-fluent-effect (?instance ?action ?fluent ?value ?apply ?point)
  "Assert a change to make, or a fact to look at if the fluent becomes true."
  (bind ?name (sym-cat (ros-msgs-get-field ?fluent "name")))
  (bind ?params (pddl-symbols (ros-msgs-get-field ?fluent "args")))
  (if ?apply then (assert (pddl-fluent-change (instance ?instance) (name ?name) (params ?params) (delete (not ?value))))
   else (if ?value then (assert (pddl-effect-fluent (instance ?instance) (action ?action) (name ?name) (params ?params) (effect-type ?point))))))

(deffunction pddl-take-number-effect (?instance ?action ?function ?op ?new ?apply ?point)
  "Assert a change to make, or a fact to look at, with the new value."
  (bind ?name (sym-cat (ros-msgs-get-field ?function "name")))
  (bind ?params (pddl-symbols (ros-msgs-get-field ?function "args")))
  (bind ?value (pddl-apply-op ?op (pddl-value-of ?instance ?name ?params) ?new))
  (if ?apply then (assert (pddl-numeric-fluent-change (instance ?instance) (name ?name) (params ?params) (value ?value)))
   else (assert (pddl-effect-numeric-fluent (instance ?instance) (action ?action) (name ?name) (params ?params) (value ?value) (effect-type ?point)))))

(deffunction pddl-take-effects (?message ?instance ?action ?apply ?point)
  "Take all effects of one time point."
  (foreach ?effect (ros-msgs-get-field ?message "fluent_effects")
    (if (eq (ros-msgs-get-field ?effect "time_point") (str-cat ?point)) then
      (pddl-take-fluent-effect ?instance ?action (ros-msgs-get-field ?effect "fluent") (ros-msgs-get-field ?effect "value") ?apply ?point)))
  (foreach ?effect (ros-msgs-get-field ?message "function_effects")
    (if (eq (ros-msgs-get-field ?effect "time_point") (str-cat ?point)) then
      (pddl-take-number-effect ?instance ?action (ros-msgs-get-field ?effect "function") (ros-msgs-get-field ?effect "operator_type")
                               (ros-msgs-get-field ?effect "value") ?apply ?point))))

(deffunction pddl-number-missing (?message ?instance)
  "Whether an effect changes a number whose value is not known here, and nobody has asked for the numbers yet."
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
  "Turn the due effects into changes or facts, and return the new state of the question. First ask for the numbers that they need.
  The question was about the effects from START on, or about the rest from END on."
  (if (pddl-number-missing ?message ?instance) then
    (assert (pddl-get-numeric-fluents (instance ?instance)))
    (return (if (eq ?asked START) then PENDING else START-EFFECT-APPLIED)))
  (if (and (neq ?type END) (eq ?asked START)) then (pddl-take-effects ?message ?instance ?action ?apply START))
  (if (and (eq ?type ALL) ?apply (eq ?asked START)) then (return START-EFFECT-APPLIED))
  (if (neq ?type START) then (pddl-take-effects ?message ?instance ?action ?apply END))
  DONE)

(defrule pddl-effects-told
  ?note <- (pddl-asked ?service ?id ?i effects ?instance ?ask ?asked)
  ?response <- (ros-msgs-response (service ?service) (request-id ?id) (msg-ptr ?message))
  =>
  (bind ?error (pddl-error-of ?message))
  (if (fact-existp ?ask) then
    (pddl-becomes ?ask (if (neq ?error "") then ERROR
                        else (pddl-tell-effects ?message ?instance (fact-slot-value ?ask action) (fact-slot-value ?ask effect-type)
                                                (fact-slot-value ?ask apply) ?asked)) ?error))
  (pddl-answered ?i ?message ?response ?note))
