(deffacts start (open) (power FALSE))

(deffunction std-srvs-set-bool-service-callback (?service ?request ?response)
  "Called for each request: fill the response. Both messages go by themselves."
  (assert (power-is-to-be (std-srvs-set-bool-request-get-field ?request "data")))
  (std-srvs-set-bool-response-set-field ?response "success" TRUE))

(deffunction example-interfaces-fibonacci-handle-goal-callback (?server ?goal ?uuid)
  "A goal has come: 1 rejects it, 2 begins it, 3 accepts it for later."
  (if (< (example-interfaces-fibonacci-goal-get-field ?goal "order") 20) then 2 else 1))

(defrule open
  "At the start: serve, and have a topic to speak on."
  (open)
  =>
  (std-srvs-set-bool-create-service "power")
  (example-interfaces-fibonacci-create-server "count")
  (std-msgs-string-create-publisher "status"))

(defrule switch
  "The caller has asked for power: publish that it is on."
  ?asked <- (power-is-to-be ?new)
  ?power <- (power ~?new)
  =>
  (retract ?asked ?power)
  (assert (power ?new))
  (bind ?message (std-msgs-string-create-message))
  (std-msgs-string-set-field ?message "data" (str-cat "power " ?new))
  (std-msgs-string-publish ?message "status")
  (std-msgs-string-destroy-message ?message))

(defrule count
  "A goal was accepted: count, send feedback, and end it."
  ?accepted <- (example-interfaces-fibonacci-accepted-goal (server-goal-handle-ptr ?handle))
  =>
  (retract ?accepted)
  (bind ?order (example-interfaces-fibonacci-goal-get-field (example-interfaces-fibonacci-server-goal-handle-get-goal ?handle) "order"))
  (bind ?sequence (create$ 0 1))
  (bind ?feedback (example-interfaces-fibonacci-feedback-create))
  (example-interfaces-fibonacci-feedback-set-field ?feedback "sequence" ?sequence)
  (example-interfaces-fibonacci-server-goal-handle-publish-feedback ?handle ?feedback)
  (example-interfaces-fibonacci-feedback-destroy ?feedback)
  (loop-for-count (?i 2 ?order)
    (bind ?sequence ?sequence (+ (nth$ ?i ?sequence) (nth$ (- ?i 1) ?sequence))))
  (bind ?result (example-interfaces-fibonacci-result-create))
  (example-interfaces-fibonacci-result-set-field ?result "sequence" ?sequence)
  (example-interfaces-fibonacci-server-goal-handle-succeed ?handle ?result)
  (example-interfaces-fibonacci-result-destroy ?result)
  (example-interfaces-fibonacci-server-goal-handle-destroy ?handle))

(defrule close
  "The executive ends: close what is open."
  (executive-finalize)
  =>
  (std-srvs-set-bool-destroy-service "power")
  (example-interfaces-fibonacci-destroy-server "count")
  (std-msgs-string-destroy-publisher "status"))
