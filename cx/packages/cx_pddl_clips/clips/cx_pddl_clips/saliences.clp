; Priorities and functions that every file of this package needs. Agents may load the files one by one: this one first,
; then deftemplates.clp. Needs the plugin cx::RosMsgsPlugin. Facts without a template are notes of these rules.
; A note (pddl-asked SERVICE ID INSTANCE WHAT ...) is an open request, with the fact of its instance.
; A note (pddl-dropped INSTANCE NAME PARAMS...) is a fluent that is no longer true. It stays until the fluent's fact is removed.
; A note (pddl-refused CHANGE) is a change, by its index. It was refused together with others and is tried alone.
; A note (pddl-plan-goal GOAL HANDLE) is a goal that was sent for a plan. Its handle is nil until the goal is accepted.
;
; An instance is asked one thing at a time: its slot busy-with says which. A request that finds no manager stays PENDING and
; is sent again at the next tick. Where several requests wait for an instance, these numbers say which goes first, as in the
; CLIPS-Executive; agents count on it (objects before the fluents that name them, goals before the plan). Questions go at once.
; An agent may redefine a template with more slots and states, so these rules rely only on the slots and states that CX has.

(defglobal
  ?*PRIORITY-PDDL-INSTANCES* = -5100
  ?*PRIORITY-PDDL-GET-ACTION-NAMES* = -5300
  ?*PRIORITY-PDDL-OBJECTS* = -5400
  ?*PRIORITY-PDDL-FLUENTS* = -5500
  ?*PRIORITY-PDDL-APPLY-EFFECT* = -5600
  ?*PRIORITY-PDDL-CLEAR-GOALS* = -5700
  ?*PRIORITY-PDDL-CREATE-GOAL-INSTANCE* = -5800
  ?*PRIORITY-PDDL-SET-ACTION-FILTER* = -5900
  ?*PRIORITY-PDDL-SET-FLUENT-FILTER* = -6000
  ?*PRIORITY-PDDL-SET-OBJECT-FILTER* = -6100
  ?*PRIORITY-PDDL-SET-GOALS* = -6200
  ?*PRIORITY-PDDL-PLAN* = -6300
  ?*PRIORITY-PDDL-CHECK-CONDITION* = -6400
  ?*PRIORITY-PDDL-GET-FLUENTS* = -6500)

(deffunction pddl-strings (?items)
  "All items as strings."
  (bind ?texts (create$))
  (foreach ?item ?items (bind ?texts (create$ ?texts (str-cat ?item))))
  ?texts)

(deffunction pddl-symbols (?items)
  "All items as symbols."
  (bind ?symbols (create$))
  (foreach ?item ?items (bind ?symbols (create$ ?symbols (sym-cat ?item))))
  ?symbols)

(deffunction pddl-message (?type ?instance ?name ?params)
  "Make a new Fluent, Function or Action message."
  (bind ?message (ros-msgs-create-message (str-cat "cx_pddl_interfaces/msg/" ?type)))
  (ros-msgs-set-field ?message "pddl_instance" (str-cat ?instance))
  (ros-msgs-set-field ?message "name" (str-cat ?name))
  (ros-msgs-set-field ?message "args" (pddl-strings ?params))
  ?message)

(deffunction pddl-request (?type ?instance ?goal)
  "Make a new request about an instance, and about a goal if one is given."
  (bind ?request (ros-msgs-create-request (str-cat "cx_pddl_interfaces/srv/" ?type)))
  (if (neq ?instance nil) then (ros-msgs-set-field ?request "pddl_instance" (str-cat ?instance)))
  (if (neq ?goal nil) then (ros-msgs-set-field ?request "goal_instance" (str-cat ?goal)))
  ?request)

(deffunction pddl-send (?node ?service ?request ?i ?busy $?about)
  "Send a request, with which the instance is busy from now on, and note its subject. Returns its number, or FALSE without a manager."
  (bind ?name (str-cat ?node "/" ?service))
  (bind ?id (ros-msgs-async-send-request ?request ?name))
  (ros-msgs-destroy-message ?request)
  (if ?id then
    (assert (pddl-asked ?name ?id ?i ?about))
    (modify ?i (busy-with ?busy)))
  ?id)

