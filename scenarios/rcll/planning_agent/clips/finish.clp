; strategy.robot: finish. A step waits for a robot that is still busy, if this robot is predicted to be there sooner than any robot
; that is idle now.

(deffunction fetched-from (?action ?params)
  "The machine where a robot fetches the piece of a step."
  (machine-named (source-of ?action ?params)))

(deffunction idle-arrival (?machine)
  "When the first idle robot can be there, s of the game."
  (bind ?first 1000000.0)
  (do-for-fact ((?m machine)) (eq ?m:name ?machine)
    (do-for-all-facts ((?r robot)) (eq ?r:state IDLE)
      (bind ?first (min ?first (+ (game-time) (drive-time ?r:x ?r:y ?m:x ?m:y))))))
  ?first)

(deffunction job-end (?job ?since)
  "The predicted end of a job that began at that time, both in s of the game."
  (+ ?since (transport-time (machine-of (fact-slot-value ?job from)) (machine-of (fact-slot-value ?job to)))))

(defrule finish-sooner
  "A busy robot is on time and will be there sooner than any idle one: hold the step back until then."
  (declare (salience 10)) ; check: allow salience - before agenda-begin, which begins any step whose conditions hold
  (waits-for-busy-robots)
  ?check <- (pddl-action-condition (action ?id) (state CONDITION-SAT))
  ?step <- (step (id ?id) (state CHECKING) (was ~APPROACHING) (worker ROBOT) (action ?action) (params $?params))
  (time ?)
  (took ?job ?robot ?since)
  ?j <- (job (id ?job) (to ?to))
  (not (held-up (job ?job)))
  (test (< (game-time) (job-end ?j ?since)))
  (test (< (+ (job-end ?j ?since) (way-time (machine-of ?to) (fetched-from ?action ?params)))
           (idle-arrival (fetched-from ?action ?params))))
  =>
  (assert (expected ?robot (job-end ?j ?since)))
  (hold-back ?step ?check (str-cat ?robot " will be there sooner than a robot that is idle now")))

(defrule finish-late
  "A robot takes longer than predicted: steps are looked at again."
  ?expected <- (expected ? ?end)
  (game (begin ?zero))
  (time ?now&:(>= ?now (+ ?zero ?end)))
  =>
  (retract ?expected)
  (look-again))
