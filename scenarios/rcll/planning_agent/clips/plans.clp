; From what is wanted to the plan in execution.

; --- When there is a new plan to be made

(deffunction is-early (?rings ?begin)
  "Whether a product that begins now would be ready too long before its window."
  (< (+ (game-time) (time-to-make ?rings)) (- ?begin ?*EARLY*)))

(deffunction room-for-more ()
  "Whether we have room for another order, and one is worth it."
  (and (< (length$ (orders-in STARTED)) (products-at-once)) (> (best-of (open-orders)) 0)))

(defrule plan-for-new-order
  "An order is new, and there is room for it or an order can be put off: make a new plan. Else it waits for the next delivery."
  (game (phase PRODUCTION))
  (in-problem planning ?id)
  (order (id ?id) (state ~DONE))
  (not (considered ?id))
  =>
  (assert (considered ?id))
  (do-for-fact ((?o order)) (= ?o:id ?id) (if (not (is-early ?o:rings ?o:begin)) then (assert (in-time ?id))))
  (bind ?ours (orders-in STARTED))
  (if (or (< (length$ ?ours) ?*PRODUCTS*) (> (can-be-put-off ?ours) 0)) then (assert (replan (reason (str-cat "order " ?id " can be worked for"))))))

(defrule plan-for-order-in-time
  "Until now a product for this order would have been ready too early: it can begin now, so make a new plan if there is room."
  (game (phase PRODUCTION))
  (considered ?id)
  (order (id ?id) (state OPEN) (rings $?rings) (begin ?begin))
  (not (in-time ?id))
  (time ?)
  (test (not (is-early ?rings ?begin)))
  =>
  (assert (in-time ?id))
  (if (room-for-more) then (assert (replan (reason (str-cat "order " ?id " can be begun now"))))))

(defrule plan-again-when-second
  "The other team was first with a competitive order for which we work, and which now loses points: make a new plan."
  (order (id ?id) (bonus ?bonus&:(< ?bonus 0)) (state ?state))
  (deadlines ?id ? ?bonus)
  (not (second-with ?id))
  =>
  (assert (second-with ?id))
  (if (eq ?state STARTED) then (assert (replan (reason (str-cat "the other team was first with order " ?id))))))

(defglobal
  ?*LOOK-AGAIN* = 10.0   ; s, whether there is more to do
  ?*TRY-AGAIN* = 60.0)   ; s, what there was no plan for

(deffunction why-left-open (?order)
  (if (any-factp ((?s skipped)) (= ?s:order (fact-slot-value ?order id))) then (return "no plan for it was found as the world is"))
  (if (without-cap (fact-slot-value ?order id)) then (return "its cap cannot be had"))
  (bind ?lost (lost-machine (fact-slot-value ?order id)))
  (if ?lost then (return (str-cat ?lost " is out of order")))
  (if (is-early (fact-slot-value ?order rings) (fact-slot-value ?order begin))
   then (return (format nil "its window begins at %.0f s: too early" (fact-slot-value ?order begin))))
  (if (> (+ (game-time) (time-to-make (fact-slot-value ?order rings))) ?*GAME*) then "there is no time left for it" else "it is worth nothing"))

(deffunction say-left-open (?id ?why)
  "Tell once why an order is left open."
  (if (not (any-factp ((?l left-open)) (and (= ?l:order ?id) (eq ?l:why ?why))))
   then (do-for-all-facts ((?l left-open)) (= ?l:order ?id) (retract ?l))
        (assert (left-open (order ?id) (why ?why)))
        (decide (str-cat "leave order " ?id " open") ?why)))

(deffunction leave-open ()
  "Tell why nobody works for the open orders."
  (foreach ?id (orders-in OPEN)
    (do-for-fact ((?o order)) (= ?o:id ?id) (say-left-open ?id (why-left-open ?o)))))

(defglobal ?*WINDOWS* = 5.0)  ; s from one look at the windows of open orders to the next

(deffacts windows (looked-at-windows 0.0))

(deffunction leave-when-over (?order)
  "Tell why nobody began this order, whose window or game is about to end."
  (bind ?ours (orders-in STARTED))
  (say-left-open (fact-slot-value ?order id)
                 (if (< (length$ ?ours) ?*PRODUCTS*)
                  then (why-left-open ?order)
                  else (str-cat "to the end of its window there was no room beside the orders " (implode$ ?ours)))))

(defrule leave-orders-that-are-over
  (game (phase PRODUCTION))
  ?looked <- (looked-at-windows ?at)
  (time ?now&:(> ?now ?at))
  =>
  (retract ?looked)
  (assert (looked-at-windows (+ ?now ?*WINDOWS*)))
  (do-for-all-facts ((?o order)) (and (eq ?o:state OPEN) (>= (game-time) (min ?o:end (- ?*GAME* ?*WINDOWS*))))
    (if (not (any-factp ((?l left-open)) (= ?l:order ?o:id))) then (leave-when-over ?o))))

