; Three blocks, and one robot that moves a block at a time. It learns to build the tower a on b on c: each move costs 1, the
; tower gives 20. The trainer asks through the services and actions of cx_rl_interfaces (docs/rl.md).

(defglobal
  ?*NODE* = "/cx_rl_node"
  ?*SNAPSHOT* = "beginning.bin")

(deftemplate on
  (slot block (type SYMBOL))
  (slot place (type SYMBOL)))

(deftemplate action
  "What the robot can do now."
  (slot id (type SYMBOL))
  (slot block (type SYMBOL))
  (slot place (type SYMBOL)))

(deftemplate reset
  "Where a reset of the world is."
  (slot goal (type EXTERNAL-ADDRESS))
  (slot state (type SYMBOL) (allowed-values LOAD-FACTS DONE)))

(deffacts beginning
  (on (block c) (place a))
  (on (block a) (place table))
  (on (block b) (place table)))

(deffunction service (?name) (str-cat ?*NODE* "/" ?name))

(deffunction is-clear (?place)
  (or (eq ?place table) (not (any-factp ((?o on)) (eq ?o:place ?place)))))

(deffunction tower ()
  (and (any-factp ((?o on)) (and (eq ?o:block a) (eq ?o:place b)))
       (any-factp ((?o on)) (and (eq ?o:block b) (eq ?o:place c)))))

; --- What there is at all: the trainer asks once, before it trains

(deffunction cx-rl-interfaces-get-predefined-observables-service-callback (?service ?request ?response))

(deffunction cx-rl-interfaces-get-predefined-actions-service-callback (?service ?request ?response))

(deffunction cx-rl-interfaces-get-observable-predicates-service-callback (?service ?request ?response)
  (cx-rl-interfaces-get-observable-predicates-response-set-field ?response "predicate_names" (create$ on))
  (cx-rl-interfaces-get-observable-predicates-response-set-field ?response "param_counts" (create$ 2))
  (cx-rl-interfaces-get-observable-predicates-response-set-field ?response "param_names" (create$ block place))
  (cx-rl-interfaces-get-observable-predicates-response-set-field ?response "param_types" (create$ block place)))

(deffunction cx-rl-interfaces-get-observable-actions-service-callback (?service ?request ?response)
  (cx-rl-interfaces-get-observable-actions-response-set-field ?response "action_names" (create$ move))
  (cx-rl-interfaces-get-observable-actions-response-set-field ?response "param_counts" (create$ 2))
  (cx-rl-interfaces-get-observable-actions-response-set-field ?response "param_names" (create$ block place))
  (cx-rl-interfaces-get-observable-actions-response-set-field ?response "param_types" (create$ block place)))

(deffunction cx-rl-interfaces-get-observable-objects-service-callback (?service ?request ?response)
  (bind ?type (cx-rl-interfaces-get-observable-objects-request-get-field ?request "type"))
  (cx-rl-interfaces-get-observable-objects-response-set-field ?response "objects"
    (if (eq ?type "place") then (create$ a b c table) else (create$ a b c))))

; --- What the trainer asks

(deffunction cx-rl-interfaces-get-observations-service-callback (?service ?request ?response)
  (bind ?all (create$))
  (do-for-all-facts ((?o on)) TRUE
    (bind ?one (cx-rl-interfaces-observation-create-message))
    (cx-rl-interfaces-observation-set-field ?one "name" "on")
    (cx-rl-interfaces-observation-set-field ?one "params" (create$ ?o:block ?o:place))
    (bind ?all ?all ?one))
  (cx-rl-interfaces-get-observations-response-set-field ?response "observations" ?all)
  (progn$ (?one ?all) (cx-rl-interfaces-observation-destroy-message ?one)))

(deffunction cx-rl-interfaces-get-action-list-robot-service-callback (?service ?request ?response)
  (do-for-all-facts ((?a action)) TRUE (retract ?a))
  (bind ?all (create$))
  (bind ?ids (create$))
  (foreach ?block (create$ a b c)
    (foreach ?place (create$ a b c table)
      (if (and (neq ?block ?place) (is-clear ?block) (is-clear ?place)
               (not (any-factp ((?o on)) (and (eq ?o:block ?block) (eq ?o:place ?place)))))
       then
        (bind ?id (sym-cat move- ?block - ?place))
        (assert (action (id ?id) (block ?block) (place ?place)))
        (bind ?one (cx-rl-interfaces-action-create-message))
        (cx-rl-interfaces-action-set-field ?one "name" "move")
        (cx-rl-interfaces-action-set-field ?one "params" (create$ ?block ?place))
        (bind ?all ?all ?one)
        (bind ?ids ?ids ?id))))
  (cx-rl-interfaces-get-action-list-robot-response-set-field ?response "actions" ?all)
  (cx-rl-interfaces-get-action-list-robot-response-set-field ?response "action_ids" ?ids)
  (progn$ (?one ?all) (cx-rl-interfaces-action-destroy-message ?one)))

(deffunction cx-rl-interfaces-get-episode-end-service-callback (?service ?request ?response)
  (cx-rl-interfaces-get-episode-end-response-set-field ?response "episode_end" (tower))
  (cx-rl-interfaces-get-episode-end-response-set-field ?response "reward" (if (tower) then 20 else 0)))

(deffunction cx-rl-interfaces-end-training-service-callback (?service ?request ?response)
  (assert (training-has-ended)))

