; What the agent does with a job when trying again does not help: one rule for each trouble (others: trouble.clp).

; --- Fetching

(defrule recover-missing-carrier
  "The shelf slot is empty: give the job up, and the station goes on with the next slot."
  ?trouble <- (trouble (job ?id) (kind MISSING))
  ?job <- (job (id ?id) (purpose BUFFER) (station ?name))
  ?station <- (cap-station (name ?name))
  =>
  (retract ?trouble)
  (decide (str-cat "give up " (text-of-job ?job)) "no carrier is there")
  (modify ?job (step GIVEN-UP))
  (modify ?station (phase EMPTY)))

(defrule recover-missing-output
  "The piece that should lie at the output does not: a bare base leaves its cap behind, a product is lost. If the machine still
   sees the piece, no robot can take it: reset the machine."
  ?trouble <- (trouble (job ?id) (kind MISSING))
  ?job <- (job (id ?id) (purpose CLEAR|MOVE) (station ?name))
  (machine (name ?name) (kind ~BS) (state ?state&~DOWN))
  =>
  (retract ?trouble)
  (bind ?jammed (eq ?state READY-AT-OUTPUT))
  (decide (str-cat "give up " (text-of-job ?job)) (if ?jammed then "nobody can take the piece: reset" else "the piece is not there"))
  (modify ?job (step GIVEN-UP))
  (if ?jammed then (reset-machine ?name))
  (do-for-fact ((?s cap-station)) (and (eq ?s:name ?name) (eq ?s:phase CLEARING))
    (modify ?s (phase (if ?jammed then EMPTY else LOADED)))))

; --- Putting down

(defrule recover-occupied-belt
  "Something lies on the belt that nobody will take away: reset the machine, then try again."
  ?trouble <- (trouble (job ?id) (kind OCCUPIED))
  ?job <- (job (id ?id) (purpose ?purpose) (to ?to))
  (machine (name ?name&:(eq ?name (machine-of ?to))) (kind ?kind&CS|RS|DS) (state ~DOWN))
  (test (not (str-index "SLIDE" ?to)))
  (time ?now)
  =>
  (retract ?trouble)
  (decide (str-cat "reset " ?name) "something lies on its belt that nobody takes away")
  (modify ?job (tries 0) (not-before (+ ?now ?*RESET-TIME*)))
  (if (and (eq ?purpose MOVE) (neq ?kind DS)) then (hold-up ?id PUT))
  (reset-machine ?name))

(defrule recover-occupied-slide
  "The slide is blocked, or no robot can reach it: no more payments there, no rings that need them; discard the base."
  ?trouble <- (trouble (job ?id) (kind OCCUPIED))
  ?job <- (job (id ?id) (to ?to))
  ?slide <- (slide (spot ?to) (machine ?name) (coming ?coming))
  (machine (name ?delivery) (kind DS))
  =>
  (retract ?trouble)
  (decide (str-cat "pay no more at " ?name) "its slide is blocked")
  (modify ?slide (coming (+ ?coming 3)))
  (do-for-all-facts ((?d does)) (and (eq ?d:machine ?name) (> ?d:price 0))
    (assert (undoable ?d:work))
    (retract ?d))
  (modify ?job (purpose DISCARD) (to (input-of ?delivery)) (step GO-PUT) (tries 0))
  (assert (held-up (job ?id) (step GO-PUT))))

(defrule recover-shelf-used-up
  "No robot reaches the rest of the shelf, and the last cap is used: this station gives no more caps."
  (shelf (machine ?name) (state BARRED))
  (not (shelf (machine ?name) (state FULL)))
  (cap-station (name ?name) (phase EMPTY))
  (not (job (purpose BUFFER) (station ?name)))
  ?does <- (does (machine ?name) (work ?cap))
  =>
  (decide (str-cat "do without caps of " ?name) "there is no way to what is left on its shelf")
  (assert (undoable ?cap))
  (retract ?does))

