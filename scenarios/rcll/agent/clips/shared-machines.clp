; The base station and the delivery station serve one job at a time.

(defrule base-reserve
  "A robot needs a base and the base station is free: reserve it, and have the base dispensed while the robot drives."
  ?job <- (job (id ?id) (robot ~"") (step GO-FETCH))
  ?held <- (held-up (job ?id) (step GO-FETCH))
  (machine (name ?bs) (kind BS))
  (not (reserved (machine ?bs)))
  =>
  (retract ?held)
  (assert (reserved (machine ?bs) (job ?id)))
  (dispense-base ?job))

(defrule base-ready
  "The base lies at the output: the robot may fetch it."
  ?instruction <- (instruction (id ?id) (operation "DISPENSE_BASE") (state SUCCEEDED))
  ?held <- (held-up (job ?id) (step FETCH))
  =>
  (retract ?instruction ?held))

(defrule base-failed
  "The base station did not dispense the base: instruct it again when it is idle."
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
  "A robot has a piece for the delivery station, which is free: reserve it."
  (job (id ?id) (robot ~"") (step GO-PUT))
  ?held <- (held-up (job ?id) (step GO-PUT))
  (machine (name ?delivery) (kind DS))
  (not (reserved (machine ?delivery)))
  =>
  (retract ?held)
  (assert (reserved (machine ?delivery) (job ?id))))

(defrule delivery-discard
  "A piece that belongs to no product lies on the belt: deliver it as order 0, which throws it away."
  ?job <- (job (id ?id) (purpose CLEAR|DISCARD) (step DONE) (robot "") (to ?to))
  (machine (name ?delivery&:(eq ?to (str-cat ?delivery "-INPUT"))) (kind DS))
  =>
  (retract ?job)
  (assert (instruction (id ?id) (machine ?delivery) (operation "DELIVER") (order 0))))

(defrule delivery-done
  ?instruction <- (instruction (id ?id) (operation "DELIVER") (state ?state&SUCCEEDED|FAILED) (order ?order))
  ?reserved <- (reserved (job ?id))
  =>
  (retract ?instruction ?reserved)
  (assert (delivered ?order ?state)))

(defrule delivery-discarded
  "A piece was delivered as order 0: nothing follows from it."
  ?delivered <- (delivered 0 ?)
  =>
  (retract ?delivered))
