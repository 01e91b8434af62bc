; Which robot takes which job: the most urgent job first, then the robot that stands nearest to it.

(deffunction urgency (?purpose)
  "Small is urgent: what frees a machine goes before what fills one."
  (switch ?purpose (case DELIVER then 1) (case CLEAR then 2) (case BASE then 3) (case BUFFER then 4) (default 5)))

(deffunction robot-distance (?robot ?spot)
  "From the machine at which the robot last worked to that of the spot, m."
  (bind ?here (find-fact ((?m machine)) (eq ?m:name (machine-of (fact-slot-value ?robot place)))))
  (bind ?there (find-fact ((?m machine)) (eq ?m:name (machine-of ?spot))))
  (if (or (= 0 (length$ ?here)) (= 0 (length$ ?there))) then (return 20.0))
  (bind ?a (nth$ 1 ?here))
  (bind ?b (nth$ 1 ?there))
  (distance (fact-slot-value ?a x) (fact-slot-value ?a y) (fact-slot-value ?b x) (fact-slot-value ?b y)))

(defrule robot-take-job
  "The most urgent waiting job goes to the nearest idle robot; of equals the one that waits longest."
  ?job <- (job (id ?id) (step WAITING) (purpose ?purpose) (from ?from))
  (not (job (step WAITING) (purpose ?p&:(< (urgency ?p) (urgency ?purpose)))))
  (not (job (step WAITING) (purpose ?purpose) (id ?other&:(< ?other ?id))))
  ?robot <- (robot (name ?name) (state IDLE))
  =>
  (bind ?best ?robot)
  (do-for-all-facts ((?r robot)) (eq ?r:state IDLE)
    (if (< (robot-distance ?r ?from) (robot-distance ?best ?from)) then (bind ?best ?r)))
  (bind ?chosen (fact-slot-value ?best name))
  (modify ?best (state BUSY))
  (modify ?job (robot ?chosen) (step GO-FETCH)))

(defrule robot-pay
  "Nothing else to do: an idle robot brings a base to a slide that has room; each is a payment."
  (game (phase PRODUCTION))
  (robot (name ?name) (state IDLE) (idle-since ?since))
  (time ?now&:(> ?now (+ ?since ?*PATIENCE*)))
  (not (job (step WAITING)))
  (not (job (purpose PAY)))
  ?slide <- (slide (spot ?spot) (machine ?machine) (count ?count&:(< ?count 3)))
  (not (slide (count ?less&:(< ?less ?count))))
  (machine (name ?bs) (kind BS))
  =>
  (modify ?slide (count (+ ?count 1)))
  (bind ?id (create-job PAY ?machine 0 (str-cat ?bs "-OUTPUT") ?spot))
  (assert (held-up (job ?id) (step GO-FETCH)) (held-up (job ?id) (step FETCH))))

(defrule robot-pay-done
  ?job <- (job (purpose PAY) (step DONE) (robot ""))
  =>
  (retract ?job))
