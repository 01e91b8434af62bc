; Serves choices over cx_rl_interfaces, below the name cx_rl_node: a trainer that is made for the CLIPS-Executive makes them. In mode EXECUTION its
; node is asked instead, with a model that was trained before. The file is loaded after choices.clp. The agent asserts one fact `training` and keeps
; it up to date. docs/reference/learning.md tells what the trainer sees.

(defglobal
  ?*LEVELS* = 4               ; a feature of 1.0 is observed as level 4, one of -0.5 as level -2
  ?*SHOWN-OPTIONS* = 16       ; most options of a choice that are offered
  ?*TIME-TO-SELECT* = 1.0     ; s that the trainer has for an offered choice; then it has chosen no-op
  ?*TIME-TO-ASK* = 0.3        ; s that the trainer has to ask for another robot while one is at work
  ?*TIME-OF-SILENCE* = 5.0    ; s between two lines of feedback, and between two questions for the mode of the node
  ?*episodes* = 0             ; that have begun
  ?*points-told* = 0          ; points of the episode that were given as rewards
  ?*last-reward* = 0.0)       ; when an action ended last

(deftemplate training
  "What the agent tells the trainer."
  (slot points (type INTEGER))                                        ; of this episode so far
  (slot over (type SYMBOL) (allowed-values FALSE TRUE))               ; the episode has ended
  (multislot kinds (type SYMBOL))                                     ; of choices
  (slot situation (type INTEGER))                                     ; how many features a situation has
  (slot features (type INTEGER)))                                     ; how many features an option has at most

(deftemplate robot-wanted
  "The trainer waits for a robot that has a choice."
  (slot goal (type EXTERNAL-ADDRESS))
  (slot heard (type FLOAT)))

(deftemplate offered
  "The trainer was given this choice."
  (slot choice (type INTEGER))
  (slot at (type FLOAT)))

(deftemplate at-work
  "The trainer selected an option of this choice and waits for what it brings."
  (slot goal (type EXTERNAL-ADDRESS))
  (slot choice (type INTEGER))
  (slot who (type STRING))
  (slot action-id (type STRING))
  (slot since (type FLOAT)))

(deftemplate episode-wanted
  "The trainer waits for a new episode. WORLD: the agent is to restart the world, and retracts `reset-wanted` when it has. CHOICE: the first choice
   is to come."
  (slot goal (type EXTERNAL-ADDRESS))
  (slot state (type SYMBOL) (allowed-values WORLD CHOICE))
  (slot heard (type FLOAT)))

(deftemplate mode-of-node
  "What the node is for: TRAINING or EXECUTION; UNKNOWN while it has not answered."
  (slot mode (type SYMBOL))
  (slot asked (type FLOAT)))

(deftemplate model-asked
  "The node was asked for this choice."
  (slot choice (type INTEGER))
  (slot request (type INTEGER)))

(deffunction is-open (?choice)
  (bind ?id (fact-slot-value ?choice id))
  (not (any-factp ((?m choice-made)) (= ?m:choice ?id))))

(deffunction oldest-open-choice (?who)
  "The oldest choice of somebody that has no answer yet, of anybody if who is FALSE; FALSE if there is none."
  (bind ?oldest FALSE)
  (do-for-all-facts ((?c choice)) (and (or (not ?who) (eq ?c:who ?who)) (is-open ?c))
    (if (or (not ?oldest) (< ?c:id (fact-slot-value ?oldest id))) then (bind ?oldest ?c)))
  ?oldest)

(deffunction name-of-robot (?who)
  (if (eq ?who "") then "team" else ?who))

(deffunction reward ()
  "The points that the trainer has not been told of."
  (do-for-fact ((?t training)) TRUE
    (bind ?reward (- ?t:points ?*points-told*))
    (bind ?*points-told* ?t:points)
    (return ?reward))
  0)

; --- The spaces

(deffunction grounded (?type ?name ?params)
  (bind ?one (ros-msgs-create-message ?type))
  (ros-msgs-set-field ?one "name" ?name)
  (ros-msgs-set-field ?one "params" ?params)
  ?one)

(deffunction numbers (?first ?last)
  (bind ?all (create$))
  (loop-for-count (?i ?first ?last) (if (<> ?i 0) then (bind ?all (create$ ?all (str-cat ?i)))))
  ?all)

(deffunction cx_rl_node/get_predefined_observables-service-callback (?service ?request ?response))

