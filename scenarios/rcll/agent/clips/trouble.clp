; What the agent does with a job of any kind when trying again does not help.

(defglobal ?*AVOID* = 20.0)       ; how long a robot leaves a job to the others, s
(defglobal ?*HAND-OVERS* = 3)
(defglobal ?*RESET-TIME* = 35.0)  ; time until a machine that was reset is idle again, s

(deffunction forget-job (?job)
  "Remove a job with all its reservations and notes."
  (bind ?id (fact-slot-value ?job id))
  (retract ?job)
  (do-for-all-facts ((?held held-up)) (= ?held:job ?id) (retract ?held))
  (do-for-all-facts ((?reserved reserved)) (= ?reserved:job ?id) (retract ?reserved))
  (do-for-all-facts ((?trouble trouble)) (= ?trouble:job ?id) (retract ?trouble)))

(deffunction discard (?robot ?delivery)
  "Have the robot bring whatever it holds to the delivery station, as order 0."
  (bind ?id (new-id))
  (assert (job (id ?id) (purpose DISCARD) (to (input-of ?delivery)) (robot ?robot) (step GO-PUT)))
  (hold-up ?id GO-PUT))

(deffunction reset-machine (?machine)
  "Have the machine reset, so that it is idle and empty after a while."
  (if (not (any-factp ((?i instruction)) (and (eq ?i:machine ?machine) (eq ?i:operation "RESET"))))
   then (assert (instruction (id (new-id)) (machine ?machine) (operation "RESET")))))

(defrule recover-held
  "A pick that failed late has gripped the piece all the same: go on with the job."
  ?trouble <- (trouble (job ?id) (kind HELD))
  ?job <- (job (id ?id))
  =>
  (retract ?trouble)
  (modify ?job (step GO-PUT) (tries 0)))

(defrule recover-full
  "The gripper holds an unknown piece: the robot discards it, and another robot does the job."
  ?trouble <- (trouble (job ?id) (kind FULL))
  ?job <- (job (id ?id) (robot ?robot))
  (machine (name ?delivery) (kind DS))
  (time ?now)
  =>
  (retract ?trouble)
  (decide (str-cat "leave " (text-of-job ?job) " to another robot") (str-cat ?robot " holds a piece of which nobody knows"))
  (modify ?job (robot "") (step WAITING) (tries 0) (avoid ?robot) (not-before (+ ?now ?*AVOID*)))
  (discard ?robot ?delivery))

(defrule recover-unable
  "This robot cannot fetch the piece: another robot does, or this one later."
  ?trouble <- (trouble (job ?id) (kind UNABLE))
  ?job <- (job (id ?id) (robot ?name) (step ?step) (handed-over ?count))
  (test (or (eq ?step GO-FETCH) (< ?count ?*HAND-OVERS*)))
  ?robot <- (robot (name ?name))
  (time ?now)
  =>
  (retract ?trouble)
  (decide (str-cat "leave " (text-of-job ?job) " to another robot") (str-cat ?name " cannot fetch the piece"))
  (modify ?robot (state IDLE) (idle-since ?now))
  (modify ?job (robot "") (step WAITING) (tries 0) (avoid ?name) (handed-over (+ ?count 1))
               (not-before (+ ?now (* ?*AVOID* (+ ?count 1))))))

(defrule recover-unable-all
  "No robot can fetch the piece: handle it like a missing piece."
  ?trouble <- (trouble (job ?id) (kind UNABLE))
  (job (id ?id) (step FETCH) (handed-over ?count&:(>= ?count ?*HAND-OVERS*)))
  =>
  (modify ?trouble (kind MISSING)))

(defrule recover-stuck
  "The robot cannot put the piece there: it discards the piece, and the job begins again."
  ?trouble <- (trouble (job ?id) (kind STUCK))
  ?job <- (job (id ?id) (purpose ~DISCARD) (robot ?robot))
  (machine (name ?delivery) (kind DS))
  =>
  (decide (str-cat "throw away what " ?robot " holds") (str-cat "it cannot put it down at " (fact-slot-value ?job to)))
  (modify ?trouble (kind LOST))
  (modify ?job (robot ""))
  (discard ?robot ?delivery))

(defrule recover-stuck-with-waste
  "The robot cannot discard the piece either: it tries again later."
  ?trouble <- (trouble (job ?id) (kind STUCK))
  ?job <- (job (id ?id) (purpose DISCARD))
  (time ?now)
  =>
  (retract ?trouble)
  (modify ?job (tries 0) (not-before (+ ?now ?*RESET-TIME*))))

(defrule recover-missing-base
  "No base is at the base station: have another one dispensed, onto an empty belt."
  ?trouble <- (trouble (job ?id) (kind MISSING))
  ?job <- (job (id ?id) (station ?bs))
  (machine (name ?bs) (kind BS) (state ?state&~DOWN))
  =>
  (retract ?trouble)
  (bind ?job (modify ?job (tries 0) (handed-over 0)))
  (decide (str-cat "have another base dispensed at " (fact-slot-value ?job from)) "there is none")
  (if (eq ?state READY-AT-OUTPUT) then (reset-machine ?bs))
  (assert (held-up (job ?id) (step FETCH)))
  (dispense-base ?job))

(defrule recover-gone-with-machine
  "The machine broke down before the robot fetched the piece from it: the piece is gone."
  (job (id ?id) (purpose CLEAR|MOVE) (station ?name) (step WAITING|GO-FETCH|FETCH))
  (machine (name ?name) (kind ~BS) (state BROKEN))
  =>
  (assert (trouble (job ?id) (kind GONE))))

(defrule recover-gone
  "The piece is gone, and the robot (if the job has one) runs no skill: give the job up."
  (trouble (job ?id) (kind GONE))
  ?job <- (job (id ?id) (step WAITING|GO-FETCH|FETCH) (moving NO))
  =>
  (modify ?job (step GIVEN-UP)))

(defrule recover-not-gone
  "The robot had fetched the piece before it was reported as gone: drop the trouble."
  ?trouble <- (trouble (job ?id) (kind GONE))
  (job (id ?id) (step GO-PUT))
  =>
  (retract ?trouble))