(deffunction pddl-error-of (?response)
  (if (ros-msgs-get-field ?response "success") then "" else (ros-msgs-get-field ?response "error")))

(deffunction pddl-agrees (?ask ?slot ?value)
  "Whether a request can mean this value: its slot has the value or nil, or the slot does not exist."
  (or (not (deftemplate-slot-existp (fact-relation ?ask) ?slot)) (eq (fact-slot-value ?ask ?slot) nil) (eq (fact-slot-value ?ask ?slot) ?value)))

(deffunction pddl-is-set (?pointer)
  "FALSE for nil, and for the null pointer, which is the first value of a slot of external addresses."
  (bind ?text (implode$ (create$ ?pointer)))
  (not (or (eq ?pointer nil) (str-index "(nil)" ?text) (str-index "0x0>" ?text))))

(deffunction pddl-becomes (?ask ?state ?error)
  "Set the state of a request, if it still exists. Print errors."
  (if (fact-existp ?ask) then
    (if (eq ?state ERROR) then (printout error (fact-relation ?ask) ": " ?error crlf))
    (if (deftemplate-slot-existp (fact-relation ?ask) error)
     then (modify ?ask (error ?error) (state ?state))
     else (modify ?ask (state ?state)))))

(deffunction pddl-close (?ask ?error)
  "Set a question or request to DONE, or to ERROR with a reason."
  (pddl-becomes ?ask (if (eq ?error "") then DONE else ERROR) ?error))

(deffunction pddl-waits (?change ?id)
  "The request was sent: note its number, if the template has a slot for it, and forget the error of an earlier try."
  (if (deftemplate-slot-existp (fact-relation ?change) error) then (modify ?change (error "")))
  (if (deftemplate-slot-existp (fact-relation ?change) request-id)
   then (modify ?change (request-id ?id) (state WAITING))
   else (modify ?change (state WAITING))))

(deffunction pddl-answered (?i ?message ?response ?note)
  "The answer was taken: drop it, so that the instance can be asked the next thing."
  (ros-msgs-destroy-message ?message)
  (retract ?response ?note)
  (if (fact-existp ?i) then (modify ?i (busy-with FALSE))))

(deffunction pddl-change-messages (?type ?changes)
  "Make a message for each change."
  (bind ?messages (create$))
  (foreach ?change ?changes
    (bind ?message (pddl-message ?type (fact-slot-value ?change instance) (fact-slot-value ?change name) (fact-slot-value ?change params)))
    (if (eq ?type Function) then (ros-msgs-set-field ?message "value" (float (fact-slot-value ?change value))))
    (bind ?messages (create$ ?messages ?message)))
  ?messages)

(deffunction pddl-send-changes (?node ?service ?request ?field ?messages ?changes ?i ?busy $?about)
  "Send the changes together."
  (ros-msgs-set-field ?request ?field ?messages)
  (foreach ?message ?messages (ros-msgs-destroy-message ?message))
  (bind ?id (pddl-send ?node ?service ?request ?i ?busy ?about))
  (if ?id then (foreach ?change ?changes (pddl-waits ?change ?id))))

(deffunction pddl-refuse (?change ?error ?together)
  "The manager refused the changes: a single one is an error, several are tried one by one."
  (if ?together then
    (assert (pddl-refused (fact-index ?change)))
    (pddl-becomes ?change PENDING ?error)
   else (pddl-becomes ?change ERROR ?error)))

(deffunction pddl-was-refused (?change)
  (any-factp ((?r pddl-refused)) (eq ?r:implied (create$ (fact-index ?change)))))

(deffunction pddl-close-changes ()
  "The change that was tried alone has its answer: close it."
  (do-for-all-facts ((?r pddl-refused)) TRUE
    (bind ?change (nth$ 1 ?r:implied))
    (if (or (not (fact-existp ?change)) (neq (fact-slot-value ?change state) PENDING)) then (retract ?r))))
