; Which robot takes which job: the most urgent job first, then the robot that stands nearest to it.

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

(deffunction choice-text (?way ?rest)
  "Why this robot: of those that are idle."
  (bind ?idle (length$ (find-all-facts ((?r robot)) (eq ?r:state IDLE))))
  (if (= ?idle 1)
   then "no other robot is idle"
   else (format nil "%.1f m to go and %.0f s of rest: best of %d idle robots" ?way ?rest ?idle)))

(defrule robot-take-job
  "The most urgent waiting job, of equals the oldest, goes to the idle robot with the least reluctance."
  (not (to-look))
  ?job <- (job (id ?id) (step WAITING) (urgency ?urgency) (from ?from) (avoid ?avoid) (not-before ?wait))
  (not (job (step WAITING) (urgency ?more&:(< ?more ?urgency))))
  (not (job (step WAITING) (urgency ?urgency) (id ?other&:(< ?other ?id))))
  (machine (name =(machine-of ?from)) (x ?x) (y ?y))
  (time ?now)
  ?robot <- (robot (name ?name&:(may-take ?name ?avoid ?wait ?now)) (state IDLE) (x ?rx) (y ?ry) (idle-since ?since))
  (not (robot (state IDLE) (name ?o-name&~?name&:(may-take ?o-name ?avoid ?wait ?now)) (x ?ox) (y ?oy)
              (idle-since ?o-since&:(< (reluctance ?x ?y ?ox ?oy (- ?now ?o-since)) (reluctance ?x ?y ?rx ?ry (- ?now ?since))))))
  =>
  (decide (str-cat ?name " for " (text-of-job ?job)) (choice-text (distance ?x ?y ?rx ?ry) (- ?now ?since)))
  (modify ?robot (state BUSY))
  (modify ?job (robot ?name) (step GO-FETCH) (not-before 0.0)))

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
