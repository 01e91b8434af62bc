; Asks the manager for a second environment and prints the answer.
(deffacts start (want helper))

(defrule call-for-help
  "An environment is wanted: ask for it."
  (want ?name)
  =>
  (ros-msgs-create-client "clips_manager/create_env" "cx_msgs/srv/CreateClipsEnv")
  (bind ?request (ros-msgs-create-request "cx_msgs/srv/CreateClipsEnv"))
  (ros-msgs-set-field ?request "env_name" ?name)
  (ros-msgs-async-send-request ?request "clips_manager/create_env")
  (ros-msgs-destroy-message ?request))

(defrule help-came
  "The manager has answered: say so, and clean up."
  ?response <- (ros-msgs-response (service ?service) (msg-ptr ?message))
  =>
  (println "a helper came: " (ros-msgs-get-field ?message "success"))
  (ros-msgs-destroy-message ?message)
  (ros-msgs-destroy-client ?service)
  (retract ?response))

(defrule say-good-bye
  (executive-finalize)
  =>
  (println "the boss goes"))
