; The planning problem: objects and facts for all that the league reports.

(defglobal
  ?*WINDOW-LEAD* = 45.0  ; so long before its window a product is fetched for its delivery, s
  ?*LOADING* = 30.0      ; s in which the PDDL manager should have answered
  ?*ASKED-AT* = 0.0)     ; when it was asked, s

(defrule problem-load
  "At the start: load both instances, and the coarse actions alone for their names, from the folder of this package."
  (pddl-manager)
  (not (pddl-instance))
  =>
  (bind ?*ASKED-AT* (now))
  (bind ?folder (str-cat (ament-index-get-package-share-directory "rcll_planning_agent") "/pddl"))
  (assert (pddl-instance (name production) (domain "production.pddl") (problem "problem.pddl") (directory ?folder))
          (pddl-instance (name planning) (domain "planning.pddl") (problem "planning_problem.pddl") (directory ?folder))
          (pddl-instance (name coarse) (domain "coarse.pddl") (directory ?folder))
          (pddl-action-names (instance coarse))))

(deffunction give-up (?why)
  "End the run, because the agent can do nothing without plans."
  (printout error "nothing can be planned: " ?why crlf)
  (cx-shutdown))

(defrule problem-no-manager
  (pddl-manager (node ?node))
  (pddl-instance (name production) (state ~LOADED&~ERROR))
  (not (no-manager))
  (time ?now&:(> ?now (+ ?*ASKED-AT* ?*LOADING*)))
  =>
  (assert (no-manager))
  (give-up (str-cat "no PDDL manager answers at '" ?node "' (servers of the scenario, planner.node of the agent)")))

(defrule problem-not-loaded
  "The PDDL manager answers that our domain or problem has an error: give up."
  (pddl-instance (name ?instance) (state ERROR) (error ?why))
  =>
  (give-up (str-cat "the PDDL manager cannot load " ?instance ": " ?why)))

(defrule problem-loaded
  "An instance is loaded: note this in a fact that does not change, as the fact of the instance does with each request."
  (pddl-instance (name ?instance&production|planning) (state LOADED))
  (not (loaded ?instance))
  =>
  (assert (loaded ?instance)))

(defrule problem-numbers
  "An instance is loaded: ask for the numbers of its problem file."
  (loaded ?instance)
  =>
  (assert (pddl-get-numeric-fluents (instance ?instance))))

(deffunction fluent (?instance ?name $?params)
  (assert (pddl-fluent-change (instance ?instance) (name ?name) (params ?params))))

(deffunction no-fluent (?instance ?name $?params)
  (assert (pddl-fluent-change (instance ?instance) (name ?name) (params ?params) (delete TRUE))))

(deffunction number (?instance ?name ?value $?params)
  (assert (pddl-numeric-fluent-change (instance ?instance) (name ?name) (params ?params) (value (float ?value)))))

(defrule problem-robot
  (robot (name ?robot))
  (loaded planning)
  (not (in-problem planning ?robot))
  =>
  (assert (in-problem planning ?robot))
  (assert (pddl-object-change (instance planning) (name (sym-cat ?robot)) (type robot))))

(deffunction type-of (?kind)
  (switch ?kind (case BS then base-station) (case CS then cap-station) (case RS then ring-station) (default delivery-station)))

(deffunction say-way-times (?instance ?machine)
  "Set the times to and from the machines that are in the problem, including this one."
  (do-for-all-facts ((?known in-problem)) (eq (nth$ 1 ?known:implied) ?instance)
    (bind ?other (nth$ 2 ?known:implied))
    (if (any-factp ((?m machine)) (eq ?m:name ?other))
     then
      (number ?instance way-time (way-time ?machine ?other) (pddl-name ?machine) (pddl-name ?other))
      (number ?instance way-time (way-time ?other ?machine) (pddl-name ?other) (pddl-name ?machine)))))

