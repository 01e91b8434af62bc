; Failures. A failure is a PDDL action of its own; then the step is tried again, or a new plan is made.

(deffunction fail (?step ?outcome $?params)
  "Apply the effects of the failure of a step, and note why."
  (apply-action ?outcome ?params)
  (decide (str-cat (step-text ?step) " has failed") (str-cat "effects of " ?outcome))
  (do-for-all-facts ((?p picked)) (eq ?p:implied (create$ (fact-slot-value ?step id))) (retract ?p)))

(deffunction fail-part (?step ?part)
  (fail ?step (sym-cat (fact-slot-value ?step action) - ?part) (fact-slot-value ?step params)))

(deffunction want-plan (?step)
  (assert (replan (reason (str-cat (step-text ?step) " has failed")))))

(deffunction plan-again (?step)
  (want-plan ?step)
  (modify ?step (state FAILED)))

; --- Machines

(defrule failure-of-machine
  "A machine has not done its work, and the piece in it is gone: the step has failed, and a new plan is needed."
  ?step <- (step (action ?action) (params $?params) (state RUNNING) (worker MACHINE) (work ?work))
  ?instruction <- (instruction (id ?work) (state FAILED) (error ?error))
  =>
  (printout warn ?action " " (implode$ ?params) " failed: " ?error crlf)
  (retract ?instruction)
  (if (eq ?action retrieve-cap)
   then (fail ?step lose-carrier ?params)
   else (fail ?step lose-work (nth$ 1 ?params) (nth$ 2 ?params)))
  (plan-again ?step))

(defrule failure-broken
  "A machine has broken down: the pieces on it, its cap and its payments are gone, and a new plan is needed."
  (machine (name ?machine) (kind ?kind&~BS) (state BROKEN))
  (in-problem production ?machine)
  (not (emptied ?machine))
  =>
  (assert (emptied ?machine))
  (bind ?name (pddl-name ?machine))
  (apply-action empty-input (create$ ?name))
  (apply-action empty-output (create$ ?name))
  (if (eq ?kind CS) then (apply-action empty-cap-station (create$ ?name)))
  (if (eq ?kind RS) then (apply-action empty-slide (create$ ?name)))
  (assert (replan (reason (str-cat ?machine " has broken down")))))

(defrule failure-repaired
  (machine (name ?machine) (state ~BROKEN))
  ?emptied <- (emptied ?machine)
  =>
  (retract ?emptied))

; --- Pieces that somebody has taken away: the machine saw one at its output and does so no more, and none of our robots has it

(defrule taken-not-yet
  "A machine sees the product or bare base at its output: remember this, as long as no robot fetches the piece."
  (pddl-fluent (instance production) (name ?lies&at-output|bare-base-at-output) (params $? ?m))
  (machine (name ?machine&:(eq ?m (pddl-name ?machine))) (state READY-AT-OUTPUT))
  (not (seen ?lies ?machine))
  =>
  (assert (seen ?lies ?machine)))

(defrule taken-by-us
  "The piece is no longer at the output for the rules: a robot fetches it, or it is lost. Forget the sighting."
  ?seen <- (seen ?lies ?machine)
  (not (pddl-fluent (instance production) (name ?lies) (params $? =(pddl-name ?machine))))
  =>
  (retract ?seen))

(defrule taken-product
  "The machine no longer sees the product at its output: the product begins again at once, before a robot comes for it in vain."
  ?seen <- (seen at-output ?machine)
  (machine (name ?machine) (state IDLE))
  (pddl-fluent (instance production) (name at-output) (params ?product =(pddl-name ?machine)))
  (not (pddl-action-get-effect))
  (not (pddl-fluent-change (instance production)))
  =>
  (retract ?seen)
  (decide (str-cat "begin " ?product " anew") (str-cat "it is gone from the output of " ?machine))
  (apply-action empty-output (create$ (pddl-name ?machine)))
  (assert (replan (reason (str-cat ?product " is gone from " ?machine)))))