(deffunction cx_rl_node/get_predefined_actions-service-callback (?service ?request ?response))

(deffunction cx_rl_node/get_observable_predicates-service-callback (?service ?request ?response)
  (ros-msgs-set-field ?response "predicate_names" (create$ "asked" "situation" "option"))
  (ros-msgs-set-field ?response "param_counts" (create$ 1 2 3))
  (bind ?params (create$ "kind" "situation-feature" "level" "option" "option-feature" "level"))
  (ros-msgs-set-field ?response "param_names" ?params)
  (ros-msgs-set-field ?response "param_types" ?params))

(deffunction cx_rl_node/get_observable_actions-service-callback (?service ?request ?response)
  (ros-msgs-set-field ?response "action_names" (create$ "choose"))
  (ros-msgs-set-field ?response "param_counts" (create$ 1))
  (ros-msgs-set-field ?response "param_names" (create$ "option"))
  (ros-msgs-set-field ?response "param_types" (create$ "option")))

(deffunction cx_rl_node/get_observable_objects-service-callback (?service ?request ?response)
  (do-for-fact ((?t training)) TRUE
    (ros-msgs-set-field ?response "objects"
      (switch (ros-msgs-get-field ?request "type")
        (case "kind" then ?t:kinds)
        (case "situation-feature" then (numbers 1 ?t:situation))
        (case "option" then (numbers 1 ?*SHOWN-OPTIONS*))
        (case "option-feature" then (numbers 1 ?t:features))
        (case "level" then (numbers (- 0 ?*LEVELS*) ?*LEVELS*))
        (default (create$))))))

; --- A choice as observations and actions

(deffunction shown-options (?choice)
  "All options, at most 16: then the first ones, the preferred one and the last one."
  (bind ?count (length$ (fact-slot-value ?choice options)))
  (bind ?shown (create$))
  (loop-for-count (?i 1 (min ?count ?*SHOWN-OPTIONS*)) (bind ?shown (create$ ?shown ?i)))
  (if (<= ?count ?*SHOWN-OPTIONS*) then (return ?shown))
  (bind ?shown (replace$ ?shown ?*SHOWN-OPTIONS* ?*SHOWN-OPTIONS* ?count))
  (bind ?preferred (fact-slot-value ?choice preferred))
  (if (not (member$ ?preferred ?shown))
   then (bind ?shown (replace$ ?shown (- ?*SHOWN-OPTIONS* 1) (- ?*SHOWN-OPTIONS* 1) ?preferred)))
  ?shown)

(deffunction observed (?name ?places ?features)
  "An observation for each feature that is not about 0: its place in the list, and its level."
  (bind ?all (create$))
  (bind ?place 0)
  (foreach ?feature ?features
    (bind ?place (+ ?place 1))
    (bind ?level (round (* ?feature ?*LEVELS*)))
    (if (<> ?level 0)
     then (bind ?all (create$ ?all (grounded "cx_rl_interfaces/msg/Observation" ?name
                                             (create$ ?places (str-cat ?place) (str-cat ?level)))))))
  ?all)

(deffunction observations-of (?choice)
  (bind ?all (create$ (grounded "cx_rl_interfaces/msg/Observation" "asked" (create$ (fact-slot-value ?choice kind)))
                      (observed "situation" (create$) (fact-slot-value ?choice situation))))
  (bind ?features (fact-slot-value ?choice features))
  (bind ?width (div (length$ ?features) (length$ (fact-slot-value ?choice options))))
  (bind ?place 0)
  (foreach ?option (shown-options ?choice)
    (bind ?place (+ ?place 1))
    (bind ?all (create$ ?all (observed "option" (create$ (str-cat ?place))
                                       (subseq$ ?features (+ 1 (* ?width (- ?option 1))) (* ?width ?option))))))
  ?all)

(deffunction put-observations (?message ?choice)
  (bind ?all (observations-of ?choice))
  (ros-msgs-set-field ?message "observations" ?all)
  (foreach ?one ?all (ros-msgs-destroy-message ?one)))

