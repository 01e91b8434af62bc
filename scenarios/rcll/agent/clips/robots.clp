; What speaks for a robot, and what it does without a job.

(defglobal
  ?*PATIENCE* = 1.0   ; s without work until a robot goes home
  ?*WAY* = 1.0        ; what a metre of its way speaks against a robot
  ?*REST* = 0.6)      ; what a second of rest speaks for it

(deffunction reluctance (?x ?y ?robot-x ?robot-y ?idle)
  "What speaks against a robot: its way to the piece, less what it has rested."
  (- (* ?*WAY* (distance ?x ?y ?robot-x ?robot-y)) (* ?*REST* ?idle)))

(deffunction may-take (?robot ?avoid ?not-before ?now)
  "The robot that left a job to others takes it again only after a while."
  (or (>= ?now ?not-before) (and (neq ?avoid "") (neq ?robot ?avoid))))

; --- Nothing to do at all: home, out of the way of others

(deffunction roam (?robot ?skill ?zone)
  "Sends a robot to a zone."
  (assert (command (id (new-id)) (robot (fact-slot-value ?robot name)) (skill ?skill) (target ?zone)))
  (modify ?robot (state ROAMING)))

(defrule robot-go-home
  "No work for a while: home."
  ?robot <- (robot (name ?name) (state IDLE) (home ?home) (place ~?home) (idle-since ?since))
  (time ?now&:(> ?now (+ ?since ?*PATIENCE*)))
  (not (job (step WAITING)))
  =>
  (decide (str-cat ?name " goes home") "there is no work")
  (roam ?robot drive_to ?home))

(defrule robot-roamed
  "It is there, or could not get there: either way it is free."
  ?robot <- (robot (name ?name) (state ROAMING))
  ?command <- (command (robot ?name) (target ?zone) (state SUCCEEDED|FAILED))
  (time ?now)
  =>
  (retract ?command)
  (modify ?robot (state IDLE) (place ?zone) (x (zone-x ?zone)) (y (zone-y ?zone)) (idle-since ?now)))
