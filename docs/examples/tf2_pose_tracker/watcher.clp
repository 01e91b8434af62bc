(deffacts start (watch gripper))

(defrule track
  "Something is to be watched: look twice a second where it is in the map."
  (watch ?frame)
  =>
  (tf2-start-periodic-lookup "map" ?frame 2.0))

(defrule tell
  "It was seen at another place: say where."
  (tf2-tracked-pose (child ?frame) (stamp ?stamp) (translation ?x ?y ?))
  =>
  (printout t ?frame " is at " ?x " " ?y ", seen at " ?stamp " s" crlf))

(defrule stop-tracking
  "It has come far enough."
  (tf2-tracked-pose (translation ?x&:(> ?x 1.0) $?) (timer ?timer))
  =>
  (tf2-stop-periodic-lookup ?timer)
  (cx-shutdown))