(defrule serve
  "At the start; the facts of the beginning are kept for each reset."
  (on)
  (not (serving))
  =>
  (assert (serving))
  (bsave-facts ?*SNAPSHOT* visible on serving)
  (cx-rl-interfaces-get-observations-create-service (service get_current_observations))
  (cx-rl-interfaces-get-action-list-robot-create-service (service get_action_list_executable_for_robot))
  (cx-rl-interfaces-get-episode-end-create-service (service get_episode_end))
  (cx-rl-interfaces-end-training-create-service (service end_training))
  (cx-rl-interfaces-get-predefined-observables-create-service (service get_predefined_observables))
  (cx-rl-interfaces-get-observable-predicates-create-service (service get_observable_predicates))
  (cx-rl-interfaces-get-predefined-actions-create-service (service get_predefined_actions))
  (cx-rl-interfaces-get-observable-actions-create-service (service get_observable_actions))
  (cx-rl-interfaces-get-observable-objects-create-service (service get_observable_objects))
  (cx-rl-interfaces-reset-env-create-server (service reset_env))
  (cx-rl-interfaces-get-free-robot-create-server (service get_free_robot))
  (cx-rl-interfaces-action-selection-create-server (service action_selection)))

; --- What it has done for it

(defrule reset-begins
  (cx-rl-interfaces-reset-env-accepted-goal (server-goal-handle-ptr ?goal))
  =>
  (assert (reset (goal ?goal) (state LOAD-FACTS))))

(defrule reset-loads-facts
  "All facts go, and those of the beginning come back."
  (reset (goal ?goal) (state LOAD-FACTS))
  =>
  (reset)
  (do-for-all-facts ((?o on)) TRUE (retract ?o))
  (bload-facts ?*SNAPSHOT*)
  (assert (reset (goal ?goal) (state DONE))))

(defrule reset-is-done
  ?reset <- (reset (goal ?goal) (state DONE))
  =>
  (retract ?reset)
  (bind ?result (cx-rl-interfaces-reset-env-result-create))
  (cx-rl-interfaces-reset-env-result-set-field ?result "confirmation" "Reset completed")
  (cx-rl-interfaces-reset-env-server-goal-handle-succeed ?goal ?result)
  (cx-rl-interfaces-reset-env-result-destroy ?result)
  (cx-rl-interfaces-reset-env-server-goal-handle-destroy ?goal))

(defrule the-robot-is-free
  ?asked <- (cx-rl-interfaces-get-free-robot-accepted-goal (server-goal-handle-ptr ?goal))
  =>
  (retract ?asked)
  (bind ?result (cx-rl-interfaces-get-free-robot-result-create))
  (cx-rl-interfaces-get-free-robot-result-set-field ?result "success" TRUE)
  (cx-rl-interfaces-get-free-robot-result-set-field ?result "robot" "robot1")
  (cx-rl-interfaces-get-free-robot-server-goal-handle-succeed ?goal ?result)
  (cx-rl-interfaces-get-free-robot-result-destroy ?result)
  (cx-rl-interfaces-get-free-robot-server-goal-handle-destroy ?goal))

(deffunction finish (?goal ?id)
  (bind ?result (cx-rl-interfaces-action-selection-result-create))
  (cx-rl-interfaces-action-selection-result-set-field ?result "action_id" ?id)
  (cx-rl-interfaces-action-selection-result-set-field ?result "reward" -1)
  (cx-rl-interfaces-action-selection-result-set-field ?result "info" (if (tower) then "Done" else ""))
  (cx-rl-interfaces-action-selection-server-goal-handle-succeed ?goal ?result)
  (cx-rl-interfaces-action-selection-result-destroy ?result)
  (cx-rl-interfaces-action-selection-server-goal-handle-destroy ?goal))

(defrule an-action-is-selected
  ?asked <- (cx-rl-interfaces-action-selection-accepted-goal (server-goal-handle-ptr ?goal))
  =>
  (retract ?asked)
  (assert (selected ?goal (sym-cat (cx-rl-interfaces-action-selection-goal-get-field
                                     (cx-rl-interfaces-action-selection-server-goal-handle-get-goal ?goal) "action_id")))))

(defrule move
  "The block moves."
  ?selected <- (selected ?goal ?id)
  (action (id ?id) (block ?block) (place ?place))
  ?on <- (on (block ?block))
  =>
  (retract ?selected)
  (modify ?on (place ?place))
  (finish ?goal ?id))

(defrule stop
  (training-has-ended)
  =>
  (cx-shutdown))

(defrule close
  (executive-finalize)
  =>
  (cx-rl-interfaces-get-observations-destroy-service (service get_current_observations))
  (cx-rl-interfaces-get-action-list-robot-destroy-service (service get_action_list_executable_for_robot))
  (cx-rl-interfaces-get-episode-end-destroy-service (service get_episode_end))
  (cx-rl-interfaces-end-training-destroy-service (service end_training))
  (cx-rl-interfaces-get-predefined-observables-destroy-service (service get_predefined_observables))
  (cx-rl-interfaces-get-observable-predicates-destroy-service (service get_observable_predicates))
  (cx-rl-interfaces-get-predefined-actions-destroy-service (service get_predefined_actions))
  (cx-rl-interfaces-get-observable-actions-destroy-service (service get_observable_actions))
  (cx-rl-interfaces-get-observable-objects-destroy-service (service get_observable_objects))
  (cx-rl-interfaces-reset-env-destroy-server (service reset_env))
  (cx-rl-interfaces-get-free-robot-destroy-server (service get_free_robot))
  (cx-rl-interfaces-action-selection-destroy-server (service action_selection)))
