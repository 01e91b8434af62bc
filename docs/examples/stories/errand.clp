; Asks a service whether it may, then sends a robot; a refusal of either is a fact.
(deftemplate errand (slot state (allowed-values WANTED ASKED ALLOWED FORBIDDEN SENT REFUSED)))

(deffacts errand (errand (state WANTED)))

(deftemplate way (slot m))  ; what is left of it

(defrule open-clients
  "At the start: the service and the action are known by name."
  (errand (state WANTED))
  =>
  (ros-msgs-create-client "/may_i" "std_srvs/srv/SetBool")
  (ros-msgs-create-action-client "/robot1/pick" "cxlab_skills/action/Pick"))

(defrule ask
  "The errand is wanted: ask first."
  (time ?)
  ?errand <- (errand (state WANTED))
  =>
  (bind ?request (ros-msgs-create-request "std_srvs/srv/SetBool"))
  (ros-msgs-async-send-request ?request "/may_i")
  (ros-msgs-destroy-message ?request)
  (modify ?errand (state ASKED)))

(defrule hear-answer
  "The service has answered: allowed or forbidden."
  ?response <- (ros-msgs-response (service "/may_i") (msg-ptr ?message))
  ?errand <- (errand (state ASKED))
  =>
  (modify ?errand (state (if (ros-msgs-get-field ?message "success") then ALLOWED else FORBIDDEN)))
  (ros-msgs-destroy-message ?message)
  (retract ?response))

(defrule send-robot
  "Allowed: the robot picks."
  ?errand <- (errand (state ALLOWED))
  =>
  (bind ?goal (ros-msgs-create-goal-request "cxlab_skills/action/Pick"))
  (ros-msgs-async-send-goal ?goal "/robot1/pick")
  (ros-msgs-destroy-message ?goal)
  (modify ?errand (state SENT)))

(deffunction is-null (?handle)
  "Whether the handle points nowhere, as that of a goal that was rejected."
  (eq (implode$ (create$ ?handle)) "<Pointer-C-(nil)>"))

(defrule robot-refuses
  "The goal was rejected."
  ?response <- (ros-msgs-goal-response (server "/robot1/pick") (client-goal-handle-ptr ?handle&:(is-null ?handle)))
  ?errand <- (errand (state SENT))
  =>
  (retract ?response)
  (modify ?errand (state REFUSED)))

(defrule robot-drives
  "The robot says how far it still has to go: keep the latest."
  ?feedback <- (ros-msgs-feedback (server "/robot1/pick") (feedback-ptr ?message))
  =>
  (do-for-all-facts ((?way way)) TRUE (retract ?way))
  (assert (way (m (ros-msgs-get-field ?message "remaining_m"))))
  (ros-msgs-destroy-message ?message)
  (retract ?feedback))

(defrule close-clients
  "At the end: what was opened is closed."
  (executive-finalize)
  =>
  (ros-msgs-destroy-client "/may_i")
  (ros-msgs-destroy-action-client "/robot1/pick"))
