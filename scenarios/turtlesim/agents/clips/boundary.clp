; Keeps turtle1 within a safe area. Whenever it is seen outside, it is teleported home, and the request is repeated until
; the service acknowledges it.

(defglobal
  ?*SAFE-MIN* = 2.0
  ?*SAFE-MAX* = 9.0
  ?*HOME* = 5.544445
  ?*RETRY-AFTER* = 1.0)

(deftemplate teleport-request
  "A request that was sent and is not acknowledged yet."
  (slot id (type INTEGER))
  (slot sent-at (type FLOAT)))

(deffacts turtle-start
  (turtle-connect))

(defrule turtle-connect
  "At the start: subscribe to the turtle's pose, and open a client of the service that moves it."
  (turtle-connect)
  =>
  (ros-msgs-create-subscription "turtle1/pose" "turtlesim/msg/Pose")
  (ros-msgs-create-client "turtle1/teleport_absolute" "turtlesim/srv/TeleportAbsolute"))

(defrule turtle-pose-receive
  "A pose has come: note whether the turtle is out of bounds, and drop the message."
  ?pose <- (ros-msgs-message (topic "turtle1/pose") (msg-ptr ?msg))
  =>
  (bind ?x (ros-msgs-get-field ?msg "x"))
  (bind ?y (ros-msgs-get-field ?msg "y"))
  (if (or (< ?x ?*SAFE-MIN*) (> ?x ?*SAFE-MAX*) (< ?y ?*SAFE-MIN*) (> ?y ?*SAFE-MAX*)) then
    (assert (turtle-out-of-bounds)))
  (ros-msgs-destroy-message ?msg)
  (retract ?pose))

(deffunction send-turtle-home ()
  "Ask for the turtle to be moved home. Returns the number of the request, or FALSE if nobody serves it."
  (bind ?request (ros-msgs-create-request "turtlesim/srv/TeleportAbsolute"))
  (ros-msgs-set-field ?request "x" ?*HOME*)
  (ros-msgs-set-field ?request "y" ?*HOME*)
  (ros-msgs-set-field ?request "theta" 0.0)
  (bind ?id (ros-msgs-async-send-request ?request "turtle1/teleport_absolute"))
  (ros-msgs-destroy-message ?request)
  ?id)

(defrule turtle-teleport-request
  "The turtle is out of bounds and no request is open: send one. If nobody serves it, the next pose tries again."
  (turtle-out-of-bounds)
  (time ?now)
  (not (teleport-request))
  (ros-msgs-client (service "turtle1/teleport_absolute"))
  =>
  (bind ?id (send-turtle-home))
  (if ?id then
    (printout info "turtle1 is out of bounds: sent home" crlf)
    (assert (teleport-request (id ?id) (sent-at ?now)))))

(defrule turtle-teleport-repeat
  "No acknowledgement for a while: forget the request, so that it is sent again."
  (time ?now)
  ?request <- (teleport-request (sent-at ?sent&:(> (- ?now ?sent) ?*RETRY-AFTER*)))
  =>
  (retract ?request))

(defrule turtle-teleport-acknowledged
  "The request was acknowledged: the turtle is home, so forget the request."
  ?response <- (ros-msgs-response (service "turtle1/teleport_absolute") (request-id ?id) (msg-ptr ?msg))
  ?request <- (teleport-request (id ?id))
  ?out <- (turtle-out-of-bounds)
  =>
  (printout info "turtle1 is home again" crlf)
  (ros-msgs-destroy-message ?msg)
  (retract ?response ?request ?out))

(defrule turtle-teleport-late
  "An acknowledgement came for a request that was given up: drop it."
  ?response <- (ros-msgs-response (service "turtle1/teleport_absolute") (request-id ?id) (msg-ptr ?msg))
  (not (teleport-request (id ?id)))
  =>
  (ros-msgs-destroy-message ?msg)
  (retract ?response))

(defrule turtle-disconnect
  "The executive ends: close all that is open."
  (executive-finalize)
  =>
  (ros-msgs-destroy-subscription "turtle1/pose")
  (ros-msgs-destroy-client "turtle1/teleport_absolute"))

(defrule turtle-drop-message
  "The executive ends: a message that nobody took is dropped."
  (executive-finalize)
  ?fact <- (ros-msgs-message (msg-ptr ?msg))
  =>
  (ros-msgs-destroy-message ?msg)
  (retract ?fact))

(defrule turtle-drop-response
  "The executive ends: a response that nobody took is dropped."
  (executive-finalize)
  ?fact <- (ros-msgs-response (msg-ptr ?msg))
  =>
  (ros-msgs-destroy-message ?msg)
  (retract ?fact))