(defrule problem-machine
  "A machine was found: add it to the problem. It is empty, has its times to the others, and works unless it is out of order now."
  (machine (name ?machine) (kind ?kind&BS|CS|RS|DS) (state ?state))
  (loaded ?instance)
  (not (in-problem ?instance ?machine))
  =>
  (assert (in-problem ?instance ?machine))
  (bind ?name (pddl-name ?machine))
  (assert (pddl-object-change (instance ?instance) (name ?name) (type (type-of ?kind))))
  (if (not (member$ ?state (create$ DOWN BROKEN))) then (fluent ?instance working ?name))
  (fluent ?instance output-ready ?name)
  (number ?instance down-for 0 ?name)
  (fluent ?instance input-free ?name)
  (fluent ?instance output-free ?name)
  (if (eq ?kind CS) then (fluent ?instance shelf-stocked ?name))
  (if (eq ?kind RS) then (number ?instance payments 0 ?name) (number ?instance slide-room 3 ?name))
  (say-way-times ?instance ?machine))

(deffunction until-window-near (?begin)
  "s until the window of an order is near; never 0, for the end of a wait may not change what its start needs at the same time."
  (max 0.1 (- ?begin ?*WINDOW-LEAD* (game-time))))

(deffunction problem-works (?instance ?product ?works ?machines)
  "Add the steps of a product to the problem."
  (loop-for-count (?i 1 (length$ ?works))
    (bind ?step (sym-cat s (- ?i 1)))
    (fluent ?instance work-at ?product ?step (pddl-name (nth$ ?i ?machines)))
    (number ?instance price (price-of (nth$ ?i ?works)) ?product ?step)
    (if (< ?i (length$ ?works)) then (fluent ?instance next-step ?product ?step (sym-cat s ?i)))))

(defrule problem-order
  "An order is known, and its machines are all found: add it to the problem."
  (order (id ?id) (rings $?rings) (cap ?cap) (begin ?begin))
  (loaded ?instance)
  (not (in-problem ?instance ?id))
  (machine (kind BS) (name ?bs))
  (in-problem ?instance ?bs)
  (does (work ?cap) (machine ?cap-station))
  (in-problem ?instance ?cap-station)
  (does (work "DELIVER") (machine ?delivery))
  (in-problem ?instance ?delivery)
  (forall (order (id ?id) (rings $? ?ring $?))
          (does (work ?ring) (machine ?ring-station))
          (in-problem ?instance ?ring-station))
  =>
  (assert (in-problem ?instance ?id))
  (bind ?product (product-of ?id))
  (assert (pddl-object-change (instance ?instance) (name ?product) (type product)))
  (fluent ?instance not-begun ?product)
  (fluent ?instance at-step ?product s0)
  (number ?instance window-in (until-window-near ?begin) ?product)
  (problem-works ?instance ?product (works-for ?rings ?cap) (machines-for (works-for ?rings ?cap))))

; --- Machines that are out of order

(defglobal
  ?*DOWN-TIME* = 45.0     ; s, the mean of the league
  ?*LONGEST-DOWN* = 60.0  ; s
  ?*REPAIR-TIME* = 30.0)  ; s, of a broken machine

(deffunction change-working (?machine ?change)
  (bind ?name (pddl-name ?machine))
  (if ?change then (fluent production working ?name) else (no-fluent production working ?name))
  (look-again))

(deffunction out-of-order-for (?machine ?since ?mean)
  "s that are still expected: as foreseen; else until the league's mean is over; a machine that is down for longer than can be is not
   counted on any more."
  (bind ?end (known-end ?machine (game-time)))
  (if ?end then (return (max 1.0 (- ?end (game-time)))))
  (bind ?already (- (game-time) ?since))
  (max 5.0 (- (if (> ?already ?*LONGEST-DOWN*) then (- ?*GAME* ?since) else ?mean) ?already)))

(defrule problem-out-of-order
  "A machine is down or broken: note since when and for how long on average, and ask for a new plan."
  (in-problem production ?machine)
  (machine (name ?machine) (state ?state&DOWN|BROKEN))
  (not (out-of-order ?machine ? ?))
  =>
  (assert (out-of-order ?machine (game-time) (if (eq ?state DOWN) then ?*DOWN-TIME* else ?*REPAIR-TIME*))
          (replan (reason (str-cat ?machine (if (eq ?state DOWN) then " is down" else " has broken down")))))
  (change-working ?machine FALSE))