(deffunction note-planned ()
  (do-for-all-facts ((?p planned)) TRUE (retract ?p))
  (assert (planned (at (game-time)))))

(defrule plan-again-when-done
  "No step of the plan is left: make a new plan if there is more to do that is worth it, else tell why orders stay open."
  (planning (state IDLE))
  (not (step (state ~DONE&~FAILED)))
  (exists (order (state ~DONE)))
  (not (replan))
  (planned (at ?at))
  (game (begin ?zero))
  (time ?now&:(> ?now (+ ?zero ?at ?*LOOK-AGAIN*)))
  =>
  (note-planned)
  (do-for-all-facts ((?s skipped)) (> (game-time) (+ ?s:since ?*TRY-AGAIN*)) (retract ?s))
  (if (or (neq (orders-in STARTED) (create$)) (room-for-more))
   then (assert (replan (reason "the plan is done")))
   else (leave-open)))

(defrule plan-again-with-room
  "A product was delivered: there is room for the next one, so make a new plan."
  ?delivered <- (product-done ?)
  =>
  (retract ?delivered)
  (skip-no-more)
  (assert (replan (reason "a product is delivered"))))

(defglobal ?*IDLE-ROBOT* = 30.0)  ; s after a plan until another one is made because of an idle robot

(defrule plan-for-idle-robot
  "We have no room for more products, yet a robot has been idle for a while: make a plan with one product more, if it is worth it."
  (declare (salience 20))
  (planning (state IDLE))
  (not (replan))
  (game (phase PRODUCTION))
  (robot-waits)
  (not (and (allowed ?id) (step (id ?id) (worker ROBOT) (state OPEN|APPROACHING))))
  (not (step (state CHECKING)))
  (robot (state IDLE) (idle-since ?since))
  (planned (at ?at))
  (game (begin ?zero))
  (time ?now&:(> ?now (max (+ ?since ?*PATIENCE*) (+ ?zero ?at ?*IDLE-ROBOT*))))
  (test (= (length$ (orders-in STARTED)) ?*PRODUCTS*))
  (test (> (best-of (open-orders)) 0))
  =>
  (assert (robot-to-spare) (replan (reason "a robot has nothing to do"))))

(defrule plan-with-fewer-robots
  (in-problem planning ?robot)
  (robot (name ?robot) (state OFF-FIELD))
  (not (left-field ?robot))
  =>
  (assert (left-field ?robot) (replan (reason (str-cat ?robot " is off the field")))))

(defrule plan-with-more-robots
  ?left <- (left-field ?robot)
  (robot (name ?robot) (state ~OFF-FIELD))
  =>
  (retract ?left)
  (assert (replan (reason (str-cat ?robot " is back")))))

; --- 1. The world as it will be (copy.clp), and what to plan for in it

(defrule plan-begin
  (game (phase PRODUCTION))
  ?planning <- (planning (state IDLE))
  (replan)
  (not (step (state CHECKING)))
  (not (pddl-action-get-effect))
  (not (pddl-fluent-change))
  (not (pddl-numeric-fluent-change))
  (not (pddl-object-change))
  =>
  (bind ?why "")
  (do-for-all-facts ((?r replan)) TRUE
    (bind ?why (list-text ?why ?r:reason))
    (retract ?r))
  (decide "plan" ?why)
  (do-for-all-facts ((?w without-plan)) TRUE (retract ?w))
  (do-for-all-facts ((?b begun)) TRUE (retract ?b))
  (do-for-all-facts ((?s step)) (and (eq ?s:worker AGENT) (eq ?s:state RUNNING)) (modify ?s (state OPEN)))
  (modify ?planning (state COPY)))

(defrule plan-goals
  ?planning <- (planning (state END))
  (not (pddl-action-get-effect (state ~DONE&~ERROR)))
  (not (pddl-fluent-change))
  (not (pddl-numeric-fluent-change))
  =>
  (do-for-all-facts ((?e pddl-action-get-effect)) TRUE (retract ?e))
  (do-for-all-facts ((?a pddl-action)) (member$ ?a:plan (create$ ended part)) (retract ?a))
  (propose-alternatives)
  (modify ?planning (state GOALS)))

; --- 2. A plan for each alternative

(defrule goal-create
  (alternative (name ?name))
  (not (pddl-create-goal-instance (goal ?name)))
  =>
  (assert (pddl-create-goal-instance (instance planning) (goal ?name))))

(defrule goal-filter
  "A goal exists: its plans use only coarse actions."
  (pddl-create-goal-instance (goal ?name) (state DONE))
  (pddl-action-names (instance coarse) (state DONE) (action-names $?coarse))
  (not (filtered ?name))
  =>
  (assert (filtered ?name))
  (assert (pddl-planning-filter (type ACTIONS) (instance planning) (goal ?name) (filter ?coarse))))