(deffunction put-actions (?message ?choice)
  "The allowed options; the id of an action is that of the choice and the number of the option: 17-3. Trainers end an episode if a
   robot has no action: if the choice was withdrawn meanwhile, there is one that changes nothing."
  (bind ?actions (create$))
  (bind ?ids (create$))
  (bind ?place 0)
  (if (not ?choice)
   then (bind ?actions (create$ (grounded "cx_rl_interfaces/msg/Action" "choose" (create$ "1"))))
        (bind ?ids (create$ "0-0")))
  (foreach ?option (if ?choice then (shown-options ?choice) else (create$))
    (bind ?place (+ ?place 1))
    (if (nth$ ?option (fact-slot-value ?choice allowed))
     then (bind ?actions (create$ ?actions (grounded "cx_rl_interfaces/msg/Action" "choose" (create$ (str-cat ?place)))))
          (bind ?ids (create$ ?ids (str-cat (fact-slot-value ?choice id) "-" ?option)))))
  (ros-msgs-set-field ?message "actions" ?actions)
  (ros-msgs-set-field ?message "action_ids" ?ids)
  (foreach ?one ?actions (ros-msgs-destroy-message ?one)))

(deffunction part-of-id (?action-id ?begin ?end)
  (if (< ?end ?begin) then (return 0))
  (bind ?number (string-to-field (sub-string ?begin ?end ?action-id)))
  (if (integerp ?number) then ?number else 0))

(deffunction option-of-id (?action-id)
  "The choice of an action and its option, from 1, if it can be chosen still; else FALSE."
  (bind ?dash (str-index "-" ?action-id))
  (if (not ?dash) then (return FALSE))
  (bind ?id (part-of-id ?action-id 1 (- ?dash 1)))
  (bind ?option (part-of-id ?action-id (+ ?dash 1) (str-length ?action-id)))
  (do-for-fact ((?c choice)) (and (= ?c:id ?id) (is-open ?c) (<= 1 ?option (length$ ?c:allowed)) (nth$ ?option ?c:allowed))
    (return (create$ ?id ?option)))
  FALSE)

(deffunction cx_rl_node/get_current_observations-service-callback (?service ?request ?response)
  "The observations of the choice that is offered next; none if no choice is open."
  (bind ?choice (oldest-open-choice FALSE))
  (if (not ?choice) then (return))
  (put-observations ?response ?choice))

(deffunction cx_rl_node/get_action_list_executable_for_robot-service-callback (?service ?request ?response)
  (bind ?robot (ros-msgs-get-field ?request "robot"))
  (put-actions ?response (oldest-open-choice (if (eq ?robot "team") then "" else ?robot))))

; --- Which robot has a choice

(defrule trainer-wants-robot
  ?asked <- (cx-rl-interfaces-get-free-robot-accepted-goal (server-goal-handle-ptr ?goal))
  (time ?now)
  =>
  (retract ?asked)
  (assert (robot-wanted (goal ?goal) (heard ?now))))

(deffunction answer-with-robot (?goal ?success ?robot)
  (bind ?result (cx-rl-interfaces-get-free-robot-result-create))
  (cx-rl-interfaces-get-free-robot-result-set-field ?result "success" ?success)
  (cx-rl-interfaces-get-free-robot-result-set-field ?result "robot" ?robot)
  (if (cx-rl-interfaces-get-free-robot-server-goal-handle-is-canceling ?goal)
   then (cx-rl-interfaces-get-free-robot-server-goal-handle-canceled ?goal ?result)
   else (cx-rl-interfaces-get-free-robot-server-goal-handle-succeed ?goal ?result))
  (cx-rl-interfaces-get-free-robot-result-destroy ?result)
  (cx-rl-interfaces-get-free-robot-server-goal-handle-destroy ?goal))

(defrule trainer-gets-robot
  "The oldest open choice is offered, once what the trainer selected before is known."
  ?wanted <- (robot-wanted (goal ?goal))
  (not (cx-rl-interfaces-action-selection-accepted-goal))
  (training (over FALSE))
  (choice (id ?id) (who ?who))
  (not (choice-made (choice ?id)))
  (time ?now)
  (test (= ?id (fact-slot-value (oldest-open-choice FALSE) id)))
  =>
  (retract ?wanted)
  (do-for-all-facts ((?o offered)) TRUE (retract ?o))
  (assert (offered (choice ?id) (at ?now)))
  (answer-with-robot ?goal TRUE (name-of-robot ?who)))

(defrule trainer-gets-no-robot
  "The episode has ended."
  ?wanted <- (robot-wanted (goal ?goal))
  (training (over TRUE))
  =>
  (retract ?wanted)
  (answer-with-robot ?goal FALSE ""))