(defrule taken-bare-base
  "The cap station no longer sees the bare base at its output: it goes on without a robot, and another base has to pay."
  ?seen <- (seen bare-base-at-output ?machine)
  (machine (name ?machine) (state IDLE))
  (pddl-fluent (instance production) (name bare-base-at-output) (params ?cs&:(eq ?cs (pddl-name ?machine))))
  (not (pddl-action-get-effect))
  (not (pddl-fluent-change (instance production)))
  =>
  (retract ?seen)
  (decide (str-cat "forget the bare base of " ?machine) "it is gone from the output")
  (no-fluent production bare-base-at-output ?cs)
  (fluent production output-free ?cs)
  (look-again)
  (assert (replan (reason (str-cat "the bare base is gone from " ?machine)))))

; --- Robots: what becomes of their jobs

(defrule failure-missing-carrier
  "The slot of the shelf is empty: give the job up, so that another try fetches from the next slot."
  ?trouble <- (trouble (job ?id) (kind MISSING|GONE))
  ?job <- (job (id ?id) (purpose BUFFER))
  =>
  (retract ?trouble)
  (modify ?job (step GIVEN-UP)))

(defglobal
  ?*CARRIERS-IN-VAIN* = 5  ; failed fetches: each slot of a shelf, and again after its refill
  ?*BARE* = 180.0)         ; s until another try

(defrule failure-carrier-in-vain
  (declare (salience 10))
  (step (id ?id) (action fetch-carrier) (params ?cs) (state RUNNING) (work ?work))
  (job (id ?work) (step GIVEN-UP) (robot ""))
  (not (picked ?id))
  =>
  (assert (in-vain ?cs ?work)))

(defrule failure-carrier-after-all
  (step (id ?id) (action fetch-carrier) (params ?cs) (state RUNNING))
  (picked ?id)
  ?in-vain <- (in-vain ?cs ?)
  =>
  (retract ?in-vain))

(defrule failure-bare-shelf
  "Fetching a carrier failed again and again: do without caps of this station, and make a new plan."
  (in-vain ?cs ?)
  (not (bare-shelf (station ?cs)))
  (test (>= (length$ (find-all-facts ((?v in-vain)) (eq (nth$ 1 ?v:implied) ?cs))) ?*CARRIERS-IN-VAIN*))
  =>
  (decide (str-cat "do without caps of " ?cs) "no carrier can be fetched from its shelf")
  (assert (bare-shelf (station ?cs) (since (game-time))) (replan (reason (str-cat "the shelf of " ?cs " is bare"))))
  (no-fluent production shelf-stocked ?cs))

(defrule failure-shelf-used-up
  "No robot can reach the rest of the shelf, so nobody fills it again: do without its caps, and make a new plan."
  (in-problem production ?name)
  (shelf (machine ?name) (state BARRED))
  (not (shelf (machine ?name) (state FULL)))
  (not (bare-shelf (station =(pddl-name ?name))))
  =>
  (bind ?cs (pddl-name ?name))
  (decide (str-cat "do without caps of " ?cs) "there is no way to what is left on its shelf")
  (assert (bare-shelf (station ?cs) (since (game-time))) (replan (reason (str-cat "the shelf of " ?cs " is used up"))))
  (no-fluent production shelf-stocked ?cs))

(defrule failure-shelf-again
  "The shelf was bare for long, and its slots can be reached: try once, because it may have carriers again."
  ?bare <- (bare-shelf (station ?cs) (since ?since))
  (not (shelf (machine =(machine-named ?cs)) (state BARRED)))
  (game (begin ?zero))
  (time ?now&:(> ?now (+ ?zero ?since ?*BARE*)))
  =>
  (decide (str-cat "try the shelf of " ?cs " again") "it may be full again")
  (retract ?bare)
  (do-for-fact ((?v in-vain)) (eq (nth$ 1 ?v:implied) ?cs) (retract ?v))
  (assert (replan (reason (str-cat "the shelf of " ?cs " may be full again"))))
  (fluent production shelf-stocked ?cs)
  (look-again))

