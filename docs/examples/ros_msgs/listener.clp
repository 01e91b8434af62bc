(deffacts start (open))

(deffunction mute-service-callback (?service ?request ?response)
  "Called for each request: fill the response. Both messages go by themselves."
  (if (ros-msgs-get-field ?request "data") then
    (assert (muted)))
  (ros-msgs-set-field ?response "success" TRUE)
  (ros-msgs-set-field ?response "message" "as you wish"))

(defrule open
  "At the start: listen, and serve."
  (open)
  =>
  (ros-msgs-create-subscription "chatter" "std_msgs/msg/String")
  (ros-msgs-create-service "mute" "std_srvs/srv/SetBool"))

(defrule hear
  "A message has come: print and drop it."
  ?fact <- (ros-msgs-message (topic "chatter") (msg-ptr ?message))
  =>
  (printout cyan "heard: " (ros-msgs-get-field ?message "data") crlf)
  (ros-msgs-destroy-message ?message)
  (retract ?fact))

(defrule stop-hearing
  "Somebody asked for silence."
  (muted)
  (ros-msgs-subscription (topic "chatter"))
  =>
  (ros-msgs-destroy-subscription "chatter"))

(defrule close
  "The executive ends: close what is open."
  (executive-finalize)
  =>
  (ros-msgs-destroy-service "mute"))
