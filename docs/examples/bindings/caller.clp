(deffacts start (open))

(defrule open
  "At the start: clients of the robot, and an ear for what it says."
  (open)
  =>
  (std-msgs-string-create-subscription "status")
  (std-srvs-set-bool-create-client "power")
  (example-interfaces-fibonacci-create-client "count"))

(defrule ask-for-power
  "The client is there: ask for power, once."
  (std-srvs-set-bool-client (service ?service))
  =>
  (bind ?request (std-srvs-set-bool-request-create))
  (std-srvs-set-bool-request-set-field ?request "data" TRUE)
  (std-srvs-set-bool-send-request ?request ?service)
  (std-srvs-set-bool-request-destroy ?request))

(defrule power-answered
  "The service has answered."
  ?response <- (std-srvs-set-bool-response (service ?service) (msg-ptr ?message))
  =>
  (println ?service " answered " (std-srvs-set-bool-response-get-field ?message "success"))
  (std-srvs-set-bool-response-destroy ?message)
  (retract ?response))

(defrule robot-speaks
  "Power is on: let it count."
  ?heard <- (std-msgs-string-message (topic "status") (msg-ptr ?message))
  =>
  (println "the robot says: " (std-msgs-string-get-field ?message "data"))
  (std-msgs-string-destroy-message ?message)
  (retract ?heard)
  (bind ?goal (example-interfaces-fibonacci-goal-create))
  (example-interfaces-fibonacci-goal-set-field ?goal "order" 6)
  (example-interfaces-fibonacci-send-goal ?goal "count")
  (example-interfaces-fibonacci-goal-destroy ?goal))

(defrule feedback
  "The robot reports how far it is."
  ?fact <- (example-interfaces-fibonacci-goal-feedback (feedback-ptr ?feedback))
  =>
  (println "so far " (example-interfaces-fibonacci-feedback-get-field ?feedback "sequence"))
  (example-interfaces-fibonacci-feedback-destroy ?feedback)
  (retract ?fact))

(defrule counted
  "The goal has ended."
  ?response <- (example-interfaces-fibonacci-goal-response (client-goal-handle-ptr ?handle))
  ?end <- (example-interfaces-fibonacci-wrapped-result (code ?code) (result-ptr ?result))
  =>
  (println ?code " " (example-interfaces-fibonacci-result-get-field ?result "sequence"))
  (example-interfaces-fibonacci-result-destroy ?result)
  (example-interfaces-fibonacci-client-goal-handle-destroy ?handle)
  (retract ?response ?end))

(defrule close
  "The executive ends: close what is open."
  (executive-finalize)
  =>
  (std-msgs-string-destroy-subscription "status")
  (std-srvs-set-bool-destroy-client "power")
  (example-interfaces-fibonacci-destroy-client "count"))
