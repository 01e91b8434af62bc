; Which robot takes which job: the most urgent job first, then the robot that stands nearest to it.

(deffunction choice-text (?way ?rest)
  "The reason for the choice of a robot among the idle ones."
  (bind ?idle (length$ (find-all-facts ((?r robot)) (eq ?r:state IDLE))))
  (if (= ?idle 1)
   then "no other robot is idle"
   else (format nil "%.1f m to go and %.0f s of rest: best of %d idle robots" ?way ?rest ?idle)))

(defrule robot-take-job
  "A job waits: the most urgent one (the oldest among equals) goes to the idle robot with the least reluctance."
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