(defrule failure-order-without-cap
  "The cap of a begun order cannot be had: give the order up, so that the machine with its product is free for others."
  (bare-shelf)
  ?order <- (order (id ?id) (state STARTED))
  (time ?)
  (test (is-hopeless ?id))
  (not (step (state RUNNING) (params =(product-of ?id) $?)))
  =>
  (decide (str-cat "give up order " ?id) "its cap cannot be had")
  (do-for-all-facts ((?f pddl-fluent)) (and (eq ?f:instance production) (or (eq ?f:name at-input) (eq ?f:name at-output))
                                            (eq (nth$ 1 ?f:params) (product-of ?id)))
    (reset-machine (machine-named (nth$ 2 ?f:params))))
  (modify ?order (state OPEN))
  (assert (replan (reason (str-cat "order " ?id " is given up")))))

(defrule failure-missing-piece
  "The piece that should lie at the output does not: give the job up. If the machine still sees the piece, reset it."
  ?trouble <- (trouble (job ?id) (kind MISSING))
  ?job <- (job (id ?id) (purpose CLEAR|MOVE) (station ?name))
  (machine (name ?name) (kind ~BS) (state ?state&~DOWN))
  =>
  (retract ?trouble)
  (modify ?job (step GIVEN-UP))
  (if (eq ?state READY-AT-OUTPUT) then (reset-machine ?name)))

(defrule failure-out-of-reach
  "The machine sees the piece, but no robot could fetch it: leave it there, and reset the machine if that happens again."
  (declare (salience 10)) ; check: allow salience - before recover-unable-all, which gives the job to nobody else
  (trouble (job ?id) (kind UNABLE))
  ?job <- (job (id ?id) (purpose CLEAR|MOVE) (station ?name) (step FETCH) (handed-over ?count&:(>= ?count ?*HAND-OVERS*)))
  (machine (name ?name) (kind ~BS) (state READY-AT-OUTPUT))
  (not (returned ?name))
  =>
  (assert (returned ?name))
  (modify ?job (step GIVEN-UP)))

(defrule failure-in-reach
  "The machine no longer sees the piece that no robot could fetch: forget that it was out of reach."
  ?returned <- (returned ?name)
  (machine (name ?name) (state ~READY-AT-OUTPUT))
  =>
  (retract ?returned))

(defrule failure-lost
  "The robot lost the piece: give the job up."
  ?trouble <- (trouble (job ?id) (kind LOST))
  ?job <- (job (id ?id))
  =>
  (retract ?trouble)
  (modify ?job (step GIVEN-UP)))

(defrule failure-occupied-belt
  "Something lies on the belt that nobody will take away: reset the machine, then try again."
  ?trouble <- (trouble (job ?id) (kind OCCUPIED))
  ?job <- (job (id ?id) (to ?to))
  (machine (name ?name&:(eq ?name (machine-of ?to))) (state ~DOWN))
  (test (not (str-index "SLIDE" ?to)))
  (time ?now)
  =>
  (retract ?trouble)
  (modify ?job (tries 0) (not-before (+ ?now ?*RESET-TIME*)))
  (reset-machine ?name))

(defrule failure-occupied-slide
  "The slide is blocked, or no robot can reach it: no more payments there, and the robot discards the base."
  ?trouble <- (trouble (job ?id) (kind OCCUPIED))
  ?job <- (job (id ?id) (to ?to) (robot ?robot))
  (test (str-index "SLIDE" ?to))
  (machine (kind DS) (name ?delivery))
  =>
  (retract ?trouble)
  (modify ?job (step GIVEN-UP) (robot ""))
  (discard ?robot ?delivery)
  (assert (blocked-slide (pddl-name (machine-of ?to)))))

(defrule failure-blocked-slide
  "A slide is blocked: set its room below zero, so that no plan pays there."
  (blocked-slide ?station)
  (pddl-numeric-fluent (instance production) (name slide-room) (params ?station) (value ?value&:(> ?value 0)))
  (not (pddl-action-get-effect))
  (not (pddl-numeric-fluent-change (instance production) (name slide-room)))
  =>
  (number production slide-room -3 ?station))

(defrule failure-discarded
  "A discard was given up: count its job as CLEAR, so that the rules for given-up jobs match it."
  ?job <- (job (purpose DISCARD) (step GIVEN-UP) (robot ""))
  =>
  (modify ?job (purpose CLEAR)))

; --- Machines have something of which we do not know