(defrule recover-undoable
  "A product needs a ring that nobody can pay any more, or a cap that nobody can fetch: reset the machine where it lies."
  (undoable ?work)
  (product (order ?id) (todo $? ?work $?) (at ?name) (state ~MOVING))
  (machine (name ?name) (kind ~BS))
  =>
  (decide (str-cat "reset " ?name) (str-cat "the product of order " ?id " needs " ?work ", which cannot be had"))
  (assert (lost ?id))
  (reset-machine ?name))

(defrule recover-undoable-before-begin
  "A product that needs an impossible work has not left the base station: it is lost at once."
  (undoable ?work)
  (product (order ?id) (todo $? ?work $?) (at ?name) (job 0))
  (machine (name ?name) (kind BS))
  =>
  (assert (lost ?id)))

(defrule recover-undoable-in-hand
  "A robot holds a product whose cap cannot be had, and would wait without end: it discards the product."
  (undoable ?cap)
  (product (order ?order) (todo ?cap $?) (job ?id))
  ?job <- (job (id ?id) (step PUT) (moving NO) (robot ?robot&~""))
  (cap-station (cap ?cap))
  (machine (name ?delivery) (kind DS))
  =>
  (decide (str-cat "give up " (text-of-job ?job)) (str-cat "order " ?order " needs " ?cap ", which cannot be had"))
  (modify ?job (step GIVEN-UP) (robot ""))
  (discard ?robot ?delivery))

(defrule recover-lost-carrier
  ?trouble <- (trouble (job ?id) (kind LOST))
  ?job <- (job (id ?id) (purpose BUFFER) (station ?name))
  ?station <- (cap-station (name ?name))
  =>
  (retract ?trouble)
  (decide (str-cat "give up " (text-of-job ?job)) "the carrier is lost")
  (modify ?job (step GIVEN-UP))
  (modify ?station (phase EMPTY)))

(defrule recover-lost
  "The piece is lost: give its job up. If it was a product, its order is open again."
  ?trouble <- (trouble (job ?id) (kind LOST))
  ?job <- (job (id ?id) (purpose ~BUFFER))
  =>
  (retract ?trouble)
  (decide (str-cat "give up " (text-of-job ?job)) "the piece is lost")
  (modify ?job (step GIVEN-UP)))

(defrule recover-product-in-the-way
  "A cap station broke down while a robot came with its product. With few robots the product would keep the one that is needed:
   the robot discards it."
  ?job <- (job (purpose MOVE) (to ?to) (step PUT) (moving NO) (robot ?robot&~""))
  (cap-station (name ?name&:(eq ?to (input-of ?name))) (phase EMPTY|BUFFERING))
  (not (job (purpose CLEAR) (station ?name) (robot ~"")))
  (team (size ?size&:(< ?size 3)))
  (machine (name ?delivery) (kind DS))
  =>
  (decide (str-cat "give up " (text-of-job ?job)) (str-cat ?name " has lost its cap, and " ?robot " is needed"))
  (modify ?job (step GIVEN-UP) (robot ""))
  (discard ?robot ?delivery))

(defrule recover-product-without-cap
  "The product lies on the belt of a cap station that lost its cap meanwhile: reset the station, and the product is lost."
  (product (order ?id) (at ?name) (state WAITING))
  (cap-station (name ?name) (phase EMPTY|BUFFERING))
  (machine (name ?name) (state IDLE))
  =>
  (decide (str-cat "reset " ?name) (str-cat "it has lost its cap, and the product of order " ?id " lies on its belt"))
  (assert (lost ?id))
  (reset-machine ?name))

(defrule recover-given-up
  "A job was given up: its product is lost, its payment does not come, and the job is forgotten."
  ?job <- (job (id ?id) (step GIVEN-UP) (robot "") (to ?to))
  =>
  (do-for-fact ((?p product)) (= ?p:job ?id) (assert (lost ?p:order)))
  (do-for-fact ((?slide slide)) (eq ?slide:spot ?to) (modify ?slide (coming (- ?slide:coming 1))))
  (forget-job ?job))
