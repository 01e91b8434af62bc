; Which robot takes which job: the most urgent job first, then the robot that stands nearest to it.

(deffunction urgency (?purpose)
  "Small is urgent: what frees a machine goes before what fills one."
  (switch ?purpose (case DELIVER then 1) (case CLEAR then 2) (case BASE then 3) (case BUFFER then 4) (default 5)))

(deffunction reluctance (?x ?y ?robot-x ?robot-y ?idle)
  "What speaks against a robot, in m: its way to the piece, less what it has rested."
  (- (distance ?x ?y ?robot-x ?robot-y) (* 0.6 ?idle)))

(deffunction may-take (?robot ?avoid ?not-before ?now)
  "The robot that left a job to others takes it again only after a while."
  (or (>= ?now ?not-before) (and (neq ?avoid "") (neq ?robot ?avoid))))

(defrule robot-take-job
  "The most urgent waiting job, of equals the oldest, goes to the idle robot with the least reluctance."
  ?job <- (job (id ?id) (step WAITING) (purpose ?purpose) (from ?from) (avoid ?avoid) (not-before ?wait))
  (not (job (step WAITING) (purpose ?p&:(< (urgency ?p) (urgency ?purpose)))))
  (not (job (step WAITING) (purpose ?purpose) (id ?other&:(< ?other ?id))))
  (machine (name =(machine-of ?from)) (x ?x) (y ?y))
  (time ?now)
  ?robot <- (robot (name ?name&:(may-take ?name ?avoid ?wait ?now)) (state IDLE) (x ?rx) (y ?ry) (idle-since ?since))
  (not (robot (state IDLE) (name ?o-name&~?name&:(may-take ?o-name ?avoid ?wait ?now)) (x ?ox) (y ?oy)
              (idle-since ?o-since&:(< (reluctance ?x ?y ?ox ?oy (- ?now ?o-since)) (reluctance ?x ?y ?rx ?ry (- ?now ?since))))))
  =>
  (modify ?robot (state BUSY))
  (modify ?job (robot ?name) (step GO-FETCH) (not-before 0.0)))

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
  (bind ?id (create-job (new-id) PAY ?machine 0 (str-cat ?bs "-OUTPUT") ?spot))
  (assert (held-up (job ?id) (step GO-FETCH)) (held-up (job ?id) (step FETCH))))

(defrule robot-pay-done
  ?job <- (job (purpose PAY) (step DONE) (robot ""))
  =>
  (retract ?job))

; --- Nothing to do at all: home, out of the way of others

(defrule robot-go-home
  "No work for a while: home."
  ?robot <- (robot (name ?name) (state IDLE) (home ?home) (place ~?home) (idle-since ?since))
  (time ?now&:(> ?now (+ ?since ?*PATIENCE*)))
  (not (job (step WAITING)))
  =>
  (bind ?id (new-id))
  (modify ?robot (state GOING-HOME))
  (assert (command (id ?id) (robot ?name) (skill drive_to) (target ?home))))

(defrule robot-home
  "It is there, or could not get there: either way it is free."
  ?robot <- (robot (name ?name) (state GOING-HOME) (home ?home))
  ?command <- (command (robot ?name) (skill drive_to) (target ?home) (state SUCCEEDED|FAILED))
  (time ?now)
  =>
  (retract ?command)
  (modify ?robot (state IDLE) (place ?home) (idle-since ?now)))