(defrule trainer-wants-no-robot
  "The trainer does not want a robot any more."
  ?wanted <- (robot-wanted (goal ?goal))
  (time ?)
  (test (cx-rl-interfaces-get-free-robot-server-goal-handle-is-canceling ?goal))
  =>
  (retract ?wanted)
  (answer-with-robot ?goal FALSE ""))

(defrule trainer-waits-for-robot
  "No robot has a choice for long: feedback tells the trainer that it is still looked for."
  ?wanted <- (robot-wanted (goal ?goal) (heard ?heard))
  (time ?now&:(>= ?now (+ ?heard ?*TIME-OF-SILENCE*)))
  =>
  (modify ?wanted (heard ?now))
  (bind ?feedback (cx-rl-interfaces-get-free-robot-feedback-create))
  (cx-rl-interfaces-get-free-robot-feedback-set-field ?feedback "feedback" "no robot has a choice yet")
  (cx-rl-interfaces-get-free-robot-server-goal-handle-publish-feedback ?goal ?feedback)
  (cx-rl-interfaces-get-free-robot-feedback-destroy ?feedback))

(defrule trainer-chose-no-op
  "The trainer has selected nothing for the choice that it was offered: that is the last option, which leaves all as it is."
  ?offered <- (offered (choice ?id) (at ?at))
  (choice (id ?id) (options $?options))
  (time ?now&:(>= ?now (+ ?at ?*TIME-TO-SELECT*)))
  =>
  (retract ?offered)
  (take-answer ?id (length$ ?options)))

(defrule trainer-offer-is-over
  ?offered <- (offered (choice ?id))
  (or (choice-made (choice ?id))
      (not (choice (id ?id))))
  =>
  (retract ?offered))

; --- An action

(deffunction end-action (?goal ?action-id ?info)
  (bind ?result (cx-rl-interfaces-action-selection-result-create))
  (cx-rl-interfaces-action-selection-result-set-field ?result "action_id" ?action-id)
  (cx-rl-interfaces-action-selection-result-set-field ?result "reward" (reward))
  (cx-rl-interfaces-action-selection-result-set-field ?result "info" ?info)
  (cx-rl-interfaces-action-selection-server-goal-handle-succeed ?goal ?result)
  (cx-rl-interfaces-action-selection-result-destroy ?result)
  (cx-rl-interfaces-action-selection-server-goal-handle-destroy ?goal)
  (bind ?*last-reward* (now)))

(defrule trainer-selects
  "Make the choice, if it is still open."
  ?asked <- (cx-rl-interfaces-action-selection-accepted-goal (server-goal-handle-ptr ?goal))
  (time ?now)
  =>
  (retract ?asked)
  (bind ?action-id (cx-rl-interfaces-action-selection-goal-get-field
                     (cx-rl-interfaces-action-selection-server-goal-handle-get-goal ?goal) "action_id"))
  (bind ?found (option-of-id ?action-id))
  (do-for-fact ((?c choice)) (and ?found (= ?c:id (nth$ 1 ?found)))
    (take-answer ?c:id (nth$ 2 ?found))
    (assert (at-work (goal ?goal) (choice ?c:id) (who ?c:who) (action-id ?action-id) (since ?now)))
    (return))
  (printout warn "the trainer selected " ?action-id ", which cannot be chosen any more" crlf)
  (end-action ?goal ?action-id "Aborted"))

(defrule trainer-robot-is-back
  "The robot has another choice: what it did is done."
  ?work <- (at-work (goal ?goal) (choice ?id) (who ?who) (action-id ?action-id))
  (choice (id ?next&:(> ?next ?id)) (who ?who))
  =>
  (retract ?work)
  (end-action ?goal ?action-id ""))

(defrule trainer-looks-at-others
  "Another robot has a choice, and the trainer does not ask for it while one is at work: it gets the result of the oldest action now."
  ?work <- (at-work (goal ?goal) (choice ?id) (action-id ?action-id) (since ?since))
  (not (at-work (choice ?older&:(< ?older ?id))))
  (not (robot-wanted))
  (not (offered))
  (choice (id ?other) (since ?asked))
  (not (choice-made (choice ?other)))
  (time ?now&:(>= ?now (+ ?*TIME-TO-ASK* (max ?since ?asked ?*last-reward*))))
  =>
  (retract ?work)
  (end-action ?goal ?action-id ""))

(defrule trainer-episode-is-over
  ?work <- (at-work (goal ?goal) (action-id ?action-id))
  (training (over TRUE))
  =>
  (retract ?work)
  (end-action ?goal ?action-id "Done"))

