(defglobal ?*peer* = 0)
(deffacts start (open) (state IDLE) (beacons 0))

(defrule open
  "At the start: talk to the referee, encrypted."
  (open)
  =>
  (bind ?*peer* (pb-peer-create-local-crypto "127.0.0.1" 4446 4441 "randomkey" "aes-128-cbc")))

(defrule say-where-i-am
  "Once a second: a beacon."
  (time ?now)
  ?count <- (beacons ?sent&:(>= ?now ?sent))
  (state ?state)
  =>
  (retract ?count)
  (assert (beacons (+ ?sent 1)))
  (bind ?beacon (pb-create "example.Beacon"))
  (pb-set-field ?beacon "robot" "R1")
  (pb-set-field ?beacon "state" ?state)
  (bind ?position (pb-create "example.Position"))
  (pb-set-field ?position "x" 1.5)
  (pb-set-field ?position "y" -2.0)
  (pb-set-field ?beacon "position" ?position)
  (pb-destroy ?position)
  (pb-add-list ?beacon "seen" "C-BS")
  (pb-add-list ?beacon "seen" "C-DS")
  (pb-broadcast ?*peer* ?beacon)
  (pb-destroy ?beacon))

(defrule take-order
  "The message is destroyed at the end of the run; what is needed of it is kept in facts."
  (protobuf-msg (type "example.Order") (ptr ?order))
  ?state <- (state IDLE)
  =>
  (retract ?state)
  (assert (state BUSY))
  (printout t "order " (pb-field-value ?order "id") " for " (pb-field-value ?order "robot") crlf))

(defrule close
  (executive-finalize)
  =>
  (pb-peer-destroy ?*peer*))
