(defglobal ?*peer* = 0)
(deffacts start (open))

(defrule open
  "At the start: listen to robots. They send to our port, we send to theirs."
  (open)
  =>
  (bind ?*peer* (pb-peer-create-local-crypto "127.0.0.1" 4441 4446 "randomkey" "aes-128-cbc")))

(defrule hear-robot
  (protobuf-msg (type "example.Beacon") (ptr ?beacon) (rcvd-from ?host ?port))
  =>
  (bind ?position (pb-field-value ?beacon "position"))
  (printout t (pb-field-value ?beacon "robot") " at " ?host ":" ?port " is " (pb-field-value ?beacon "state")
    " at " (pb-field-value ?position "x") ", " (pb-field-value ?position "y")
    " and sees " (implode$ (pb-field-list ?beacon "seen")) crlf)
  (pb-destroy ?position))

(defrule order-from-idle-robot
  (protobuf-msg (type "example.Beacon") (ptr ?beacon))
  (test (eq (pb-field-value ?beacon "state") IDLE))
  =>
  (bind ?order (pb-create "example.Order"))
  (pb-set-field ?order "id" 7)
  (pb-set-field ?order "robot" (pb-field-value ?beacon "robot"))
  (pb-broadcast ?*peer* ?order)
  (pb-destroy ?order))

(defrule close
  (executive-finalize)
  =>
  (pb-peer-destroy ?*peer*))
