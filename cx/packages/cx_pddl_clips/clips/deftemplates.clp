; Facts of the helper rules. An agent may define a template anew, with more slots, after this file and before
; pddl-no-deftemplates.clp. Requests begin with the state PENDING; the rules do the rest.

(deftemplate pddl-manager "The node to talk to."
  (slot node (type STRING) (default "/pddl_manager"))
  (slot ros-comm-init (type SYMBOL) (allowed-values TRUE FALSE) (default FALSE)))

(deftemplate pddl-service-request-meta "A request that is under way, and whose it is."
  (slot service (type STRING))
  (slot request-id (type INTEGER))
  (multislot meta))

(deftemplate pddl-instance "A domain with a problem, loaded by the manager. An empty problem loads the domain alone."
  (slot name)
  (slot domain (type STRING))
  (slot problem (type STRING))
  (slot directory (type STRING))
  (slot state (type SYMBOL) (allowed-values PENDING WAITING LOADED ERROR) (default PENDING))
  (slot busy-with (type SYMBOL)
    (allowed-values FALSE OBJECTS FLUENTS NUMERIC-FLUENTS ACTION-EFFECTS CREATE-GOAL-INSTANCE CLEAR-GOALS SET-GOALS
                    CHECK-CONDITIONS GET-FLUENTS GET-NUMERIC-FLUENTS GET-PREDICATES GET-TYPE-OBJECTS GET-ACTION-NAMES
                    SET-ACTION-FILTER SET-OBJECT-FILTER SET-FLUENT-FILTER)
    (default FALSE))
  (slot error (type STRING)))

; --- What is so, as far as it was asked for or changed

(deftemplate pddl-fluent (slot instance) (slot name (type SYMBOL)) (multislot params))
(deftemplate pddl-numeric-fluent (slot instance) (slot name (type SYMBOL)) (multislot params) (slot value (type FLOAT)))
(deftemplate pddl-predicate (slot instance) (slot name (type SYMBOL)) (multislot param-types) (multislot param-names))
(deftemplate pddl-type-objects (slot instance) (slot type) (multislot objects))

; --- Questions

(deftemplate pddl-get-fluents
  (slot instance) (slot state (type SYMBOL) (allowed-values PENDING WAITING DONE ERROR) (default PENDING)) (slot error (type STRING)))
(deftemplate pddl-get-numeric-fluents
  (slot instance) (slot state (type SYMBOL) (allowed-values PENDING WAITING DONE ERROR) (default PENDING)) (slot error (type STRING)))
(deftemplate pddl-get-predicates
  (slot instance) (slot state (type SYMBOL) (allowed-values PENDING WAITING DONE ERROR) (default PENDING)) (slot error (type STRING)))
(deftemplate pddl-get-type-objects
  (slot instance) (slot type)
  (slot state (type SYMBOL) (allowed-values PENDING WAITING DONE ERROR) (default PENDING)) (slot error (type STRING)))
(deftemplate pddl-action-names
  (slot instance) (multislot action-names)
  (slot state (type SYMBOL) (allowed-values PENDING WAITING DONE ERROR) (default PENDING)) (slot error (type STRING)))

; --- Changes

(deftemplate pddl-fluent-change
  (slot instance) (slot name) (multislot params) (slot delete (type SYMBOL) (allowed-values TRUE FALSE) (default FALSE))
  (slot state (type SYMBOL) (allowed-values PENDING WAITING ERROR) (default PENDING)) (slot error (type STRING)))
(deftemplate pddl-numeric-fluent-change
  (slot instance) (slot name) (multislot params) (slot value (type NUMBER))
  (slot state (type SYMBOL) (allowed-values PENDING WAITING ERROR) (default PENDING)) (slot error (type STRING)))
(deftemplate pddl-object-change
  (slot instance) (slot name) (slot type) (slot delete (type SYMBOL) (allowed-values TRUE FALSE) (default FALSE))
  (slot state (type SYMBOL) (allowed-values PENDING WAITING ERROR) (default PENDING)) (slot error (type STRING)))

(deftemplate pddl-refused "A change, by its index, that was refused together with others; it is tried alone." (slot change))

; --- Goals and plans

(deftemplate pddl-goal-fluent (slot instance) (slot goal) (slot name) (multislot params))
(deftemplate pddl-goal-numeric-fluent (slot instance) (slot goal) (slot name) (multislot params) (slot value (type NUMBER)))
(deftemplate pddl-create-goal-instance
  (slot instance) (slot goal)
  (slot state (type SYMBOL) (allowed-values PENDING WAITING DONE ERROR) (default PENDING)) (slot error (type STRING)))
(deftemplate pddl-clear-goals
  (slot instance) (slot goal)
  (slot state (type SYMBOL) (allowed-values PENDING WAITING DONE ERROR) (default PENDING)) (slot error (type STRING)))
(deftemplate pddl-set-goals
  (slot instance) (slot goal)
  (slot state (type SYMBOL) (allowed-values PENDING WAITING DONE ERROR) (default PENDING)) (slot error (type STRING)))
(deftemplate pddl-planning-filter
  (slot instance) (slot goal) (slot type (type SYMBOL) (allowed-values ACTIONS OBJECTS FLUENTS)) (multislot filter)
  (slot state (type SYMBOL) (allowed-values PENDING WAITING ERROR) (default PENDING)) (slot error (type STRING)))
(deftemplate pddl-plan "A plan that is wanted; the actions of it come as pddl-action facts."
  (slot instance)
  (slot id (default-dynamic (gensym*)))
  (slot goal (default base))
  (slot goal-ptr)
  (slot plan-type)
  (slot goal-handle)
  (slot output-dir (type STRING))
  (slot type (type SYMBOL) (default TEMPORAL))
  (slot state (type SYMBOL)
    (allowed-values PENDING WAITING PLANNING SUCCESS FAILED REQUEST-CANCELING CANCELING CANCELED) (default PENDING)))
(deftemplate pddl-plan-goal "A goal that was sent for a plan, and its handle when it has been accepted." (slot goal-ptr) (slot goal-handle))
(deftemplate pddl-action "A step of a plan; its id counts from 0 in the plan."
  (slot instance) (slot id) (slot name (type SYMBOL)) (multislot params) (slot plan)
  (slot planned-start-time (type FLOAT)) (slot planned-duration (type FLOAT)))

; --- Conditions and effects of a step

(deftemplate pddl-action-condition
  (slot instance) (slot action) (slot plan)
  (slot state (type SYMBOL) (allowed-values PENDING CHECK-CONDITION CONDITION-SAT CONDITION-UNSAT ERROR) (default PENDING))
  (multislot unsatisfied-conditions) (slot error (type STRING)))
(deftemplate pddl-action-get-effect
  (slot instance) (slot action) (slot plan)
  (slot effect-type (type SYMBOL) (allowed-values ALL START END) (default ALL))
  (slot apply (type SYMBOL) (allowed-values TRUE FALSE) (default FALSE))
  (slot state (type SYMBOL) (allowed-values PENDING WAITING START-EFFECT-APPLIED DONE ERROR) (default PENDING)) (slot error (type STRING)))
(deftemplate pddl-effect-fluent (slot instance) (slot action) (slot name) (multislot params) (slot effect-type))
(deftemplate pddl-effect-numeric-fluent (slot instance) (slot action) (slot name) (multislot params) (slot value) (slot effect-type))
