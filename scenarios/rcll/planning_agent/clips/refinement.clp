; Actions that are refined only as they begin: which base pays, and at which side of its station a base comes out. For the side a
; rule compares the ways of the robot, or a plan of level two is made for it (refinement.pddl).

(defglobal
  ?*BELT-END* = 0.7    ; m from the middle of a machine to a robot before its belt
  ?*IN-THE-WAY* = 10.0) ; s until a robot that stands there has gone

(deffunction side-of-base-station (?bs ?direction)
  "The place x, y of a robot at the input (1.0) or the output (-1.0) of the base station."
  (bind ?turn (deg-rad (fact-slot-value ?bs rotation)))
  (create$ (+ (fact-slot-value ?bs x) (* ?direction ?*BELT-END* (cos ?turn)))
           (+ (fact-slot-value ?bs y) (* ?direction ?*BELT-END* (sin ?turn)))))

(deffunction way-from-side (?bs ?direction ?place)
  "The time from a side of the base station to a robot or machine, s."
  (bind ?side (side-of-base-station ?bs ?direction))
  (drive-time (nth$ 1 ?side) (nth$ 2 ?side) (fact-slot-value ?place x) (fact-slot-value ?place y)))

(deffunction way-over-side (?bs ?direction ?robot ?to)
  (+ (way-from-side ?bs ?direction ?robot) (way-from-side ?bs ?direction ?to)))

(defrule refine-by-way
  "A robot needs a base, and its way over the input of the base station is shorter: it fetches the base there."
  (declare (salience 10))
  ?bs <- (machine (name ?name) (kind BS))
  ?job <- (job (id ?id) (robot ?r) (step GO-FETCH) (from ?from&:(eq ?from (output-of ?name))) (to ?to))
  (held-up (job ?id) (step GO-FETCH))
  ?robot <- (robot (name ?r))
  ?goal <- (machine (name =(machine-of ?to)))
  (test (< (way-over-side ?bs 1.0 ?robot ?goal) (way-over-side ?bs -1.0 ?robot ?goal)))
  (test (eq ?*BASE-SIDE* "nearest"))
  =>
  (decide (str-cat "fetch the base at " (input-of ?name)) (str-cat "the way of " ?r " is shorter"))
  (modify ?job (from (input-of ?name))))

; --- Which base pays

(deffunction wait-for-instead (?old ?new)
  "Let the steps that wait for the old step, or follow it, do so for the new one."
  (do-for-all-facts ((?w waits-for)) (eq ?w:for ?old) (modify ?w (for ?new)))
  (do-for-all-facts ((?f follows)) (eq ?f:after ?old) (modify ?f (after ?new))))

(deffunction insert-instead (?step ?why ?action $?params)
  "Add a step at the place of another one in the plan; returns the id of the new step."
  (decide (str-cat "insert " ?action " " (implode$ ?params)) ?why)
  (bind ?new (add-step ?action ?params))
  (bind ?id (fact-slot-value ?new id))
  (modify ?new (begin (fact-slot-value ?step begin)) (end (fact-slot-value ?step end))
               (rank (fact-slot-value ?step rank)) (group (fact-slot-value ?step group)))
  (wait-for-instead (fact-slot-value ?step id) ?id)
  ?id)

(deffunction forget-step (?step)
  "Remove a step that has not begun. The steps that waited for it must wait for another one already."
  (bind ?id (fact-slot-value ?step id))
  (do-for-all-facts ((?w waits-for)) (eq ?w:step ?id) (retract ?w))
  (do-for-all-facts ((?f follows)) (eq ?f:step ?id) (retract ?f))
  (do-for-all-facts ((?a pddl-action)) (eq ?a:id ?id) (retract ?a))
  (retract ?step))

