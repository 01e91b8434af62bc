; The cycle of each cap station, one rule a transition. Each creates the job or the instruction that leads to the next.

(deffunction create-job (?id ?purpose ?station ?order ?from ?to)
  "A job without a robot; returns its number."
  (assert (job (id ?id) (purpose ?purpose) (station ?station) (order ?order) (from ?from) (to ?to)))
  ?id)

; --- EMPTY -> BUFFERING -> CLEARING

(defrule station-fetch-carrier
  "An empty cap station: put the carrier of its first full shelf slot on its belt."
  (game (phase PRODUCTION))
  ?station <- (cap-station (name ?name) (phase EMPTY))
  ?shelf <- (shelf (machine ?name) (spot ?spot) (state FULL))
  (not (shelf (machine ?name) (state FULL) (spot ?other&:(< (str-compare ?other ?spot) 0))))
  (not (job (purpose BUFFER) (station ?name)))
  =>
  (modify ?station (phase BUFFERING))
  (modify ?shelf (state TAKEN))
  (bind ?id (create-job (new-id) BUFFER ?name 0 ?spot (str-cat ?name "-INPUT")))
  (assert (held-up (job ?id) (step PUT))))

(defrule station-put-carrier
  "The station is idle: its belt takes the carrier."
  (job (id ?id) (purpose BUFFER) (step PUT) (station ?name))
  (machine (name ?name) (state IDLE))
  ?held <- (held-up (job ?id) (step PUT))
  =>
  (retract ?held))

(defrule station-retrieve-cap
  "The carrier lies on the belt: have its cap taken."
  ?job <- (job (id ?id) (purpose BUFFER) (step DONE) (robot "") (station ?name))
  ?station <- (cap-station (name ?name) (phase EMPTY|BUFFERING))
  =>
  (retract ?job)
  (modify ?station (phase BUFFERING))
  (assert (instruction (id ?id) (machine ?name) (operation "RETRIEVE_CAP"))))

(defrule station-cap-retrieved
  "The cap is in, the bare base at the output: bring it away, to a slide with room or out of the game."
  ?instruction <- (instruction (machine ?name) (operation "RETRIEVE_CAP") (state SUCCEEDED))
  ?station <- (cap-station (name ?name) (phase BUFFERING))
  =>
  (retract ?instruction)
  (modify ?station (phase CLEARING))
  (assert (clear-base ?name)))

(defrule station-clear-to-slide
  "A bare base is a payment."
  ?need <- (clear-base ?name)
  ?slide <- (slide (spot ?spot) (count ?count&:(< ?count 3)))
  (not (slide (count ?less&:(< ?less ?count))))
  =>
  (retract ?need)
  (modify ?slide (count (+ ?count 1)))
  (create-job (new-id) CLEAR ?name 0 (str-cat ?name "-OUTPUT") ?spot))

(defrule station-clear-to-delivery
  "All slides are full: the delivery station takes the bare base as order 0."
  ?need <- (clear-base ?name)
  (not (slide (count ?count&:(< ?count 3))))
  (machine (name ?delivery) (kind DS))
  =>
  (retract ?need)
  (bind ?id (create-job (new-id) CLEAR ?name 0 (str-cat ?name "-OUTPUT") (str-cat ?delivery "-INPUT")))
  (assert (held-up (job ?id) (step GO-PUT))))

(defrule station-cleared
  "The bare base has left: the station waits for a base."
  (job (purpose CLEAR) (station ?name) (step GO-PUT))
  ?station <- (cap-station (name ?name) (phase CLEARING))
  =>
  (modify ?station (phase LOADED)))

(defrule station-clear-done
  ?job <- (job (purpose CLEAR) (step DONE) (robot "") (to ?to&:(not (str-index "-DS-" ?to))))
  =>
  (retract ?job))

; --- LOADED -> MOUNTING -> MOUNTED -> EMPTY

(defrule station-take-order
  "Of the open orders with this station's cap colour it takes the one whose window ends first."
  ?station <- (cap-station (name ?name) (cap ?cap) (order 0) (phase ~MOUNTING&~MOUNTED))
  ?order <- (order (id ?id) (cap ?cap) (end ?end) (state OPEN) (complexity "C0"))
  (not (order (cap ?cap) (state OPEN) (complexity "C0") (id ?other) (end ?sooner&:(or (< ?sooner ?end) (and (= ?sooner ?end) (< ?other ?id))))))
  =>
  (modify ?order (state ASSIGNED))
  (modify ?station (order ?id)))

