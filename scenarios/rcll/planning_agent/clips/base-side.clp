; An action that is refined only as it begins: on which side of the base station a base comes out.

(defglobal ?*BELT-END* = 0.7)  ; m from the middle of a machine to a robot before its belt

(deffunction way-over-side (?direction ?robot ?bs ?to)
  "m from a robot to that side of the base station, 1.0 input or -1.0 output, and on to a machine."
  (bind ?turn (deg-rad (fact-slot-value ?bs rotation)))
  (bind ?x (+ (fact-slot-value ?bs x) (* ?direction ?*BELT-END* (cos ?turn))))
  (bind ?y (+ (fact-slot-value ?bs y) (* ?direction ?*BELT-END* (sin ?turn))))
  (+ (distance (fact-slot-value ?robot x) (fact-slot-value ?robot y) ?x ?y)
     (distance ?x ?y (fact-slot-value ?to x) (fact-slot-value ?to y))))

(defrule base-side
  "A robot is to fetch a base: on the side over which its way is shorter."
  (declare (salience 10))
  ?bs <- (machine (name ?name) (kind BS))
  ?job <- (job (id ?id) (robot ?r&~"") (step GO-FETCH) (from ?from&:(eq ?from (output-of ?name))) (to ?to))
  (held-up (job ?id) (step GO-FETCH))
  ?robot <- (robot (name ?r))
  ?goal <- (machine (name =(machine-of ?to)))
  (test (< (way-over-side 1.0 ?robot ?bs ?goal) (way-over-side -1.0 ?robot ?bs ?goal)))
  (test (eq ?*BASE-SIDE* "nearest"))
  =>
  (decide (str-cat "fetch the base at " (input-of ?name)) (str-cat "the way of " ?r " is shorter"))
  (modify ?job (from (input-of ?name))))
