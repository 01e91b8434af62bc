; Which step begins next. A strategy names the steps that may be looked at. The agent asks the PDDL manager whether the conditions of
; the first one hold; if they do, it begins.

(defrule agenda-idle-robot
  "A robot is idle and no job waits for one: a robot waits for a step."
  (logical (exists (robot (state IDLE))) (not (job (step WAITING))) (not (to-look)))
  =>
  (assert (robot-waits)))

(defrule agenda-robot-waits
  "A robot has become idle: steps are looked at again."
  (robot (name ?robot) (state IDLE) (idle-since ?since))
  (robot-waits)
  (not (noticed ?robot ?since))
  =>
  (do-for-all-facts ((?o noticed)) (eq (nth$ 1 ?o:implied) ?robot) (retract ?o))
  (assert (noticed ?robot ?since))
  (look-again))

(defrule agenda-candidate
  "A step has not begun, and a worker is there for it. The strategy (dispatch) decides which candidates may begin."
  (declare (salience 20))
  (logical
    (step (id ?id) (state OPEN|BLOCKED|APPROACHING))
    (or (step (id ?id) (worker ~ROBOT)) (step (id ?id) (state APPROACHING)) (robot-waits)))
  =>
  (assert (candidate ?id)))

(defrule agenda-open
  "Steps may begin while there is a plan, and also while a new plan is made, but not while the world is copied for it."
  (logical (or (and (planning (state IDLE)) (not (replan))) (planning (state GOALS))))
  =>
  (assert (may-begin)))

(defrule agenda-look
  "Steps may begin: look at the one with the smallest rank that has not been looked at since the world changed."
  (may-begin)
  (not (step (state CHECKING)))
  (not (pddl-action-get-effect))
  (not (pddl-fluent-change (instance production)))
  (not (pddl-numeric-fluent-change (instance production)))
  (world-version ?version)
  (allowed ?id)
  ?step <- (step (id ?id) (state ?state) (seen ?seen&:(< ?seen ?version)) (rank ?rank))
  (not (and (allowed ?o&~?id)
            (step (id ?o) (seen ?oseen&:(< ?oseen ?version))
                  (rank ?or&:(or (< ?or ?rank) (and (= ?or ?rank) (< (str-compare ?o ?id) 0)))))))
  =>
  (modify ?step (state CHECKING) (seen ?version) (was ?state))
  (assert (pddl-action-condition (instance production) (action ?id))))

; --- What the strategy holds back

(defglobal ?*TOLD* = (create$))  ; the steps for which the rules have told why they are held back

(defrule agenda-held-back
  "All steps that the strategy names have been looked at: tell once why it does not name each of the others."
  (declare (salience -10))
  (planning (state IDLE))
  (not (replan))
  (not (step (state CHECKING)))
  (not (pddl-action-get-effect))
  (not (pddl-fluent-change (instance production)))
  (not (pddl-numeric-fluent-change (instance production)))
  (world-version ?)
  =>
  (bind ?told (create$))
  (bind ?robot-waits (any-factp ((?r robot-waits)) TRUE))
  (do-for-all-facts ((?s step)) (eq ?s:state OPEN)
    (if (member$ ?s:id ?*TOLD*)
     then (bind ?told (create$ ?told ?s:id))
     else (bind ?why (why-held-back ?s))
          (if (and (not ?why) (not ?robot-waits) (eq ?s:worker ROBOT)) then (bind ?why "no robot is idle"))
          (if ?why
           then (decide (str-cat "hold back " (step-text ?s)) ?why)
                (bind ?told (create$ ?told ?s:id)))))
  (bind ?*TOLD* ?told))

(deffunction hold-back (?step ?check ?why)
  "Hold the step back until the world has changed; a robot that drove there in advance waits there."
  (retract ?check)
  (if (neq ?why (fact-slot-value ?step held-for)) then (decide (str-cat "hold back " (step-text ?step)) ?why))
  (modify ?step (held-for ?why) (state (if (eq (fact-slot-value ?step was) APPROACHING) then APPROACHING else BLOCKED))))

(defrule agenda-blocked
  ?check <- (pddl-action-condition (action ?id) (state CONDITION-UNSAT) (unsatisfied-conditions $?missing))
  ?step <- (step (id ?id) (state CHECKING))
  =>
  (bind ?why "")
  (foreach ?condition ?missing (bind ?why (list-text ?why ?condition)))
  (hold-back ?step ?check (str-cat "missing: " ?why)))

(defrule agenda-no-carrier
  "The shelf is empty, of which the PDDL domain knows nothing: hold back the step that fetches a carrier."
  (declare (salience 10))
  ?check <- (pddl-action-condition (action ?id) (state CONDITION-SAT))
  ?step <- (step (id ?id) (state CHECKING) (action fetch-carrier) (params ?cs))
  (test (eq (full-shelf-spot (machine-named ?cs)) ""))
  =>
  (hold-back ?step ?check "the shelf is empty"))

(deffunction payments-before (?slide ?begin)
  "How many payments come to the slide before that time of the plan."
  (length$ (find-all-facts ((?s step))
    (and (member$ ?s:action (create$ pay-with-new-base pay-with-bare-base)) (eq (nth$ 2 ?s:params) ?slide)
         (member$ ?s:state (create$ OPEN BLOCKED APPROACHING)) (< ?s:begin ?begin)))))

