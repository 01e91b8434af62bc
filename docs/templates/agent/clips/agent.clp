; Somebody rings: the agent opens the door and says so.

(deftemplate door
  (slot state (type SYMBOL) (allowed-values CLOSED OPEN) (default CLOSED)))

(deffacts start
  (door)
  (listen))

(defrule open-topics
  "At the start: listen to the bell, prepare to speak."
  ?start <- (listen)
  =>
  (retract ?start)
  (ros-msgs-create-subscription "/bell" "std_msgs/msg/String")
  (ros-msgs-create-publisher "/door" "std_msgs/msg/String"))

(defrule hear-bell
  "The bell rings: note who is there."
  ?fact <- (ros-msgs-message (topic "/bell") (msg-ptr ?message))
  =>
  (assert (visitor (ros-msgs-get-field ?message "data")))
  (ros-msgs-destroy-message ?message)
  (retract ?fact))

(defrule open-door
  "A visitor before a closed door: open it."
  (visitor ?name)
  ?door <- (door (state CLOSED))
  =>
  (modify ?door (state OPEN))
  (bind ?message (ros-msgs-create-message "std_msgs/msg/String"))
  (ros-msgs-set-field ?message "data" (str-cat "open for " ?name))
  (ros-msgs-publish ?message "/door")
  (ros-msgs-destroy-message ?message)
  (printout t "the door is open for " ?name crlf))

(defrule close-topics
  "The end: give back what was opened."
  (executive-finalize)
  =>
  (ros-msgs-destroy-subscription "/bell")
  (ros-msgs-destroy-publisher "/door"))
