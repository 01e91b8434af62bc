; Bases on the slides of the ring stations pay for rings. A slide holds three; a fourth breaks the station.

(deffunction count-payments ()
  "Count for each slide how many payments the rings need that are still to be mounted."
  (do-for-all-facts ((?slide slide)) TRUE
    (bind ?wanted 0)
    (do-for-all-facts ((?p product) (?d does)) (and (eq ?d:machine ?slide:machine) (member$ ?d:work ?p:todo))
      (bind ?wanted (+ ?wanted ?d:price)))
    (modify ?slide (wanted ?wanted))))

(defrule payment-priced
  "The league told the price of a ring: count again, because begun products may need payments."
  (does (price ~0))
  =>
  (count-payments))

(deffunction pay (?slide ?urgency ?from)
  "Add a job that brings a base to a slide; returns its number."
  (modify ?slide (coming (+ (fact-slot-value ?slide coming) 1)))
  (create-job (if (str-index "-BS-" ?from) then PAY else CLEAR) ?urgency 0 ?from (fact-slot-value ?slide spot)))

(deffunction missing-text (?missing)
  (str-cat ?missing (if (= ?missing 1) then " payment is" else " payments are") " missing there"))

(deffunction unpay (?machine ?price)
  "Put payments back on a slide, because their ring was not mounted."
  (do-for-fact ((?s slide)) (eq ?s:machine ?machine) (modify ?s (loaded (+ ?s:loaded ?price)))))

(defrule payment-of-bare-base
  "A bare base lies at a cap station: it pays at the slide where most payments are missing."
  ?clear <- (clear-base ?name)
  ?slide <- (slide (loaded ?l) (coming ?c&:(< (+ ?l ?c) 3)) (wanted ?w) (machine ?m))
  (not (slide (loaded ?l1) (coming ?c1&:(< (+ ?l1 ?c1) 3)) (wanted ?w1&:(> (- ?w1 ?l1 ?c1) (- ?w ?l ?c)))))
  =>
  (retract ?clear)
  (bind ?missing (- ?w ?l ?c))
  (decide (str-cat "pay at " ?m " with the bare base of " ?name) (if (> ?missing 0) then (missing-text ?missing) else "there is room"))
  (hold-up (pay ?slide 2 (str-cat ?name "-OUTPUT")) FETCH))

(defrule payment-no-room
  "A bare base lies at a cap station and all slides are full: the delivery station takes it as order 0."
  ?clear <- (clear-base ?name)
  (not (slide (loaded ?l) (coming ?c&:(< (+ ?l ?c) 3))))
  (machine (name ?delivery) (kind DS))
  =>
  (retract ?clear)
  (decide (str-cat "throw away the bare base of " ?name) "no slide has room")
  (hold-up (create-job CLEAR 2 0 (str-cat ?name "-OUTPUT") (str-cat ?delivery "-INPUT")) FETCH GO-PUT))

(defrule payment-wanted
  "Payments are missing at a slide, and no bare base is at hand: fetch one from the base station."
  ?slide <- (slide (machine ?m) (loaded ?l) (coming ?c&:(< (+ ?l ?c) 3)) (wanted ?w&:(> ?w (+ ?l ?c))))
  (machine (name ?bs) (kind BS))
  =>
  (decide (str-cat "pay at " ?m " with a new base") (missing-text (- ?w ?l ?c)))
  (hold-up (pay ?slide 4 (str-cat ?bs "-OUTPUT")) GO-FETCH FETCH))

(defrule payment-in-advance
  "A robot has nothing else to do: bring a base to the emptiest slide, where it may be of use later."
  (game (phase PRODUCTION))
  (robot (state IDLE) (idle-since ?since))
  (time ?now&:(> ?now (+ ?since ?*PATIENCE*)))
  (not (job (step WAITING)))
  (not (job (purpose PAY)))
  ?slide <- (slide (machine ?m) (loaded ?l) (coming ?c&:(< (+ ?l ?c) 3)))
  (not (slide (loaded ?l1) (coming ?c1&:(< (+ ?l1 ?c1) (+ ?l ?c)))))
  (machine (name ?bs) (kind BS))
  =>
  (decide (str-cat "pay in advance at " ?m) "a robot has nothing to do")
  (hold-up (pay ?slide 5 (str-cat ?bs "-OUTPUT")) GO-FETCH FETCH))

(defrule payment-done
  "The base lies on the slide: count it, unless the station is broken."
  ?job <- (job (purpose CLEAR|PAY) (step DONE) (robot "") (to ?spot))
  ?slide <- (slide (spot ?spot) (machine ?name) (coming ?coming) (loaded ?loaded))
  (machine (name ?name) (state ?state))
  =>
  (retract ?job)
  (modify ?slide (coming (- ?coming 1)) (loaded (if (eq ?state BROKEN) then 0 else (+ ?loaded 1)))))
