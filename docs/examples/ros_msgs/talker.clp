(deffacts start (open))

(defrule open
  "At the start: a publisher, and a client of the listener's service."
  (open)
  =>
  (ros-msgs-create-publisher "chatter" "std_msgs/msg/String")
  (ros-msgs-create-client "mute" "std_srvs/srv/SetBool")
  (assert (begun (now))))

(defrule talk
  "Every tenth of a second, for a second: say the time."
  (begun ?begun)
  (time ?t&:(< (- ?t ?begun) 1.0))
  (ros-msgs-publisher (topic "chatter"))
  =>
  (bind ?message (ros-msgs-create-message "std_msgs/msg/String"))
  (ros-msgs-set-field ?message "data" (str-cat "it is " ?t))
  (ros-msgs-publish ?message "chatter")
  (ros-msgs-destroy-message ?message))

(defrule ask-for-silence
  "A second is over: ask the listener to stop hearing."
  (begun ?begun)
  (time ?t&:(>= (- ?t ?begun) 1.0))
  (not (asked))
  =>
  (assert (asked))
  (bind ?request (ros-msgs-create-request "std_srvs/srv/SetBool"))
  (ros-msgs-set-field ?request "data" TRUE)
  (ros-msgs-async-send-request ?request "mute")
  (ros-msgs-destroy-message ?request))

(defrule hear-answer
  "The listener has answered."
  ?response <- (ros-msgs-response (service "mute") (msg-ptr ?message))
  =>
  (printout t "the listener says: " (ros-msgs-get-field ?message "message") crlf)
  (ros-msgs-destroy-message ?message)
  (retract ?response))

(defrule close
  "The executive ends: close what is open."
  (executive-finalize)
  =>
  (ros-msgs-destroy-publisher "chatter")
  (ros-msgs-destroy-client "mute"))