(defrule goal-clear
  (alternative (name ?name) (state NEW))
  (filtered ?name)
  (not (pddl-planning-filter))
  (not (pddl-clear-goals (goal ?name)))
  =>
  (assert (pddl-clear-goals (instance planning) (goal ?name))))

(defrule goal-cleared
  ?alternative <- (alternative (name ?name) (orders $?orders) (state NEW))
  ?clear <- (pddl-clear-goals (goal ?name) (state DONE))
  =>
  (retract ?clear)
  (do-for-all-facts ((?g pddl-goal-fluent)) (eq ?g:goal ?name) (retract ?g))
  (foreach ?id ?orders
    (assert (pddl-goal-fluent (instance planning) (goal ?name) (name delivered) (params (product-of ?id)))))
  (if ?*IN-ADVANCE*
   then (do-for-all-facts ((?s cap-station)) (and (any-factp ((?k in-problem)) (eq ?k:implied (create$ planning ?s:name)))
                                                 (not (any-factp ((?b bare-shelf)) (eq ?b:station (pddl-name ?s:name)))))
          (assert (pddl-goal-fluent (instance planning) (goal ?name) (name cap-loaded) (params (pddl-name ?s:name))))))
  (assert (pddl-set-goals (instance planning) (goal ?name)))
  (modify ?alternative (state CLEARED)))

(defrule goal-set
  ?alternative <- (alternative (name ?name) (state CLEARED))
  ?set <- (pddl-set-goals (goal ?name) (state DONE))
  =>
  (retract ?set)
  (assert (pddl-plan (instance planning) (id ?name) (goal ?name)))
  (modify ?alternative (state PLANNING)))

(defrule plan-made
  ?alternative <- (alternative (name ?name) (orders $?orders) (state PLANNING))
  (pddl-plan (id ?name) (state SUCCESS))
  =>
  (bind ?weight (weigh ?name))
  (decide (format nil "%.1f points for %.0f s of robots" (expand$ ?weight)) (str-cat "a plan for the orders " (implode$ ?orders)))
  (modify ?alternative (state PLANNED) (points (nth$ 1 ?weight)) (work (nth$ 2 ?weight))))

(defrule plan-not-made
  ?alternative <- (alternative (name ?name) (orders $?orders) (state PLANNING))
  (pddl-plan (id ?name) (state FAILURE|CANCELED))
  =>
  (decide "no value" (str-cat "there is no plan for the orders " (implode$ ?orders)))
  (modify ?alternative (state WITHOUT-PLAN)))

; --- 3. The best one

(deffunction drop-plan (?name)
  (do-for-all-facts ((?a pddl-action)) (eq ?a:plan ?name) (retract ?a))
  (do-for-all-facts ((?p pddl-plan)) (eq ?p:id ?name) (retract ?p))
  (do-for-all-facts ((?a alternative)) (eq ?a:name ?name) (retract ?a)))

(deffunction has-begun (?action)
  "Whether a step of the plan began while the plan was made. Among equal steps it is the first."
  (do-for-fact ((?b begun)) (and (eq ?b:in-plan FALSE) (eq ?b:action (fact-slot-value ?action name)) (eq ?b:params (params-of ?action)))
    (modify ?b (in-plan TRUE))
    (return TRUE))
  FALSE)

(deffunction share-object (?objects ?others)
  (foreach ?o ?objects (if (member$ ?o ?others) then (return TRUE)))
  FALSE)

(deffunction in-turn (?plan ?begun)
  "Whether the plan has the step that began meanwhile, and no open step before it uses the same product or side of a machine."
  (bind ?action (fact-slot-value ?begun action))
  (bind ?params (fact-slot-value ?begun params))
  (do-for-fact ((?a pddl-action)) (and (eq ?a:plan ?plan) (eq ?a:name ?action) (eq (params-of ?a) ?params))
    (return (not (any-factp ((?s step)) (and (eq ?s:state OPEN) (< ?s:begin ?a:planned-start-time)
                                             (share-object (objects-of ?action ?params) (objects-of ?s:action ?s:params)))))))
  FALSE)

(deffunction take-step (?action)
  "Add a step of the plan, unless it has begun meanwhile."
  (if (has-begun ?action) then (return))
  (bind ?begin (fact-slot-value ?action planned-start-time))
  (modify (add-step (fact-slot-value ?action name) (params-of ?action))
          (begin ?begin) (end (+ ?begin (fact-slot-value ?action planned-duration))) (robot (robot-of ?action))))