(deffunction cx_rl_node/get_episode_end-service-callback (?service ?request ?response)
  "At the end of the episode the reward is what no action has told of."
  (bind ?over (any-factp ((?t training)) ?t:over))
  (ros-msgs-set-field ?response "episode_end" ?over)
  (ros-msgs-set-field ?response "reward" (if ?over then (reward) else 0)))

; --- A model that was trained: the node is asked (mode EXECUTION)

(defrule node-is-asked-for-its-mode
  "A choice is open and nobody trains: perhaps the node has a model."
  (trainer-is-served)
  (choice (id ?id))
  (time ?now)
  (not (mode-of-node))
  (not (episode-wanted))
  (test (= ?*episodes* 0))
  =>
  (assert (mode-of-node (mode UNKNOWN) (asked ?now)))
  (if (not (any-factp ((?c ros-msgs-client)) (eq ?c:service "cx_rl_node/get_status")))
   then (ros-msgs-create-client "cx_rl_node/get_status" "cx_rl_interfaces/srv/GetStatus"))
  (bind ?request (ros-msgs-create-request "cx_rl_interfaces/srv/GetStatus"))
  (ros-msgs-async-send-request ?request "cx_rl_node/get_status")
  (ros-msgs-destroy-message ?request))

(defrule node-is-asked-again
  ?unknown <- (mode-of-node (mode UNKNOWN) (asked ?asked))
  (time ?now&:(>= ?now (+ ?asked ?*TIME-OF-SILENCE*)))
  =>
  (retract ?unknown))

(defrule node-tells-its-mode
  ?response <- (ros-msgs-response (service "cx_rl_node/get_status") (msg-ptr ?m))
  =>
  (retract ?response)
  (do-for-all-facts ((?known mode-of-node)) TRUE (retract ?known))
  (bind ?mode (ros-msgs-get-field ?m "mode"))
  (ros-msgs-destroy-message ?m)
  (assert (mode-of-node (mode (sym-cat ?mode))))
  (if (eq ?mode "EXECUTION")
   then (bind ?*ANSWERED* TRUE)
        (ros-msgs-create-client "cx_rl_node/exec_action_selection" "cx_rl_interfaces/srv/ExecActionSelection")))

(defrule model-is-asked
  ?node <- (mode-of-node (mode EXECUTION))
  (ros-msgs-client (service "cx_rl_node/exec_action_selection"))
  ?choice <- (choice (id ?id))
  (not (choice-made (choice ?id)))
  (not (model-asked (choice ?id)))
  (time ?now)
  =>
  (bind ?request (ros-msgs-create-request "cx_rl_interfaces/srv/ExecActionSelection"))
  (put-observations ?request ?choice)
  (put-actions ?request ?choice)
  (bind ?number (ros-msgs-async-send-request ?request "cx_rl_node/exec_action_selection"))
  (ros-msgs-destroy-message ?request)
  (if ?number
   then (assert (model-asked (choice ?id) (request ?number)))
   else (modify ?node (mode UNKNOWN) (asked ?now))))

(defrule model-answers
  "The model has chosen for a choice that is still open. An answer without an action is no-op."
  ?response <- (ros-msgs-response (service "cx_rl_node/exec_action_selection") (request-id ?number) (msg-ptr ?m))
  =>
  (retract ?response)
  (bind ?action-id (ros-msgs-get-field ?m "action_id"))
  (ros-msgs-destroy-message ?m)
  (bind ?found (option-of-id ?action-id))
  (do-for-fact ((?a model-asked) (?c choice)) (and (= ?a:request ?number) (= ?a:choice ?c:id) (is-open ?c))
    (if (not (or ?found (eq ?action-id "")))
     then (printout warn "the model chose " ?action-id ", which is no option of choice " ?c:id "; that counts as no-op" crlf))
    (take-answer ?c:id (if (and ?found (= (nth$ 1 ?found) ?c:id)) then (nth$ 2 ?found) else (length$ ?c:options)))))

(defrule model-is-not-asked-any-more
  "The choice was made or withdrawn."
  ?asked <- (model-asked (choice ?id))
  (or (choice-made (choice ?id))
      (not (choice (id ?id))))
  =>
  (retract ?asked))

; --- A new episode

