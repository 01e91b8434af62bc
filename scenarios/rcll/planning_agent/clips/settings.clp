; The parameters that every strategy has (docs/reference/planning-agent.md, Parameters), read once at the beginning.

(deffacts settings (read-settings))

(deffunction choose-robots-by (?word)
  "Apply strategy.robot: how much the way and the rest of a robot count, and whether steps wait for busy robots."
  (switch ?word
    (case "nearest" then (bind ?*REST* 0.0))
    (case "rested" then (bind ?*WAY* 0.0))
    (case "finish" then (bind ?*REST* 0.0) (assert (waits-for-busy-robots)))
    (default none)))

(deffunction read-settings-of-robots (?patience $?choices)
  "Read the parameters that every strategy has. The patience is the default for strategy.patience."
  (choose-robots-by (one-of "strategy.robot" "both" ?choices))
  (bind ?*TRANSPORT* (ros-param-get-value "strategy.transport" ?*TRANSPORT*))
  (bind ?*PATIENCE* (at-least 0 "strategy.patience" ?patience)))
