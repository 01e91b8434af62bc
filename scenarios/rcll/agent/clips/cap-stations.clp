; The cycle of each cap station, with a rule for each transition: EMPTY -> BUFFERING -> CLEARING -> LOADED. The product that
; takes the cap (products.clp) leaves the station EMPTY.

(defrule station-fetch-carrier
  "A cap station is empty, and its product has left or has its robot: have the carrier of the first full shelf slot brought."
  (game (phase PRODUCTION))
  ?station <- (cap-station (name ?name) (phase EMPTY))
  ?shelf <- (shelf (machine ?name) (spot ?spot) (state FULL))
  (not (shelf (machine ?name) (state FULL) (spot ?other&:(< (str-compare ?other ?spot) 0))))
  (not (and (product (at ?name) (state ~MOVING) (job ?fetch))
            (not (job (id ?fetch) (robot ~"")))))
  (not (job (purpose BUFFER) (station ?name)))
  =>
  (modify ?station (phase BUFFERING))
  (modify ?shelf (state TAKEN))
  (hold-up (create-job BUFFER 4 0 ?spot (str-cat ?name "-INPUT")) PUT))

(defrule station-put-carrier
  "The cap station is idle: its robot may put the carrier on the belt."
  (job (id ?id) (purpose BUFFER) (step GO-FETCH|FETCH|PUT) (station ?name))
  (machine (name ?name) (state IDLE))
  ?held <- (held-up (job ?id) (step PUT))
  =>
  (retract ?held))

(defrule station-retrieve-cap
  "The carrier lies on the belt: instruct the station to take its cap."
  ?job <- (job (id ?id) (purpose BUFFER) (step DONE) (robot "") (station ?name))
  ?station <- (cap-station (name ?name) (phase EMPTY|BUFFERING))
  =>
  (retract ?job)
  (modify ?station (phase BUFFERING))
  (assert (instruction (id ?id) (machine ?name) (operation "RETRIEVE_CAP"))))

(defrule station-cap-retrieved
  "The station has the cap, and the bare base lies at the output: the base must be cleared away."
  ?instruction <- (instruction (machine ?name) (operation "RETRIEVE_CAP") (state SUCCEEDED))
  ?station <- (cap-station (name ?name) (phase BUFFERING))
  =>
  (retract ?instruction)
  (modify ?station (phase CLEARING)))

(defrule station-clear-base
  "A bare base lies at the output, or soon will: ask for a use of it as a payment (payments.clp), or for its removal."
  (machine (name ?name) (kind CS) (state ~BROKEN))
  (or (cap-station (name ?name) (phase CLEARING))
      (instruction (machine ?name) (operation "RETRIEVE_CAP") (state RUNNING)))
  (not (clear-base ?name))
  (not (job (purpose CLEAR) (station ?name) (step ~PUT&~DONE)))
  =>
  (assert (clear-base ?name)))

(defrule station-clear
  "The bare base lies at the output: a robot may take it."
  (cap-station (name ?name) (phase CLEARING))
  (job (id ?id) (purpose CLEAR) (station ?name))
  ?held <- (held-up (job ?id) (step FETCH))
  =>
  (retract ?held))

(defrule station-cleared
  "The bare base has left: the station has its cap and waits for a product."
  (job (purpose CLEAR) (station ?name) (step GO-PUT|DONE))
  ?station <- (cap-station (name ?name) (phase CLEARING))
  =>
  (modify ?station (phase LOADED)))

; --- What goes wrong

(defrule station-instruction-failed
  "The station broke down with its content: it begins again, and nobody needs to fetch the bare base."
  ?instruction <- (instruction (machine ?name) (operation "RETRIEVE_CAP") (state FAILED) (error ?error))
  ?station <- (cap-station (name ?name))
  =>
  (printout warn "RETRIEVE_CAP at " ?name " failed: " ?error crlf)
  (retract ?instruction)
  (modify ?station (phase EMPTY))
  (do-for-fact ((?j job)) (and (eq ?j:purpose CLEAR) (eq ?j:station ?name) (neq ?j:step GIVEN-UP))
    (assert (trouble (job ?j:id) (kind GONE)))))

(defrule station-broken
  "The station broke down by itself and lost its cap and the piece on it: it begins again."
  (machine (name ?name) (state BROKEN))
  ?station <- (cap-station (name ?name) (phase CLEARING|LOADED))
  =>
  (modify ?station (phase EMPTY)))
