; The shelves of the cap stations.

(defglobal ?*REFILL* = 25.0)  ; s until an empty shelf is full again

(defrule shelf-wait-for-refill
  "All three slots are empty: the crew fills them."
  (shelf (machine ?name) (state TAKEN))
  (not (shelf (machine ?name) (state FULL)))
  (not (job (purpose BUFFER) (station ?name) (step WAITING|GO-FETCH|FETCH)))
  (not (shelf-refill (machine ?name)))
  (time ?now)
  =>
  (assert (shelf-refill (machine ?name) (at (+ ?now ?*REFILL*)))))

(defrule shelf-refilled
  ?refill <- (shelf-refill (machine ?name) (at ?at))
  (time ?now&:(>= ?now ?at))
  =>
  (retract ?refill)
  (do-for-all-facts ((?shelf shelf)) (eq ?shelf:machine ?name) (modify ?shelf (state FULL))))