(defrule trainer-wants-episode
  "The first episode begins as the world is. For another one the agent has to restart its world."
  ?asked <- (cx-rl-interfaces-reset-env-accepted-goal (server-goal-handle-ptr ?goal))
  (time ?now)
  =>
  (retract ?asked)
  (if (> ?*episodes* 0)
   then (assert (reset-wanted) (episode-wanted (goal ?goal) (state WORLD) (heard ?now)))
   else (assert (episode-wanted (goal ?goal) (state CHOICE) (heard ?now)))))

(defrule trainer-world-is-new
  "The agent has restarted its world: forget the episode before."
  ?wanted <- (episode-wanted (state WORLD))
  (not (reset-wanted))
  =>
  (delayed-do-for-all-facts ((?w at-work)) TRUE
    (retract ?w)
    (end-action ?w:goal ?w:action-id "Aborted"))
  (bind ?*points-told* 0)
  (modify ?wanted (state CHOICE)))

(defrule trainer-episode-begins
  "A choice is open, so there is something to observe."
  ?wanted <- (episode-wanted (goal ?goal) (state CHOICE))
  (exists (choice))
  =>
  (bind ?*episodes* (+ ?*episodes* 1))
  (retract ?wanted)
  (bind ?result (cx-rl-interfaces-reset-env-result-create))
  (cx-rl-interfaces-reset-env-result-set-field ?result "confirmation" "Reset completed")
  (cx-rl-interfaces-reset-env-server-goal-handle-succeed ?goal ?result)
  (cx-rl-interfaces-reset-env-result-destroy ?result)
  (cx-rl-interfaces-reset-env-server-goal-handle-destroy ?goal))

(defrule trainer-waits-for-episode
  ?wanted <- (episode-wanted (goal ?goal) (heard ?heard))
  (time ?now&:(>= ?now (+ ?heard ?*TIME-OF-SILENCE*)))
  =>
  (modify ?wanted (heard ?now))
  (bind ?feedback (cx-rl-interfaces-reset-env-feedback-create))
  (cx-rl-interfaces-reset-env-feedback-set-field ?feedback "feedback" "nothing is to be chosen yet")
  (cx-rl-interfaces-reset-env-server-goal-handle-publish-feedback ?goal ?feedback)
  (cx-rl-interfaces-reset-env-feedback-destroy ?feedback))

(deffunction cx_rl_node/end_training-service-callback (?service ?request ?response)
  (assert (training-is-over)))

; --- Beginning and end

(defglobal ?*SERVED* = (create$
  get_current_observations GetObservations get_action_list_executable_for_robot GetActionListRobot get_episode_end GetEpisodeEnd
  get_predefined_observables GetPredefinedObservables get_observable_predicates GetObservablePredicates
  get_predefined_actions GetPredefinedActions get_observable_actions GetObservableActions
  get_observable_objects GetObservableObjects end_training EndTraining))

(defrule trainer-serve
  (training)
  (not (trainer-is-served))
  (not (executive-finalize))
  =>
  (assert (trainer-is-served))
  (bind ?*PATIENCE-FOR-CHOICE* 10.0)
  (loop-for-count (?i 1 (div (length$ ?*SERVED*) 2))
    (ros-msgs-create-service (str-cat "cx_rl_node/" (nth$ (- (* 2 ?i) 1) ?*SERVED*))
                             (str-cat "cx_rl_interfaces/srv/" (nth$ (* 2 ?i) ?*SERVED*))))
  (cx-rl-interfaces-reset-env-create-server "cx_rl_node/reset_env")
  (cx-rl-interfaces-get-free-robot-create-server "cx_rl_node/get_free_robot")
  (cx-rl-interfaces-action-selection-create-server "cx_rl_node/action_selection"))

(defrule trainer-close
  (executive-finalize)
  ?served <- (trainer-is-served)
  =>
  (retract ?served)
  (loop-for-count (?i 1 (div (length$ ?*SERVED*) 2))
    (ros-msgs-destroy-service (str-cat "cx_rl_node/" (nth$ (- (* 2 ?i) 1) ?*SERVED*))))
  (foreach ?client (create$ "cx_rl_node/get_status" "cx_rl_node/exec_action_selection")
    (if (any-factp ((?c ros-msgs-client)) (eq ?c:service ?client)) then (ros-msgs-destroy-client ?client)))
  (cx-rl-interfaces-reset-env-destroy-server "cx_rl_node/reset_env")
  (cx-rl-interfaces-get-free-robot-destroy-server "cx_rl_node/get_free_robot")
  (cx-rl-interfaces-action-selection-destroy-server "cx_rl_node/action_selection"))