(deffunction gain (?alternative)
  "The points that an alternative earns more than the plan for our present orders, for each second of a robot that it takes more."
  (bind ?points (fact-slot-value ?alternative points))
  (bind ?work (fact-slot-value ?alternative work))
  (do-for-fact ((?ours alternative)) (eq ?ours:name alternative-0)
    (bind ?points (- ?points ?ours:points))
    (bind ?work (- ?work ?ours:work)))
  (if (<= ?points 0.0) then 0.0 else (/ ?points (max 1.0 ?work))))

(deffunction best-alternative ()
  "The alternative with the greatest gain; if none has one, the plan for our present orders."
  (bind ?best FALSE)
  (bind ?most -1.0)
  (do-for-all-facts ((?a alternative)) (and (eq ?a:state PLANNED) (or (eq ?a:name alternative-0) (> (gain ?a) 0.0)))
    (if (> (gain ?a) ?most) then (bind ?most (gain ?a)) (bind ?best ?a)))
  ?best)

(deffunction take-plan (?name)
  "Replace the steps that have not begun by those of the plan; running steps stay."
  (do-for-all-facts ((?s step)) (member$ ?s:state (create$ OPEN BLOCKED APPROACHING FAILED))
    (do-for-all-facts ((?a pddl-action)) (eq ?a:id ?s:id) (retract ?a))
    (if (eq ?s:state APPROACHING) then (assert (approached ?s:work ?s:action ?s:params)))
    (retract ?s))
  (do-for-all-facts ((?w waits-for)) TRUE (retract ?w))
  (do-for-all-facts ((?f follows)) TRUE (retract ?f))
  (do-for-all-facts ((?a pddl-action)) (eq ?a:plan ?name) (take-step ?a))
  (do-for-all-facts ((?b begun)) (and (neq (worker-of ?b:action) AGENT) (not (in-turn ?name ?b)))
    (assert (replan (reason (str-cat ?b:action " " (implode$ ?b:params) " has begun before its turn in the plan")))))
  (group-steps)
  (order-steps)
  (rank-steps))

(deffunction put-off (?orders)
  "Open our orders again that the plan leaves out, unless their products have begun meanwhile."
  (do-for-all-facts ((?o order))
      (and (eq ?o:state STARTED) (not (member$ ?o:id ?orders)) (rests (product-of ?o:id)))
    (decide (str-cat "put off order " ?o:id) "another one is worth more")
    (modify ?o (state OPEN))))

(deffunction carry-out (?best)
  (bind ?orders (fact-slot-value ?best orders))
  (decide (str-cat "work for the orders " (implode$ ?orders)) (format nil "%.3f points for each second of a robot" (gain ?best)))
  (bind ?ours (length$ (orders-in STARTED)))
  (put-off ?orders)
  (foreach ?id ?orders (do-for-fact ((?o order)) (= ?o:id ?id) (modify ?o (state STARTED))))
  (take-plan (fact-slot-value ?best name))
  (if (and (> (length$ ?orders) ?ours) (room-for-more)) then (assert (replan (reason "there is room for another order")))))

(deffunction skip-without-plan ()
  "If our present orders have a plan, skip each order that has none beside them. Returns whether there are such orders."
  (bind ?some FALSE)
  (if (not (any-factp ((?ours alternative)) (and (eq ?ours:name alternative-0) (eq ?ours:state WITHOUT-PLAN))))
   then
    (do-for-all-facts ((?a alternative)) (eq ?a:state WITHOUT-PLAN)
      (bind ?id (nth$ (length$ ?a:orders) ?a:orders))
      (decide (str-cat "skip order " ?id) "no plan for it was found as the world is")
      (assert (skipped (order ?id) (since (game-time))))
      (bind ?some TRUE)))
  ?some)

(deffunction go-on (?others)
  (decide "go on as before" "no plan is worth anything")
  (if ?others then (assert (replan (reason "orders are skipped"))))
  (if (any-factp ((?a alternative)) (eq ?a:name alternative-0)) then (assert (no-way) (without-plan (since (now))))))

(defrule plan-choose
  "All alternatives have been planned: carry out the best plan."
  (declare (salience 20))
  ?planning <- (planning (state GOALS))
  (not (step (state CHECKING)))
  (exists (alternative))
  (not (alternative (state ~PLANNED&~WITHOUT-PLAN)))
  (time ?)
  =>
  (note-planned)
  (bind ?others (skip-without-plan))
  (bind ?best (best-alternative))
  (if ?best then (carry-out ?best) else (go-on ?others))
  (do-for-all-facts ((?a alternative)) TRUE (drop-plan ?a:name))
  (do-for-all-facts ((?r robot-to-spare)) TRUE (retract ?r))
  (modify ?planning (state IDLE)))

(defrule plan-nothing-to-do
  ?planning <- (planning (state GOALS))
  (not (alternative))
  (time ?)
  =>
  (note-planned)
  (modify ?planning (state IDLE)))