(defrule agenda-no-room
  "The slide has room only for earlier payments: hold this one back, else a product that needs them waits without end."
  (declare (salience 10))
  ?check <- (pddl-action-condition (action ?id) (state CONDITION-SAT))
  ?step <- (step (id ?id) (state CHECKING) (action pay-with-new-base|pay-with-bare-base) (params ? ?slide) (begin ?begin))
  (pddl-numeric-fluent (instance production) (name slide-room) (params ?slide) (value ?room))
  (test (<= ?room (payments-before ?slide ?begin)))
  =>
  (hold-back ?step ?check "the room is for payments before it"))

(defrule agenda-begin
  ?check <- (pddl-action-condition (action ?id) (state CONDITION-SAT))
  ?step <- (step (id ?id) (state CHECKING) (was ?was) (action ?action) (params $?params) (worker ?worker)
                 (work ?work))
  =>
  (retract ?check)
  (decide (str-cat "begin " ?action " " (implode$ ?params)) "its conditions hold")
  (if (and (eq ?worker ROBOT) ?*SUB-ACTIONS*) then (apply-part ?action drive ?params) else (apply-effects ?id START))
  (if (eq ?was APPROACHING)
   then (do-for-all-facts ((?h held-up)) (and (= ?h:job ?work) (eq ?h:step FETCH)) (retract ?h))
   else (bind ?work (begin-work ?action ?params)))
  (if (any-factp ((?p planning)) (eq ?p:state GOALS)) then (assert (begun (action ?action) (params ?params))))
  (modify ?step (state RUNNING) (work ?work)))

; --- Robots that would stand idle drive to where the next piece comes out

(deffunction makes-piece-of (?made ?action ?params)
  "Whether the step of a machine with the parameters `made` makes the piece that a robot fetches for this action."
  (and (member$ (nth$ 1 ?params) ?made) (member$ (source-of ?action ?params) ?made)))

(defrule agenda-approach
  "A machine works on the piece of a step, and no robot can begin anything else: a robot drives there already."
  (planning (state IDLE))
  (world-version ?version)
  ?step <- (step (state BLOCKED) (seen ?version) (worker ROBOT) (action ?action&transport|bring-to-delivery|pay-with-bare-base|discard-bare-base) (params $?params)
                 (rank ?rank))
  (not (step (state OPEN|CHECKING) (worker ROBOT) (rank ?r&:(< ?r ?rank))))
  (step (state RUNNING) (worker MACHINE) (params $?made&:(makes-piece-of ?made ?action ?params)))
  (robot-waits)
  =>
  (bind ?work (begin-work ?action ?params))
  (hold-up ?work FETCH)
  (decide (str-cat "approach for " ?action " " (implode$ ?params)) "the piece is being made, and a robot waits")
  (modify ?step (state APPROACHING) (work ?work)))

(defrule agenda-approach-again
  "A robot drives for a step of the old plan, and the new plan has this step, too: the robot goes on."
  ?approached <- (approached ?work ?action $?params)
  ?step <- (step (state OPEN|BLOCKED) (action ?action) (params $?params))
  =>
  (retract ?approached)
  (modify ?step (state APPROACHING) (work ?work)))

(defrule agenda-approach-in-vain
  "A robot drives for a step of the old plan that the new plan does not have: its job is given up."
  ?approached <- (approached ?work ?action $?params)
  (not (step (state OPEN|BLOCKED|CHECKING) (action ?action) (params $?params)))
  ?job <- (job (id ?work) (moving NO))
  =>
  (retract ?approached)
  (modify ?job (step GIVEN-UP)))

(defrule agenda-approach-too-early
  "A robot drives for a step that the new plan has later: nobody makes the piece and others come first, so its job is given up."
  ?step <- (step (id ?id) (state APPROACHING) (action ?action) (params $?params) (work ?work))
  (not (allowed ?id))
  (not (step (state RUNNING) (worker MACHINE) (params $?made&:(makes-piece-of ?made ?action ?params))))
  ?job <- (job (id ?work) (robot ?robot) (moving NO) (step ~GIVEN-UP))
  =>
  (decide (str-cat ?robot " waits no more for " (step-text ?step)) "nobody makes the piece, and others come first")
  (modify ?job (step GIVEN-UP)))

(defrule agenda-pay-in-advance
  "A robot has been idle for a while: before it drives home, it brings a payment to the slide with most room, for later use."
  (declare (salience 10))
  (planning (state IDLE))
  (game (phase PRODUCTION))
  (robot (state IDLE) (idle-since ?since))
  (time ?now&:(> ?now (+ ?since ?*PATIENCE*)))
  (not (and (allowed ?id) (step (id ?id) (worker ROBOT) (state OPEN|APPROACHING))))
  (not (step (state CHECKING)))
  (not (step (action pay-with-new-base) (state ~DONE)))
  (not (step (begin 100000.0) (state ~DONE)))
  (robot-waits)
  (pddl-numeric-fluent (instance production) (name slide-room) (params ?rs) (value ?room&:(>= ?room 1)))
  (not (pddl-numeric-fluent (instance production) (name slide-room) (value ?more&:(> ?more ?room))))
  (machine (name ?bs) (kind BS))
  (test (eq ?*IN-ADVANCE* TRUE))
  =>
  (decide (str-cat "pay in advance at " ?rs) "a robot has nothing to do")
  (modify (add-step pay-with-new-base (create$ (pddl-name ?bs) (sym-cat ?rs))) (begin 100000.0) (rank 100000.0)))
