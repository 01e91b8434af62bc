; The planning problem: objects and facts for all that the league tells of.

(defglobal
  ?*HANDLING* = 34.0      ; s that a robot needs for a transport besides the way from place to place: the way to the piece, pick, place
  ?*SPEED* = 0.4          ; m/s, turns and detours included
  ?*WINDOW-LEAD* = 45.0)  ; so long before its window a product is fetched for its delivery, s

(defrule problem-load
  "Both instances, and the coarse actions alone, for their names; by the folder of this package."
  (pddl-manager)
  (not (pddl-instance))
  =>
  (bind ?folder (str-cat (ament-index-get-package-share-directory "rcll_planning_agent") "/pddl"))
  (assert (pddl-instance (name production) (domain "production.pddl") (problem "problem.pddl") (directory ?folder))
          (pddl-instance (name planning) (domain "production.pddl") (problem "problem.pddl") (directory ?folder))
          (pddl-instance (name coarse) (domain "planning.pddl") (directory ?folder))
          (pddl-action-names (instance coarse))))

(defrule problem-numbers
  "Numbers of the problem file are known from the beginning."
  (pddl-instance (name ?instance&~coarse) (state LOADED))
  (not (pddl-get-numeric-fluents (instance ?instance)))
  =>
  (assert (pddl-get-numeric-fluents (instance ?instance))))

(deffunction fluent (?instance ?name $?params)
  (assert (pddl-fluent-change (instance ?instance) (name ?name) (params ?params))))

(deffunction no-fluent (?instance ?name $?params)
  (assert (pddl-fluent-change (instance ?instance) (name ?name) (params ?params) (delete TRUE))))

(deffunction number (?instance ?name ?value $?params)
  (assert (pddl-numeric-fluent-change (instance ?instance) (name ?name) (params ?params) (value (float ?value)))))

(defrule problem-machine
  "A machine is found: it is empty, and so far from the others."
  (machine (name ?machine) (kind ?kind&BS|CS|RS|DS) (x ?x) (y ?y))
  (pddl-instance (name ?instance&~coarse) (state LOADED))
  (not (in-problem ?instance ?machine))
  =>
  (assert (in-problem ?instance ?machine))
  (bind ?name (pddl-name ?machine))
  (bind ?type (switch ?kind (case BS then base-station) (case CS then cap-station) (case RS then ring-station) (default delivery-station)))
  (assert (pddl-object-change (instance ?instance) (name ?name) (type ?type)))
  (fluent ?instance input-free ?name)
  (fluent ?instance output-free ?name)
  (if (eq ?kind CS) then (number ?instance shelf-time ?*HANDLING* ?name))
  (if (eq ?kind RS) then (number ?instance payments 0 ?name) (number ?instance slide-room 3 ?name))
  (do-for-all-facts ((?m machine) (?known in-problem))
      (and (eq ?known:implied (create$ ?instance ?m:name)) (neq ?m:name ?machine))
    (bind ?other (pddl-name ?m:name))
    (bind ?time (+ ?*HANDLING* (/ (distance ?x ?y ?m:x ?m:y) ?*SPEED*)))
    (number ?instance transport-time ?time ?name ?other)
    (number ?instance transport-time ?time ?other ?name))
  (number ?instance transport-time ?*HANDLING* ?name ?name))

(deffunction problem-works (?instance ?product ?works ?machines)
  "The steps of a product."
  (loop-for-count (?i 1 (length$ ?works))
    (bind ?step (sym-cat s (- ?i 1)))
    (fluent ?instance work-at ?product ?step (pddl-name (nth$ ?i ?machines)))
    (number ?instance price (price-of (nth$ ?i ?works)) ?product ?step)
    (if (< ?i (length$ ?works)) then (fluent ?instance next-step ?product ?step (sym-cat s ?i)))))

(defrule problem-order
  "An order whose machines are all found."
  (order (id ?id) (rings $?rings) (cap ?cap))
  (pddl-instance (name ?instance&~coarse) (state LOADED))
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
  (number ?instance window-in 0 ?product)
  (problem-works ?instance ?product (works-for ?rings ?cap) (machines-for (works-for ?rings ?cap))))

(defrule problem-price
  "The league tells a price later."
  (does (work ?ring) (price ?price))
  (order (id ?id) (rings $?before ?ring $?))
  (pddl-numeric-fluent (instance ?instance) (name price) (params =(product-of ?id) =(sym-cat s (length$ ?before))) (value ?value&:(<> ?value ?price)))
  (not (pddl-numeric-fluent-change (instance ?instance) (name price)))
  =>
  (number ?instance price ?price (product-of ?id) (sym-cat s (length$ ?before))))
