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
  "The machine has not done its work, and what lay in it is gone."
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
  "What lies on a machine that breaks down is gone, its cap and its payments, too."
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
  "A product, or a bare base, which no robot fetches now."
  (pddl-fluent (instance production) (name ?lies&at-output|bare-base-at-output) (params $? ?m))
  (machine (name ?machine&:(eq ?m (pddl-name ?machine))) (state READY-AT-OUTPUT))
  (not (seen ?lies ?machine))
  =>
  (assert (seen ?lies ?machine)))

(defrule taken-by-us
  "A robot is on its way to it, or it is lost."
  ?seen <- (seen ?lies ?machine)
  (not (pddl-fluent (instance production) (name ?lies) (params $? =(pddl-name ?machine))))
  =>
  (retract ?seen))

(defrule taken-product
  "It begins again at once, not after a robot has come for it in vain."
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
  "Its cap station goes on without a robot, and another base has to pay."
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
  "The slot of the shelf is empty: the next one."
  ?trouble <- (trouble (job ?id) (kind MISSING|GONE))
  ?job <- (job (id ?id) (purpose BUFFER))
  =>
  (retract ?trouble)
  (modify ?job (step GIVEN-UP)))

(defglobal
  ?*CARRIERS-IN-VAIN* = 5  ; each slot of a shelf, and after its refill again
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
  "No slot has a carrier to which there is a way, again and again: caps of this station cannot be had any more."
  (in-vain ?cs ?)
  (not (bare-shelf (station ?cs)))
  (test (>= (length$ (find-all-facts ((?v in-vain)) (eq (nth$ 1 ?v:implied) ?cs))) ?*CARRIERS-IN-VAIN*))
  =>
  (decide (str-cat "do without caps of " ?cs) "no carrier can be fetched from its shelf")
  (assert (bare-shelf (station ?cs) (since (game-time))) (replan (reason (str-cat "the shelf of " ?cs " is bare"))))
  (no-fluent production shelf-stocked ?cs))

(defrule failure-shelf-used-up
  "There is no way to what is left on the shelf, so nobody fills it again."
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
  "Meanwhile carriers may be there, or a way to them: one try, which shows it."
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
  "The agent gives up the begun steps of it: its machine is free for others."
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
  "What should lie at the output does not. If the machine sees it still, nobody can take it."
  ?trouble <- (trouble (job ?id) (kind MISSING))
  ?job <- (job (id ?id) (purpose CLEAR|MOVE) (station ?name))
  (machine (name ?name) (kind ~BS) (state ?state&~DOWN))
  =>
  (retract ?trouble)
  (modify ?job (step GIVEN-UP))
  (if (eq ?state READY-AT-OUTPUT) then (reset-machine ?name)))

(defrule failure-out-of-reach
  "No robot could fetch the piece, though the machine sees it: it stays there. If that happens again, it goes with a reset."
  (declare (salience 10)) ; check: allow salience - before recover-unable-all, which gives the job to nobody else
  (trouble (job ?id) (kind UNABLE))
  ?job <- (job (id ?id) (purpose CLEAR|MOVE) (station ?name) (step FETCH) (handed-over ?count&:(>= ?count ?*HAND-OVERS*)))
  (machine (name ?name) (kind ~BS) (state READY-AT-OUTPUT))
  (not (returned ?name))
  =>
  (assert (returned ?name))
  (modify ?job (step GIVEN-UP)))

(defrule failure-in-reach
  "It is gone from there."
  ?returned <- (returned ?name)
  (machine (name ?name) (state ~READY-AT-OUTPUT))
  =>
  (retract ?returned))

