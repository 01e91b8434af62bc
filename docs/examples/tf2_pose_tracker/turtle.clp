(deffacts start (watch turtle1))

(defrule track
  "Look once a second where the turtle is on its canvas."
  (watch ?turtle)
  =>
  (tf2-start-periodic-lookup "world" ?turtle 1.0))

(defrule tell
  "It was seen: say where, and by what angle it is turned."
  (tf2-tracked-pose (child ?turtle) (stamp ?stamp) (translation ?x ?y ?) (rotation ? ? ?z ?w))
  =>
  (bind ?angle (* 2 (acos ?w) (if (< ?z 0) then -1 else 1)))
  (format t "%s is at (%.2f %.2f), turned by %.2f, at %.1f s%n" ?turtle ?x ?y ?angle ?stamp))

(defrule stop-tracking
  "The executive ends."
  (executive-finalize)
  (tf2-tracked-pose (timer ?timer))
  =>
  (tf2-stop-periodic-lookup ?timer))
