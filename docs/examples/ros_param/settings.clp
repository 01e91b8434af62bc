(deffacts start (read-settings))

(defrule read-settings
  "At the start: what the YAML says of the robot, and a default for what it does not say."
  (read-settings)
  =>
  (printout t (ros-param-get-value "robot.name" "nobody") " drives at " (ros-param-get-value "robot.speed" 0.5) " m/s" crlf)
  (printout t "tools: " (implode$ (ros-param-get-value "robot.tools" (create$))) crlf)
  (printout t "tries: " (ros-param-get-value "robot.tries" 3) crlf))