(defrule failure-lost
  "The piece fell."
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
  "Nobody can come to the slide, or it is blocked: no more payments there; away with the base."
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
  "A slide is blocked: it has no room any more."
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

(defglobal ?*UNKNOWN* = 30.0)  ; s; a robot that has just taken a piece is seen sooner

(defrule unknown-piece
  "Something lies at an output that should be free."
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
  "Nobody fetches it: without a reset the machine would do nothing any more."
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
  "It broke down while a robot came with the product. No carrier can be brought while the product lies there: away with it."
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
  "The robot only drove there in advance."
  ?step <- (step (state APPROACHING) (work ?work))
  (job (id ?work) (step GIVEN-UP) (robot ""))
  =>
  (modify ?step (state OPEN) (seen -1)))

(defrule failure-return
  "The piece lies where it lay."
  (declare (salience 10))
  ?step <- (step (state RUNNING) (work ?work))
  (job (id ?work) (step GIVEN-UP) (robot ""))
  (trouble (job ?work) (kind UNABLE))
  =>
  (fail-part ?step return)
  (plan-again ?step))

(defrule failure-try-again
  "Nothing is lost that another try does not bring: a carrier, a base."
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
  "Its base station is out of order for long: the robot is free for others."
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
  "The bare base that should go away is gone: the plan goes on."
  ?step <- (step (action discard-bare-base) (state RUNNING) (work ?work))
  (job (id ?work) (step GIVEN-UP) (robot "") (purpose ~DISCARD))
  =>
  (fail-part ?step lose)
  (modify ?step (state DONE)))

(defrule failure-plan-again
  "The product is gone, or its payment has no slide to go to."
  (or ?step <- (step (action transport|bring-to-delivery) (state RUNNING) (work ?work))
      (and (blocked-slide ?slide)
           ?step <- (step (action pay-with-bare-base) (params ? ?slide) (state RUNNING) (work ?work))))
  (job (id ?work) (step GIVEN-UP) (robot "") (purpose ~DISCARD))
  =>
  (fail-part ?step lose)
  (plan-again ?step))

(defrule failure-given-up
  "The job is forgotten."
  (declare (salience -10))
  ?job <- (job (step GIVEN-UP) (robot ""))
  =>
  (forget-job ?job))

; --- What we work for cannot be reached any more: products stand in each other's way, or a slide is blocked

(deffunction worked-for (?product)
  (any-factp ((?o order)) (and (eq ?product (product-of ?o:id)) (eq ?o:state STARTED))))

(deffunction give-up-product (?ours ?where)
  "The first product that lies at inputs or outputs, of those for which we work or not, is given up: its machine is reset. FALSE:
   none lies there."
  (do-for-fact ((?f pddl-fluent)) (and (eq ?f:instance production) (eq ?f:name ?where) (eq ?ours (worked-for (nth$ 1 ?f:params))))
    (decide (str-cat "give up " (implode$ ?f:params)) "there is no plan with all products that are begun")
    (reset-machine (machine-named (nth$ 2 ?f:params)))
    (return TRUE))
  FALSE)

(defrule failure-no-way
  "Products that are not begun need not be made; one that lies on a machine is given up, so that the others can go on."
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
  "There was no plan, and nothing has made another one wanted."
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
  "No step is running, though there is something to do."
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
  "Caps and payments for later that cannot be had, while no order is worked for."
  ?watched <- (watched ?since)
  (not (order (state STARTED)))
  (game (begin ?zero))
  (time ?now&:(> ?now (+ ?zero ?since ?*WATCH*)))
  =>
  (retract ?watched)
  (decide "forget the rest of the plan" "nothing of it can begin, and it is for no order")
  (do-for-all-facts ((?s step)) (member$ ?s:state (create$ OPEN BLOCKED)) (forget-step ?s)))

(defrule watch-bites
  "The agent makes a new plan. Robots that wait for pieces are needed for others, perhaps, without which these never come."
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
  (printout warn "nothing is under way, these wait: " ?waiting crlf)
  (assert (replan (reason (str-cat "nothing is under way, these wait: " ?waiting)))))

; --- A running step does not end

(defglobal ?*STILL* = 240.0)  ; s without an effect: longer than any skill, work and down time

(deffunction awaited (?work)
  "The robot of a job, or the machine of an instruction."
  (do-for-fact ((?j job)) (= ?j:id ?work) (return (if (eq ?j:robot "") then "a robot" else ?j:robot)))
  (do-for-fact ((?i instruction)) (= ?i:id ?work) (return ?i:machine))
  "nobody")

(defrule still-begin
  "A step is running: from now on the agent waits for its effects."
  (exists (step (state RUNNING) (worker ~AGENT)))
  (game (phase PRODUCTION))
  (world-version ?version)
  (not (still ?version ?))
  (time ?)
  =>
  (do-for-all-facts ((?s still)) TRUE (retract ?s))
  (assert (still ?version (game-time))))

(defrule still-bites
  "A robot or machine is not done with something, and so nobody is with anything. A step of which no robot knows has failed."
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
