; How long robots take. The agent learns from finished transports how much time they take besides the way. This includes retries,
; other robots in the way, and slow arms.

(defglobal
  ?*HANDLING* = 34.0      ; s that a robot needs for a transport besides the way from place to place: the way to the piece, pick, place
  ?*NEW* = 0.1            ; the weight of the last transport in the prediction for the next one
  ?*SPEED* = 0.4)         ; m/s, turns and detours included

(deffunction drive-time (?x ?y ?to-x ?to-y)
  "The time from one place to another, s."
  (/ (distance ?x ?y ?to-x ?to-y) ?*SPEED*))

(deffunction way-time (?one ?other)
  "The time from one machine to another, s."
  (do-for-fact ((?a machine) (?b machine)) (and (eq ?a:name ?one) (eq ?b:name ?other))
    (return (drive-time ?a:x ?a:y ?b:x ?b:y)))
  0.0)

(deffunction transport-time (?from ?to)
  "The time to bring a piece from one machine to another, s."
  (+ ?*HANDLING* (way-time ?from ?to)))

(deffunction learn-handling (?took)
  "Learn from a transport that took so long besides the way. A product takes longer by two transports, and by one for each ring."
  (bind ?longer (* ?*NEW* (- ?took ?*HANDLING*)))
  (bind ?*HANDLING* (+ ?*HANDLING* ?longer))
  (bind ?*C0-TIME* (+ ?*C0-TIME* (* 2 ?longer)))
  (bind ?*RING-TIME* (+ ?*RING-TIME* ?longer)))

(defrule duration-begins
  "A robot has got a job: note the time."
  (job (id ?id) (robot ?robot&~"") (step ~DONE&~GIVEN-UP))
  (not (took ?id ?robot ?))
  (time ?)
  =>
  (assert (took ?id ?robot (game-time))))

(defrule duration-ends
  "A robot has brought a piece: learn from the time, unless the robot drove there in advance and waited for the piece."
  (declare (salience 10))
  ?took <- (took ?id ?robot ?since)
  (job (id ?id) (robot ?robot) (step DONE) (from ?from) (to ?to))
  (step (work ?id) (state RUNNING) (worker ROBOT) (was ~APPROACHING))
  (time ?)
  =>
  (retract ?took)
  (learn-handling (- (game-time) ?since (way-time (machine-of ?from) (machine-of ?to)))))

(defrule duration-forgotten
  "The robot no longer has the job: forget its time."
  ?took <- (took ?id ?robot ?)
  (not (job (id ?id) (robot ?robot) (step ~DONE&~GIVEN-UP)))
  =>
  (retract ?took))