(defrule station-fetch-base
  "The station has an order and its cap: fetch a base. With three robots the base may come while the cap is still being
   taken; with fewer, the robot would be missing to clear the output."
  (cap-station (name ?name) (order ?order&~0) (phase ?phase&BUFFERING|CLEARING|LOADED))
  (not (job (purpose BASE) (station ?name)))
  (or (cap-station (name ?name) (phase LOADED))
      (and (team (size ?size&:(>= ?size 3)))
           (instruction (machine ?name) (operation "RETRIEVE_CAP")))
      (and (team (size ?size&:(>= ?size 3)))
           (cap-station (name ?name) (phase CLEARING))))
  (machine (name ?bs) (kind BS))
  =>
  (bind ?id (create-job (new-id) BASE ?name ?order (str-cat ?bs "-OUTPUT") (str-cat ?name "-INPUT")))
  (assert (held-up (job ?id) (step GO-FETCH)) (held-up (job ?id) (step FETCH)) (held-up (job ?id) (step PUT))))

(defrule station-put-base
  "The station is idle with its cap in: the base may come."
  (job (id ?id) (purpose BASE) (step PUT) (station ?name))
  (cap-station (name ?name) (phase LOADED))
  (machine (name ?name) (state IDLE))
  (not (instruction (machine ?name) (operation "RESET")))
  ?held <- (held-up (job ?id) (step PUT))
  =>
  (retract ?held))

(defrule station-mount-cap
  "The base lies on the belt: have the cap mounted."
  ?job <- (job (id ?id) (purpose BASE) (step DONE) (robot "") (station ?name))
  ?station <- (cap-station (name ?name) (phase LOADED))
  =>
  (retract ?job)
  (modify ?station (phase MOUNTING))
  (assert (instruction (id ?id) (machine ?name) (operation "MOUNT_CAP"))))

(defrule station-cap-mounted
  ?instruction <- (instruction (machine ?name) (operation "MOUNT_CAP") (state SUCCEEDED))
  ?station <- (cap-station (name ?name) (phase MOUNTING))
  =>
  (retract ?instruction)
  (modify ?station (phase MOUNTED)))

(defrule station-deliver
  "The product is ready and its window is near: bring it to the delivery station."
  (cap-station (name ?name) (phase MOUNTED) (order ?order))
  (machine (name ?name) (state ~BROKEN))
  (order (id ?order) (begin ?begin))
  (not (job (purpose DELIVER) (station ?name)))
  (machine (name ?delivery) (kind DS))
  (game (begin ?zero))
  (time ?now&:(> ?now (- (+ ?zero ?begin) ?*DELIVERY-LEAD*)))
  =>
  (bind ?id (create-job (new-id) DELIVER ?name ?order (str-cat ?name "-OUTPUT") (str-cat ?delivery "-INPUT")))
  (assert (held-up (job ?id) (step GO-PUT)) (held-up (job ?id) (step PUT))))

(defrule station-product-taken
  "The product has left: the station begins anew."
  (job (purpose DELIVER) (station ?name) (order ?order) (step GO-PUT))
  ?station <- (cap-station (name ?name) (phase MOUNTED) (order ?order))
  =>
  (modify ?station (phase EMPTY) (order 0)))

; --- What goes wrong

(defrule station-instruction-failed
  "The machine broke down with what was in it: the station begins anew, for the same order."
  ?instruction <- (instruction (machine ?name) (operation ?operation&"RETRIEVE_CAP"|"MOUNT_CAP") (state FAILED) (error ?error))
  ?station <- (cap-station (name ?name))
  =>
  (printout warn ?operation " at " ?name " failed: " ?error crlf)
  (retract ?instruction)
  (modify ?station (phase EMPTY)))

(defrule station-broken
  "It broke down by itself, and its cap and what lay on it are gone: it begins anew, for the same order."
  (machine (name ?name) (state BROKEN))
  ?station <- (cap-station (name ?name) (phase CLEARING|LOADED|MOUNTED))
  =>
  (modify ?station (phase EMPTY)))

(defrule station-product-saved
  "It broke down just after the product had left: the order needs no second one."
  (job (purpose DELIVER) (station ?name) (order ?order) (step GO-PUT))
  ?station <- (cap-station (name ?name) (order ?order) (phase EMPTY|BUFFERING))
  (not (job (purpose BASE) (station ?name)))
  =>
  (modify ?station (order 0)))

; --- Shelves

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
