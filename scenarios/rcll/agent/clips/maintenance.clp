; A robot in maintenance, or disqualified, is off the field: its piece is gone, and others take over its work.

(defrule maintenance-begins
  "A robot went to maintenance: it does nothing until it is back."
  ?robot <- (robot (duty ~ACTIVE) (state ~OFF-FIELD))
  =>
  (modify ?robot (state OFF-FIELD)))

(defrule maintenance-ends
  "The robot is back: it stands where it started the game, and is idle."
  ?robot <- (robot (duty ACTIVE) (state OFF-FIELD) (home ?home))
  (time ?now)
  =>
  (modify ?robot (state IDLE) (place ?home) (x (zone-x ?home)) (y (zone-y ?home)) (idle-since ?now)))

(defrule maintenance-one-less
  "A robot is off the field: the team counts as smaller, so that it begins fewer products."
  (robot (name ?name) (state OFF-FIELD))
  ?counted <- (counted ?name)
  ?team <- (team (size ?size))
  =>
  (retract ?counted)
  (modify ?team (size (- ?size 1))))

(defrule maintenance-trouble
  "A robot with trouble is off the field: drop the trouble, because the robot's absence is worse."
  (robot (name ?name) (state OFF-FIELD))
  (job (id ?id) (robot ?name))
  ?trouble <- (trouble (job ?id))
  =>
  (retract ?trouble))

(defrule maintenance-job-without-robot
  "A robot that had not fetched its piece is off the field: another robot fetches it."
  (robot (name ?name) (state OFF-FIELD))
  ?job <- (job (id ?id) (robot ?name) (step GO-FETCH|FETCH) (moving NO))
  (not (trouble (job ?id)))
  =>
  (modify ?job (robot "") (step WAITING) (tries 0)))

(defrule maintenance-job-without-piece
  "A robot that held a piece is off the field: people took the piece away, so it is lost."
  (robot (name ?name) (state OFF-FIELD))
  ?job <- (job (id ?id) (robot ?name) (step GO-PUT|PUT) (moving NO))
  (not (trouble (job ?id)))
  =>
  (modify ?job (robot ""))
  (assert (trouble (job ?id) (kind LOST))))

(defrule maintenance-base-at-hand
  "The base station has a base ready for a job without a robot, and all other robots may be waiting for that station. One of
   them takes the base, and its own job waits."
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
  "A drive ended for which no job waits: forget its command."
  (robot (name ?name) (state OFF-FIELD))
  ?command <- (command (id ?id) (robot ?name) (state SUCCEEDED|FAILED))
  (not (job (id ?id)))
  =>
  (retract ?command))
