; If strategy.clairvoyant is set, the agent knows the whole game from the beginning (world.foresight of the scenario). So it can plan
; for all orders, and knows how long a machine is down.

(deftemplate will-be-down
  (slot machine (type STRING))
  (slot begin (type FLOAT))    ; s of the game
  (slot end (type FLOAT)))

(defrule foresight-subscribe
  (clairvoyant)
  =>
  (assert (topic (name "/foresight") (type "rcll_interfaces/msg/Foresight"))))

(defrule foresight-of-game
  "The whole game is told, and we know which team we are: note its orders and down times."
  ?message <- (ros-msgs-message (topic "/foresight") (msg-ptr ?m))
  (we-are ?letter)
  =>
  (foreach ?o (ros-msgs-get-field ?m "orders")
    (learn-order ?o ?letter)
    (ros-msgs-destroy-message ?o))
  (foreach ?d (ros-msgs-get-field ?m "down")
    (assert (will-be-down (machine (str-cat ?letter "-" (ros-msgs-get-field ?d "machine")))
                          (begin (ros-msgs-get-field ?d "begin_s")) (end (ros-msgs-get-field ?d "end_s"))))
    (ros-msgs-destroy-message ?d))
  (ros-msgs-destroy-message ?m)
  (retract ?message))

(deffunction known-end (?machine ?time)
  "When a machine that is down at that time of the game works again; FALSE if this is not known."
  (do-for-fact ((?d will-be-down)) (and (eq ?d:machine ?machine) (<= ?d:begin ?time) (< ?time ?d:end)) (return ?d:end))
  FALSE)
