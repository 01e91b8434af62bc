; The shelves of the cap stations.

(defglobal ?*REFILL* = 25.0)  ; s until an empty shelf is full again

(deffunction has-no-way (?station)
  "Whether a slot of the shelf is out of reach. Its carrier then stays, so the crew never fills the other slots again."
  (any-factp ((?s shelf)) (and (eq ?s:machine ?station) (eq ?s:state BARRED))))

(deffunction carriers-left (?station)
  "How many carriers robots can still fetch from a shelf that nobody fills again."
  (length$ (find-all-facts ((?s shelf)) (and (eq ?s:machine ?station) (eq ?s:state FULL)))))

(defrule shelf-slot-barred
  "No robot can reach the slot from anywhere: mark it, so that no robot goes there again."
  ?trouble <- (trouble (job ?id) (kind BARRED))
  (job (id ?id) (from ?spot))
  ?shelf <- (shelf (spot ?spot))
  =>
  (decide (str-cat "leave out " ?spot) "there is no way to it")
  (modify ?shelf (state BARRED))
  (modify ?trouble (kind MISSING)))

(defrule shelf-wait-for-refill
  "All three slots are empty: wait until the crew has filled them."
  (shelf (machine ?name))
  (not (shelf (machine ?name) (state FULL|BARRED)))
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
