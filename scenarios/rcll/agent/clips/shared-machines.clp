; The base station and the delivery station serve one job at a time.

(defrule base-reserve
  "A robot that needs a base gets the base station, and the base comes out while it drives."
  (job (id ?id) (purpose BASE|PAY) (robot ~"") (step GO-FETCH) (order ?order))
  ?held <- (held-up (job ?id) (step GO-FETCH))
  (machine (name ?bs) (kind BS))
  (not (reserved (machine ?bs)))
  =>
  (retract ?held)
  (assert (reserved (machine ?bs) (job ?id)))
  (assert (instruction (id ?id) (machine ?bs) (operation "DISPENSE_BASE") (side "OUTPUT") (color (base-of ?order)))))

(defrule base-ready
  "The base lies at the output."
  ?instruction <- (instruction (id ?id) (operation "DISPENSE_BASE") (state SUCCEEDED))
  ?held <- (held-up (job ?id) (step FETCH))
  =>
  (retract ?instruction ?held))

(defrule base-failed
  "The base station did not do it: ask again when it is idle."
  ?instruction <- (instruction (operation "DISPENSE_BASE") (state FAILED) (error ?error))
  =>
  (printout warn "base station: " ?error crlf)
  (modify ?instruction (state NEW) (goal-id NONE)))

(defrule base-taken
  (job (id ?id) (step GO-PUT|PUT|DONE))
  ?reserved <- (reserved (job ?id) (machine ?bs))
  (machine (name ?bs) (kind BS))
  =>
  (retract ?reserved))

(defrule delivery-reserve
  "A robot with a piece for the delivery station gets it."
  (job (id ?id) (robot ~"") (step GO-PUT))
  ?held <- (held-up (job ?id) (step GO-PUT))
  (machine (name ?delivery) (kind DS))
  (not (reserved (machine ?delivery)))
  =>
  (retract ?held)
  (assert (reserved (machine ?delivery) (job ?id))))

(defrule delivery-window-open
  (job (id ?id) (purpose DELIVER) (step PUT) (order ?order))
  (order (id ?order) (begin ?begin))
  (game (begin ?zero))
  (time ?now&:(>= ?now (+ ?zero ?begin)))
  ?held <- (held-up (job ?id) (step PUT))
  =>
  (retract ?held))

(defrule delivery-instruct
  "The piece lies on the belt: tell the delivery station which order it is for; 0 throws it away."
  ?job <- (job (id ?id) (purpose CLEAR|DELIVER|DISCARD) (step DONE) (robot "") (order ?order) (to ?to))
  (machine (name ?delivery&:(eq ?to (str-cat ?delivery "-INPUT"))) (kind DS))
  =>
  (retract ?job)
  (assert (instruction (id ?id) (machine ?delivery) (operation "DELIVER") (order ?order))))

(defrule delivery-done
  ?instruction <- (instruction (id ?id) (operation "DELIVER") (state ?state&SUCCEEDED|FAILED) (order ?order) (error ?error))
  ?reserved <- (reserved (job ?id))
  =>
  (retract ?instruction ?reserved)
  (assert (delivered ?order ?state)))

(defrule delivery-order-done
  ?delivered <- (delivered ?id SUCCEEDED)
  ?order <- (order (id ?id))
  =>
  (retract ?delivered)
  (modify ?order (state DONE)))

(defrule delivery-discarded
  "Nobody ordered it."
  ?delivered <- (delivered 0 ?)
  =>
  (retract ?delivered))

(defrule delivery-order-failed
  "The delivery station broke down: the order is open again."
  ?delivered <- (delivered ?id FAILED)
  ?order <- (order (id ?id))
  =>
  (retract ?delivered)
  (modify ?order (state OPEN)))