(defrule refine-payment
  "A new base is to pay, but a bare base lies at an output that the plan only discards or does not use: the bare base pays."
  (declare (salience 5))
  ?check <- (pddl-action-condition (action ?id) (state CONDITION-SAT))
  ?step <- (step (id ?id) (state CHECKING) (action pay-with-new-base) (params ? ?rs))
  (pddl-fluent (instance production) (name bare-base-at-output) (params ?cs))
  (not (step (action pay-with-bare-base) (params ?cs ?) (state ~DONE)))
  (not (step (action discard-bare-base) (params ?cs ?) (state APPROACHING)))
  =>
  (retract ?check)
  (bind ?new (insert-instead ?step "the plan has no other use for this base" pay-with-bare-base ?cs ?rs))
  (forget-step ?step)
  (delayed-do-for-all-facts ((?s step)) (and (eq ?s:action discard-bare-base) (eq (nth$ 1 ?s:params) ?cs) (member$ ?s:state (create$ OPEN BLOCKED)))
    (wait-for-instead ?s:id ?new)
    (forget-step ?s)))

; --- Level two

(defrule refine-load
  (plans-sides)
  (pddl-instance (name coarse) (directory ?folder))
  (not (pddl-instance (name refinement)))
  =>
  (assert (pddl-instance (name refinement) (domain "refinement.pddl") (problem "refinement_problem.pddl") (directory ?folder))
          (pddl-create-goal-instance (instance refinement) (goal base))
          (pddl-goal-fluent (instance refinement) (goal base) (name base-there))))

(defrule refine-goal
  "The instance of level two is ready: set its goal, which is always the same."
  ?made <- (pddl-create-goal-instance (instance refinement) (state DONE))
  =>
  (retract ?made)
  (assert (pddl-set-goals (instance refinement) (goal base))))

(defrule refine-ready
  ?set <- (pddl-set-goals (instance refinement) (state DONE))
  =>
  (retract ?set)
  (assert (can-refine)))

(deffunction say-ways (?bs ?side ?direction ?robot ?to)
  "Set the times over a side of the base station, where another robot may stand in the way."
  (bind ?spot (str-cat (fact-slot-value ?bs name) "-" (upcase ?side)))
  (bind ?waits (if (any-factp ((?r robot)) (and (eq ?r:place ?spot) (neq ?r:name (fact-slot-value ?robot name)))) then ?*IN-THE-WAY* else 0.0))
  (number refinement way-to (+ 1.0 ?waits (way-from-side ?bs ?direction ?robot)) ?side)
  (number refinement way-on (+ 1.0 (way-from-side ?bs ?direction ?to)) ?side))

(defrule refine-begin
  "A robot needs a base: keep the base station for its job until there is a plan of level two."
  (declare (salience 10))
  (can-refine)
  (not (refining ?))
  ?bs <- (machine (name ?name) (kind BS))
  (not (reserved (machine ?name)))
  (job (id ?id) (robot ?r) (step GO-FETCH) (from ?from&:(eq ?from (output-of ?name))) (to ?to))
  (held-up (job ?id) (step GO-FETCH))
  (not (refined ?id))
  ?robot <- (robot (name ?r))
  ?goal <- (machine (name =(machine-of ?to)))
  =>
  (assert (reserved (machine ?name) (job ?id)) (refining ?id))
  (say-ways ?bs input 1.0 ?robot ?goal)
  (say-ways ?bs output -1.0 ?robot ?goal))

(defrule refine-plan
  (refining ?)
  (not (pddl-numeric-fluent-change (instance refinement)))
  (not (pddl-plan (instance refinement)))
  =>
  (assert (pddl-plan (instance refinement) (id refine) (goal base) (plan-type TEMPORAL))))

(defrule refine-done
  "Level two has planned: the base comes out at the side of the plan; without a plan, at the output."
  ?refining <- (refining ?id)
  (pddl-plan (id refine) (state SUCCESS|FAILURE|CANCELED))
  ?reserved <- (reserved (job ?id))
  =>
  (bind ?side output)
  (do-for-fact ((?a pddl-action)) (and (eq ?a:plan refine) (eq ?a:name dispense)) (bind ?side (nth$ 1 ?a:params)))
  (drop-plan refine)
  (retract ?refining ?reserved)
  (assert (refined ?id))
  (do-for-fact ((?j job)) (= ?j:id ?id)
    (bind ?spot (str-cat (machine-of ?j:from) "-" (upcase ?side)))
    (decide (str-cat "fetch the base at " ?spot) (str-cat "a plan of level two for " ?j:robot))
    (modify ?j (from ?spot))))

(defrule refine-forgotten
  ?refined <- (refined ?id)
  (not (job (id ?id)))
  =>
  (retract ?refined))
