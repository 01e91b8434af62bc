; Which robot is best for a job, and what robots do without a job.

(defglobal
  ?*PATIENCE* = 1.0   ; s without work until a robot goes home
  ?*WAY* = 1.0        ; how much a metre of its way speaks against a robot
  ?*REST* = 0.6)      ; how much a second of rest speaks for it

(deffunction reluctance (?x ?y ?robot-x ?robot-y ?idle)
  "How much speaks against a robot: its way to the piece, less its rest so far."
  (- (* ?*WAY* (distance ?x ?y ?robot-x ?robot-y)) (* ?*REST* ?idle)))

(deffunction may-take (?robot ?avoid ?not-before ?now)
  "Whether the robot may take the job: a robot that left a job to others takes it again only after a while."
  (or (>= ?now ?not-before) (and (neq ?avoid "") (neq ?robot ?avoid))))

; --- Nothing to do at all: home, out of the way of others

(deffunction roam (?robot ?skill ?zone)
  "Send a robot to a zone, without a job."
  (assert (command (id (new-id)) (robot (fact-slot-value ?robot name)) (skill ?skill) (target ?zone)))
  (modify ?robot (state ROAMING)))

(defrule robot-go-home
  "A robot has had no work for a while: it drives home, out of the way of others."
  ?robot <- (robot (name ?name) (state IDLE) (home ?home) (place ~?home) (idle-since ?since))
  (time ?now&:(> ?now (+ ?since ?*PATIENCE*)))
  (not (job (step WAITING)))
  =>
  (decide (str-cat ?name " goes home") "there is no work")
  (roam ?robot drive_to ?home))

(defrule robot-roamed
  "The drive without a job ended, successfully or not: the robot is idle."
  ?robot <- (robot (name ?name) (state ROAMING))
  ?command <- (command (robot ?name) (target ?zone) (state SUCCEEDED|FAILED))
  (time ?now)
  =>
  (retract ?command)
  (modify ?robot (state IDLE) (place ?zone) (x (zone-x ?zone)) (y (zone-y ?zone)) (idle-since ?now)))