(defglobal ?*UNKNOWN* = 30.0)  ; s; a robot that took a piece reports it sooner

(defrule unknown-piece
  "A machine sees a piece at its output, which should be free: note when this began."
  (machine (name ?machine) (kind CS|RS) (state READY-AT-OUTPUT))
  (in-problem production ?machine)
  (not (unknown ?machine ?))
  (pddl-fluent (instance production) (name output-free) (params =(pddl-name ?machine)))
  (time ?)
  =>
  (assert (unknown ?machine (game-time))))

(defrule unknown-no-more
  ?unknown <- (unknown ?machine ?)
  (or (machine (name ?machine) (state ~READY-AT-OUTPUT))
      (not (pddl-fluent (instance production) (name output-free) (params =(pddl-name ?machine)))))
  =>
  (retract ?unknown))

(defrule unknown-away
  "No job fetches the unknown piece: reset the machine, which could not work any more with the piece at its output."
  ?unknown <- (unknown ?machine ?since)
  (not (job (station ?machine) (purpose MOVE|CLEAR)))
  (game (begin ?zero))
  (time ?now&:(> ?now (+ ?zero ?since ?*UNKNOWN*)))
  =>
  (retract ?unknown)
  (decide (str-cat "reset " ?machine) "nobody knows of the piece at its output")
  (reset-machine ?machine))

; --- A product before a cap station that has lost its cap

(defrule failure-without-cap
  "A cap station lost its cap while a robot came with a product, and the product blocks the way of a carrier: reset the station."
  (machine (name ?machine) (kind CS) (state IDLE))
  (pddl-fluent (instance production) (name at-input) (params ?product ?cs&:(eq ?cs (pddl-name ?machine))))
  (not (pddl-fluent (instance production) (name cap-loaded) (params ?cs)))
  (not (step (action retrieve-cap) (params ?cs) (state RUNNING)))
  (not (step (action mount-cap) (params ?product $?) (state RUNNING)))
  (not (instruction (machine ?machine)))
  (not (pddl-action-get-effect))
  (not (pddl-fluent-change (instance production)))
  =>
  (decide (str-cat "give up " ?product) (str-cat ?machine " has lost its cap, and no carrier can be brought"))
  (reset-machine ?machine))

; --- What becomes of the step

(defrule failure-before-begin
  "A robot drove there in advance, and its job was given up: the step is open again."
  ?step <- (step (state APPROACHING) (work ?work))
  (job (id ?work) (step GIVEN-UP) (robot ""))
  =>
  (modify ?step (state OPEN) (seen -1)))

(defrule failure-return
  "No robot could fetch the piece, which lies where it lay: the step has failed without loss."
  (declare (salience 10))
  ?step <- (step (state RUNNING) (work ?work))
  (job (id ?work) (step GIVEN-UP) (robot ""))
  (trouble (job ?work) (kind UNABLE))
  =>
  (fail-part ?step return)
  (plan-again ?step))

(defrule failure-try-again
  "A carrier or base was not brought, of which there are more: the step is open again."
  ?step <- (step (id ?id) (action fetch-carrier|bring-base|pay-with-new-base) (state RUNNING) (work ?work))
  (job (id ?work) (step GIVEN-UP) (robot "") (purpose ~DISCARD))
  =>
  (fail-part ?step (if (any-factp ((?p picked)) (eq ?p:implied (create$ ?id))) then lose else return))
  (want-plan ?step)
  (modify ?step (state OPEN) (seen -1)))

(defrule failure-pay-otherwise
  "The bare base that should pay is gone: a step is inserted into the plan, in which a new base pays."
  ?step <- (step (action pay-with-bare-base) (params ? ?rs) (state RUNNING) (work ?work))
  (job (id ?work) (step GIVEN-UP) (robot "") (purpose ~DISCARD))
  (not (blocked-slide ?rs))
  (machine (name ?bs) (kind BS))
  =>
  (fail-part ?step lose)
  (insert-instead ?step "the bare base is gone" pay-with-new-base (pddl-name ?bs) ?rs)
  (want-plan ?step)
  (modify ?step (state DONE)))

