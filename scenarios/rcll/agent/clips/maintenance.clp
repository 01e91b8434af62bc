; A robot in maintenance, or disqualified, is off the field: what it held is gone, and others take over its work.

(defrule maintenance-begins
  "It does nothing until it is back."
  ?robot <- (robot (duty ~ACTIVE) (state ~OFF-FIELD))
  =>
  (modify ?robot (state OFF-FIELD)))

(defrule maintenance-ends
  "It stands where it started."
  ?robot <- (robot (duty ACTIVE) (state OFF-FIELD) (home ?home))
  (time ?now)
  =>
  (modify ?robot (state IDLE) (place ?home) (x (zone-x ?home)) (y (zone-y ?home)) (idle-since ?now)))

(defrule maintenance-one-less
  "Where robots are few, less is begun."
  (robot (name ?name) (state OFF-FIELD))
  ?counted <- (counted ?name)
  ?team <- (team (size ?size))
  =>
  (retract ?counted)
  (modify ?team (size (- ?size 1))))

(defrule maintenance-trouble
  "Whatever its trouble was, this is worse."
  (robot (name ?name) (state OFF-FIELD))
  (job (id ?id) (robot ?name))
  ?trouble <- (trouble (job ?id))
  =>
  (retract ?trouble))

(defrule maintenance-job-without-robot
  "It had nothing yet: another robot fetches it."
  (robot (name ?name) (state OFF-FIELD))
  ?job <- (job (id ?id) (robot ?name) (step GO-FETCH|FETCH) (moving NO))
  (not (trouble (job ?id)))
  =>
  (modify ?job (robot "") (step WAITING) (tries 0)))

(defrule maintenance-job-without-piece
  "People took away what it held."
  (robot (name ?name) (state OFF-FIELD))
  ?job <- (job (id ?id) (robot ?name) (step GO-PUT|PUT) (moving NO))
  (not (trouble (job ?id)))
  =>
  (modify ?job (robot ""))
  (assert (trouble (job ?id) (kind LOST))))

(defrule maintenance-base-at-hand
  "The base station has a base ready for a job without a robot. All other robots may wait for that station: one
   of them takes the base, and its own job waits."
  (machine (name ?bs) (kind BS))
  (reserved (machine ?bs) (job ?id))
  ?job <- (job (id ?id) (step WAITING) (avoid ?avoid) (not-before ?wait))
  ?own <- (job (id ?other) (robot ?robot&~"") (step GO-FETCH) (moving NO))
  (held-up (job ?other) (step GO-FETCH))
  (time ?now&:(may-take ?robot ?avoid ?wait ?now))
  =>
  (decide (str-cat ?robot " for " (text-of-job ?job)) "its base is ready, and the robot waits for another one")
  (modify ?own (robot "") (step WAITING))
  (modify ?job (robot ?robot) (step GO-FETCH) (not-before 0.0)))

(defrule maintenance-on-the-way-home
  "The end of a drive that nobody waits for."
  (robot (name ?name) (state OFF-FIELD))
  ?command <- (command (id ?id) (robot ?name) (state SUCCEEDED|FAILED))
  (not (job (id ?id)))
  =>
  (retract ?command))
