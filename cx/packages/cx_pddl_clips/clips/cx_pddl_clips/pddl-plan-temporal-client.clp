; Plans. Needs the plugin cx::CXCxPddlInterfacesPlanTemporalPlugin. A goal's response does not say which goal it means, so one
; goal at a time waits for it (it has no handle yet); many are PLANNING. A plan may be retracted meanwhile: its goal is still
; answered, and the answer dropped.

(defrule pddl-plan-connect
  "A manager is named: open a client of its action."
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  (not (executive-finalize))
  (not (cx-pddl-interfaces-plan-temporal-client (server ?server&:(eq ?server (str-cat ?node "/temp_plan")))))
  =>
  (cx-pddl-interfaces-plan-temporal-create-client (str-cat ?node "/temp_plan")))

(deffunction pddl-plan-becomes (?plan ?state ?goal ?handle)
  (modify ?plan (state ?state) (goal-ptr ?goal) (goal-handle ?handle)))

(defrule pddl-send-plan
  (declare (salience ?*PRIORITY-PDDL-PLAN*))
  (pddl-manager (node ?node) (ros-comm-init TRUE))
  (pddl-instance (name ?instance) (state LOADED) (busy-with FALSE))
  ?plan <- (pddl-plan (instance ?instance) (goal ?goal) (output-dir ?directory) (state PENDING))
  (not (pddl-plan-goal ? nil))
  =>
  (bind ?wanted (cx-pddl-interfaces-plan-temporal-goal-create))
  (cx-pddl-interfaces-plan-temporal-goal-set-field ?wanted "pddl_instance" (str-cat ?instance))
  (cx-pddl-interfaces-plan-temporal-goal-set-field ?wanted "goal_instance" (str-cat (if (eq ?goal nil) then base else ?goal)))
  (cx-pddl-interfaces-plan-temporal-goal-set-field ?wanted "output_dir" ?directory)
  (cx-pddl-interfaces-plan-temporal-send-goal ?wanted (str-cat ?node "/temp_plan"))
  (assert (pddl-plan-goal ?wanted nil))
  (modify ?plan (state WAITING) (goal-ptr ?wanted)))

(defrule pddl-plan-accepted
  (pddl-manager (node ?node))
  ?response <- (cx-pddl-interfaces-plan-temporal-goal-response (server ?server) (client-goal-handle-ptr ?handle))
  (test (eq ?server (str-cat ?node "/temp_plan")))
  ?sent <- (pddl-plan-goal ?goal nil)
  =>
  (retract ?response ?sent)
  (if (pddl-is-set ?handle) then
    (do-for-fact ((?plan pddl-plan)) (eq ?plan:goal-ptr ?goal) (pddl-plan-becomes ?plan (if (eq ?plan:state WAITING) then PLANNING else ?plan:state) ?goal ?handle))
    (assert (pddl-plan-goal ?goal ?handle))
   else
    (printout red "plan was refused!" crlf)
    (do-for-fact ((?plan pddl-plan)) (eq ?plan:goal-ptr ?goal) (pddl-plan-becomes ?plan FAILURE nil nil))
    (cx-pddl-interfaces-plan-temporal-goal-destroy ?goal)))

(defrule pddl-plan-cancel
  (pddl-manager (node ?node))
  ?plan <- (pddl-plan (goal-handle ?handle&:(pddl-is-set ?handle)) (state REQUEST-CANCELING))
  =>
  (cx-pddl-interfaces-plan-temporal-client-cancel-goal (str-cat ?node "/temp_plan") ?handle)
  (modify ?plan (state CANCELING)))

(defrule pddl-plan-cancel-unsent
  "A plan is to be cancelled whose request has not reached the manager: it is cancelled at once."
  ?plan <- (pddl-plan (goal-handle ?handle&:(not (pddl-is-set ?handle))) (goal-ptr ?goal&:(not (pddl-is-set ?goal))) (state REQUEST-CANCELING))
  =>
  (modify ?plan (state CANCELED)))

(defrule pddl-plan-cancel-answered
  ?response <- (cx-pddl-interfaces-plan-temporal-cancel-goal-response)
  =>
  (do-for-all-facts ((?e cx-pddl-interfaces-plan-temporal-cancel-goal-entry)) TRUE (retract ?e))
  (retract ?response))

(deffunction pddl-take-steps (?result ?plan ?instance)
  "Assert the steps of the plan as facts; they count from 0."
  (bind ?number 0)
  (foreach ?action (cx-pddl-interfaces-plan-temporal-result-get-field ?result "actions")
    (assert (pddl-action (instance ?instance) (plan ?plan) (id ?number)
                         (name (sym-cat (ros-msgs-get-field ?action "name"))) (params (ros-msgs-get-field ?action "args"))
                         (planned-start-time (ros-msgs-get-field ?action "start_time"))
                         (planned-duration (ros-msgs-get-field ?action "duration"))))
    (bind ?number (+ ?number 1))))

(deffunction pddl-end-of-plan (?state ?code ?result)
  "The state of a plan whose goal ended like this. A goal that somebody else canceled counts as failed."
  (if (and (eq ?code CANCELED) (member$ ?state (create$ REQUEST-CANCELING CANCELING))) then (return CANCELED))
  (if (and (eq ?code SUCCEEDED) (cx-pddl-interfaces-plan-temporal-result-get-field ?result "success")) then SUCCESS else FAILURE))

(defrule pddl-plan-ended
  ?end <- (cx-pddl-interfaces-plan-temporal-wrapped-result (goal-id ?uuid) (code ?code) (result-ptr ?result))
  ?sent <- (pddl-plan-goal ?goal ?handle&~nil)
  (test (eq ?uuid (cx-pddl-interfaces-plan-temporal-client-goal-handle-get-goal-id ?handle)))
  =>
  (do-for-fact ((?plan pddl-plan)) (eq ?plan:goal-ptr ?goal)
    (bind ?state (pddl-end-of-plan ?plan:state ?code ?result))
    (switch ?state
      (case SUCCESS then (pddl-take-steps ?result ?plan:id ?plan:instance))
      (case FAILURE then (printout red "plan not found!" crlf)))
    (pddl-plan-becomes ?plan ?state nil nil))
  (retract ?sent)
  (cx-pddl-interfaces-plan-temporal-goal-destroy ?goal)
  (cx-pddl-interfaces-plan-temporal-client-goal-handle-destroy ?handle)
  (cx-pddl-interfaces-plan-temporal-result-destroy ?result)
  (retract ?end))

(defrule pddl-plan-disconnect
  "The executive ends: close the client and destroy the goals."
  (executive-finalize)
  (pddl-manager (node ?node))
  ?client <- (cx-pddl-interfaces-plan-temporal-client (server ?server&:(eq ?server (str-cat ?node "/temp_plan"))))
  =>
  (do-for-all-facts ((?g pddl-plan-goal)) TRUE (cx-pddl-interfaces-plan-temporal-goal-destroy (nth$ 1 ?g:implied)))
  (cx-pddl-interfaces-plan-temporal-destroy-client ?server))