(defrule failure-no-base
  "The base station is out of order for long: give up the job that waits for it, so that the robot is free for others."
  (long-out-of-order ?bs)
  (machine (name ?bs) (kind BS))
  (step (id ?id) (state RUNNING) (worker ROBOT) (work ?work))
  (not (picked ?id))
  ?job <- (job (id ?work) (station ?bs) (robot ~"") (step GO-FETCH|FETCH) (moving NO))
  (not (instruction (id ?work) (state ~NEW)))
  =>
  (decide (str-cat "give up " (text-of-job ?job)) (str-cat ?bs " is out of order for long"))
  (do-for-fact ((?i instruction)) (= ?i:id ?work) (retract ?i))
  (modify ?job (step GIVEN-UP)))

(defrule failure-gone-anyway
  "The bare base that should be discarded is gone: the step is done, and the plan goes on."
  ?step <- (step (action discard-bare-base) (state RUNNING) (work ?work))
  (job (id ?work) (step GIVEN-UP) (robot "") (purpose ~DISCARD))
  =>
  (fail-part ?step lose)
  (modify ?step (state DONE)))

(defrule failure-plan-again
  "A product is gone, or a payment has no slide to go to: the step has failed, and a new plan is needed."
  (or ?step <- (step (action transport|bring-to-delivery) (state RUNNING) (work ?work))
      (and (blocked-slide ?slide)
           ?step <- (step (action pay-with-bare-base) (params ? ?slide) (state RUNNING) (work ?work))))
  (job (id ?work) (step GIVEN-UP) (robot "") (purpose ~DISCARD))
  =>
  (fail-part ?step lose)
  (plan-again ?step))

(defrule failure-given-up
  "A job was given up and the rules for its step have fired: forget the job."
  (declare (salience -10))
  ?job <- (job (step GIVEN-UP) (robot ""))
  =>
  (forget-job ?job))

; --- What we work for cannot be reached any more: products stand in each other's way, or a slide is blocked

(deffunction worked-for (?product)
  (any-factp ((?o order)) (and (eq ?product (product-of ?o:id)) (eq ?o:state STARTED))))

(deffunction give-up-product (?ours ?where)
  "Give up the first product that lies there (at inputs or outputs), either of our orders or of others: reset its machine.
   Returns FALSE if none lies there."
  (do-for-fact ((?f pddl-fluent)) (and (eq ?f:instance production) (eq ?f:name ?where) (eq ?ours (worked-for (nth$ 1 ?f:params))))
    (decide (str-cat "give up " (implode$ ?f:params)) "there is no plan with all products that are begun")
    (reset-machine (machine-named (nth$ 2 ?f:params)))
    (return TRUE))
  FALSE)

(defrule failure-no-way
  "No plan exists for our orders: open those again that have no product yet, and give up one product on a machine for the others' sake."
  ?no-way <- (no-way)
  (planning (state IDLE))
  =>
  (retract ?no-way)
  (bind ?fewer FALSE)
  (delayed-do-for-all-facts ((?o order) (?f pddl-fluent))
      (and (eq ?o:state STARTED) (eq ?f:instance production) (eq ?f:name not-begun) (eq ?f:params (create$ (product-of ?o:id))))
    (modify ?o (state OPEN))
    (bind ?fewer TRUE))
  (if (not (or (give-up-product FALSE at-input) (give-up-product FALSE at-output)
               (give-up-product TRUE at-input) (give-up-product TRUE at-output)))
   then (if ?fewer then (assert (replan (reason "there is no plan for what we work for"))))))

(defglobal ?*NEXT-WAY* = 15.0)  ; s until a plan is tried again

(defrule failure-no-way-yet
  "No plan was found a while ago, and nothing has asked for another one since: try again."
  ?without-plan <- (without-plan (since ?since))
  (planning (state IDLE))
  (not (replan))
  (time ?now&:(> ?now (+ ?since ?*NEXT-WAY*)))
  =>
  (retract ?without-plan)
  (assert (replan (reason "there was no plan for what we work for"))))

; --- Nobody does anything

(defglobal ?*WATCH* = 60.0)  ; s