(defrule problem-still-out-of-order
  "A machine is out of order for longer than it can be down: its steps have to wait, and a new plan puts other orders first."
  (out-of-order ?machine ?since ?)
  (not (long-out-of-order ?machine))
  (game (begin ?zero))
  (time ?now&:(> ?now (+ ?zero ?since ?*LONGEST-DOWN*)))
  =>
  (assert (long-out-of-order ?machine) (replan (reason (str-cat ?machine " is still out of order")))))

(defrule problem-long-no-more
  ?long <- (long-out-of-order ?machine)
  (not (out-of-order ?machine ? ?))
  =>
  (retract ?long)
  (assert (replan (reason (str-cat ?machine " works again")))))

(defrule problem-in-order-again
  ?out <- (out-of-order ?machine ? ?)
  (machine (name ?machine) (state ~DOWN&~BROKEN))
  =>
  (retract ?out)
  (skip-no-more)
  (change-working ?machine TRUE))

; --- When points are lost

(defrule problem-begins
  "The instance `planning` is loaded: moments of the problem count from now."
  (loaded planning)
  (not (planning-since ?))
  (time ?now)
  =>
  (assert (planning-since ?now)))

(defglobal ?*LAST-MOMENT* = 3590)  ; of planning_problem.pddl

(deffunction moment-at (?time)
  "The last moment of the problem that is not after this time of the game; never: the problem does not reach that far."
  (do-for-fact ((?g game) (?since planning-since)) TRUE
    (bind ?moment (* 10 (div (+ ?g:begin (- ?time (nth$ 1 ?since:implied))) 10)))
    (if (<= ?moment ?*LAST-MOMENT*) then (return (sym-cat t ?moment))))
  never)

(deffunction lose-at (?product ?moment ?points)
  (fluent planning deadline ?product ?moment)
  (number planning loss ?points ?product ?moment))

(deffunction forget-deadlines (?product)
  (do-for-all-facts ((?f pddl-fluent)) (and (eq ?f:instance planning) (eq ?f:name deadline) (eq (nth$ 1 ?f:params) ?product))
    (no-fluent planning deadline ?f:params)))

(deffunction say-losses (?product ?complexity ?rings ?bonus ?end ?window)
  "Set the points lost at the end of the product's window, at each quarter of it later, at the end of the game, and without a delivery."
  (bind ?all (points-of ?complexity ?rings ?bonus 0 ?window))
  (bind ?loss 0.0)
  (loop-for-count (?quarter 0 3)
    (bind ?moment (+ ?end (* ?quarter (/ ?window 4))))
    (if (< ?moment ?*GAME*)
     then
      (lose-at ?product (moment-at ?moment) ?loss)
      (bind ?loss (- ?all (points-of ?complexity ?rings ?bonus (+ (- ?moment ?end) 1) ?window)))))
  (bind ?game-end (moment-at ?*GAME*))
  (lose-at ?product ?game-end ?loss)
  (if (neq ?game-end never) then (lose-at ?product never ?all)))

(defrule problem-deadlines
  "The later a delivery, the fewer points; after the end of the game there are none. A pause moves the moments, and who is second
   with a competitive order loses less."
  (planning-since ?)
  (game (begin ?zero))
  (in-problem planning ?id)
  (order (id ?id) (complexity ?complexity) (rings $?rings) (bonus ?bonus) (begin ?begin) (end ?end))
  (not (deadlines ?id ?zero ?bonus))
  =>
  (assert (deadlines ?id ?zero ?bonus))
  (forget-deadlines (product-of ?id))
  (say-losses (product-of ?id) ?complexity ?rings ?bonus ?end (- ?end ?begin)))

(defrule problem-price
  "The league tells the price of a ring later: set it in the problem."
  (does (work ?ring) (price ?price))
  (order (id ?id) (rings $?before ?ring $?))
  (pddl-numeric-fluent (instance ?instance) (name price) (params =(product-of ?id) =(sym-cat s (length$ ?before))) (value ?value&:(<> ?value ?price)))
  (not (pddl-numeric-fluent-change (instance ?instance) (name price)))
  =>
  (do-for-all-facts ((?d deadlines)) (= (nth$ 1 ?d:implied) ?id) (retract ?d))
  (number ?instance price ?price (product-of ?id) (sym-cat s (length$ ?before))))
