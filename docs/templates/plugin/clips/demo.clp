; Counts to six with the plugin's function, and hears of it over the bus.

(deffacts work (todo 1 1 1))

(defrule subscribe
  "Counts are heard before the first is made."
  (not (ros-msgs-subscription (topic "count")))
  (not (executive-finalize))
  =>
  (ros-msgs-create-subscription "count" "my_plugin/msg/Count"))

(defrule count-one
  "Something is left to count."
  (ros-msgs-subscription (topic "count"))
  ?todo <- (todo ?n $?rest)
  =>
  (retract ?todo)
  (assert (todo ?rest))
  (assert (counter (value (counter-add ?n)))))

(defrule hear
  "A message has come: report the last count, and destroy the message."
  ?fact <- (ros-msgs-message (topic "count") (msg-ptr ?message))
  =>
  (bind ?value (ros-msgs-get-field ?message "value"))
  (if (= ?value 6) then (printout info "three counts make " ?value crlf))
  (ros-msgs-destroy-message ?message)
  (retract ?fact))

(defrule finish
  "The environment ends."
  (executive-finalize)
  =>
  (ros-msgs-destroy-subscription "count"))