(defrule watch-begin
  "No step is running, though steps are open: note when this began."
  (planning (state IDLE))
  (game (phase PRODUCTION))
  (exists (step (state OPEN|BLOCKED)))
  (not (step (state RUNNING) (worker ~AGENT)))
  (not (watched ?))
  (time ?)
  =>
  (assert (watched (game-time))))

(defrule watch-end
  ?watched <- (watched ?)
  (or (exists (step (state RUNNING) (worker ~AGENT)))
      (not (step (state OPEN|BLOCKED))))
  =>
  (retract ?watched))

(defrule watch-rest
  "The open steps have not begun for long and serve no order (caps and payments for later): forget them."
  ?watched <- (watched ?since)
  (not (order (state STARTED)))
  (game (begin ?zero))
  (time ?now&:(> ?now (+ ?zero ?since ?*WATCH*)))
  =>
  (retract ?watched)
  (decide "forget the rest of the plan" "nothing of it can begin, and it is for no order")
  (do-for-all-facts ((?s step)) (member$ ?s:state (create$ OPEN BLOCKED)) (forget-step ?s)))

(defrule watch-bites
  "No step has begun for long: make a new plan, and free the robots that wait for pieces, because other steps may need them."
  ?watched <- (watched ?since)
  (exists (order (state STARTED)))
  (game (begin ?zero))
  (time ?now&:(> ?now (+ ?zero ?since ?*WATCH*)))
  =>
  (retract ?watched)
  (bind ?waiting "")
  (do-for-all-facts ((?s step)) (member$ ?s:state (create$ OPEN BLOCKED))
    (bind ?waiting (list-text ?waiting (step-text ?s))))
  (do-for-all-facts ((?s step) (?j job)) (and (eq ?s:state APPROACHING) (= ?j:id ?s:work) (eq ?j:moving NO))
    (bind ?waiting (list-text ?waiting (str-cat ?j:robot " for " (step-text ?s))))
    (modify ?j (step GIVEN-UP)))
  (if (not (any-factp ((?a allowed)) TRUE)) then (bind ?waiting (list-text ?waiting "the strategy allows none of them")))
  (printout warn "no step is running, these wait: " ?waiting crlf)
  (assert (replan (reason (str-cat "no step is running, these wait: " ?waiting)))))

; --- A running step does not end

(defglobal ?*STILL* = 240.0)  ; s without an effect: longer than any skill, work and down time

(deffunction awaited (?work)
  "Whom the work of a step waits for: the robot of its job, or the machine of its instruction."
  (do-for-fact ((?j job)) (= ?j:id ?work) (return (if (eq ?j:robot "") then "a robot" else ?j:robot)))
  (do-for-fact ((?i instruction)) (= ?i:id ?work) (return ?i:machine))
  "nobody")

(defrule still-begin
  "A step is running: note the time since which nothing in the world has changed."
  (exists (step (state RUNNING) (worker ~AGENT)))
  (game (phase PRODUCTION))
  (world-version ?version)
  (not (still ?version ?))
  (time ?)
  =>
  (do-for-all-facts ((?s still)) TRUE (retract ?s))
  (assert (still ?version (game-time))))

(defrule still-bites
  "Running steps have had no effect for longer than any step takes: report them. A step that no robot works on has failed."
  ?still <- (still ?version ?since)
  (world-version ?version)
  (exists (step (state RUNNING) (worker ~AGENT)))
  (game (begin ?zero))
  (time ?now&:(> ?now (+ ?zero ?since ?*STILL*)))
  =>
  (retract ?still)
  (bind ?waiting "")
  (do-for-all-facts ((?s step)) (and (eq ?s:state RUNNING) (neq ?s:worker AGENT))
    (bind ?waiting (list-text ?waiting (str-cat (step-text ?s) " waits for " (awaited ?s:work)))))
  (printout warn "nothing has ended for " ?*STILL* " s: " ?waiting crlf)
  (decide "wait" ?waiting)
  (delayed-do-for-all-facts ((?s step)) (and (eq ?s:state RUNNING) (eq ?s:worker ROBOT) (eq (awaited ?s:work) "nobody"))
    (fail-part ?s lose)
    (plan-again ?s)))
