; Which orders the agent works for: it makes plans for several sets of orders at once, and uses the most valuable plan.

(deffunction best-of (?orders)
  "Among these orders, the one that earns most for each job if it begins now; 0 if none is worth it."
  (bind ?best 0)
  (bind ?most 0.0)
  (foreach ?id ?orders
    (do-for-fact ((?o order)) (= ?o:id ?id)
      (bind ?worth (* (chance-of (transports-of ?o:rings)) (worth ?o:complexity ?o:rings ?o:bonus ?o:begin ?o:end (game-time))))
      (if (> ?worth ?most) then (bind ?most ?worth) (bind ?best ?id))))
  ?best)

(deffunction orders-in (?state)
  "The orders of that state that are in the problem."
  (bind ?ids (create$))
  (do-for-all-facts ((?o order)) (and (eq ?o:state ?state) (any-factp ((?k in-problem)) (eq ?k:implied (create$ planning ?o:id))))
    (bind ?ids (create$ ?ids ?o:id)))
  ?ids)

(deffunction is-true (?name $?params)
  "Whether a fluent is true in the present world."
  (any-factp ((?f pddl-fluent)) (and (eq ?f:instance production) (eq ?f:name ?name) (eq ?f:params ?params))))

(deffunction gets-cap (?station)
  "Whether a cap is in the station, or a carrier is inside or on its way."
  (or (is-true cap-loaded ?station)
      (is-true carrier-at-input ?station)
      (any-factp ((?s step)) (and (eq ?s:state RUNNING) (member$ ?s:action (create$ fetch-carrier retrieve-cap))
                                  (eq ?s:params (create$ ?station))))))

(deffunction without-cap (?order)
  "Whether the cap of an order cannot be had any more."
  (any-factp ((?o order) (?d does) (?b bare-shelf))
    (and (= ?o:id ?order) (eq ?d:work ?o:cap) (eq ?b:station (pddl-name ?d:machine)) (not (gets-cap ?b:station)))))

(deffunction has-cap-on (?product)
  "Whether the next work of a product is its delivery."
  (any-factp ((?at pddl-fluent) (?work pddl-fluent))
    (and (eq ?at:instance production) (eq ?at:name at-step) (eq (nth$ 1 ?at:params) ?product)
         (eq ?work:instance production) (eq ?work:name work-at) (eq (subseq$ ?work:params 1 2) ?at:params)
         (eq (sub-string 1 1 (nth$ 3 ?work:params)) "d"))))

(deffunction is-hopeless (?order)
  "Whether the product of an order needs a cap that cannot be had any more."
  (and (without-cap ?order) (not (has-cap-on (product-of ?order)))))

(deffunction lost-machine (?order)
  "A machine that the order needs and that is out of order for long; FALSE if none is."
  (do-for-fact ((?o order) (?bs machine)) (and (= ?o:id ?order) (eq ?bs:kind BS))
    (foreach ?m (create$ ?bs:name (machines-for (works-for ?o:rings ?o:cap)))
      (if (any-factp ((?l long-out-of-order)) (eq ?l:implied (create$ ?m))) then (return ?m))))
  FALSE)

(deffunction open-orders ()
  "The open orders that we could work for: no known reason rules out a plan for them."
  (bind ?ids (create$))
  (foreach ?id (orders-in OPEN)
    (if (not (or (any-factp ((?s skipped)) (= ?s:order ?id)) (without-cap ?id) (lost-machine ?id))) then (bind ?ids (create$ ?ids ?id))))
  ?ids)

(deffunction propose (?number $?orders)
  (assert (alternative (name (sym-cat alternative- ?number)) (orders ?orders))))

(deffunction stuck (?product)
  "Whether a machine that the product still needs, or that works on it, is out of order for long."
  (do-for-all-facts ((?l long-out-of-order)) TRUE
    (bind ?m (pddl-name (nth$ 1 ?l:implied)))
    (if (or (any-factp ((?at pddl-fluent) (?work pddl-fluent))
              (and (eq ?at:instance production) (eq ?at:name at-step) (eq (nth$ 1 ?at:params) ?product)
                   (eq ?work:instance production) (eq ?work:name work-at) (eq (nth$ 1 ?work:params) ?product)
                   (eq (nth$ 3 ?work:params) ?m) (>= (str-compare (nth$ 2 ?work:params) (nth$ 2 ?at:params)) 0)))
            (any-factp ((?s step))
              (and (eq ?s:state RUNNING) (eq ?s:worker MACHINE) (eq (subseq$ ?s:params 1 2) (create$ ?product ?m)))))
     then (return TRUE)))
  FALSE)

(deffunction rests (?product)
  "Whether no robot has fetched the product's base yet, or the product is stuck."
  (or (is-true not-begun ?product) (stuck ?product)))

(deffunction can-be-put-off (?ours)
  "The order that earns least among those whose product rests; 0 if no product rests."
  (bind ?last 0)
  (foreach ?id ?ours
    (if (rests (product-of ?id))
     then (if (or (= ?last 0) (= (best-of (create$ ?last ?id)) ?last)) then (bind ?last ?id))))
  ?last)

(deffunction has-no-time (?order)
  "Whether the product of an order has not begun, or must begin again, and would not be ready before the game ends."
  (do-for-fact ((?o order)) (= ?o:id ?order)
    (return (and (is-true not-begun (product-of ?order)) (> (+ (game-time) (time-to-make ?o:rings)) ?*GAME*))))
  FALSE)

(deffunction products-at-once ()
  "How many products we make at once: one more while a robot has nothing to do."
  (if (any-factp ((?r robot-to-spare)) TRUE) then (+ ?*PRODUCTS* 1) else ?*PRODUCTS*))

(deffunction propose-alternatives ()
  "Propose our present orders alone, and together with each of the best open orders. If there is no room for one, it replaces one that can be put off."
  (bind ?ours (create$))
  (foreach ?id (orders-in STARTED) (if (not (or (is-hopeless ?id) (has-no-time ?id))) then (bind ?ours (create$ ?ours ?id))))
  (if (neq ?ours (create$)) then (propose 0 ?ours))
  (if (>= (length$ ?ours) (products-at-once)) then (bind ?ours (delete-member$ ?ours (can-be-put-off ?ours))))
  (if (>= (length$ ?ours) (products-at-once)) then (return))
  (bind ?open (open-orders))
  (loop-for-count (?i 1 ?*ALTERNATIVES*)
    (bind ?id (best-of ?open))
    (if (= ?id 0) then (return))
    (bind ?open (delete-member$ ?open ?id))
    (propose ?i ?ours ?id)))

; --- What a plan is worth

(deffunction worker-of (?action)
  (switch ?action
    (case retrieve-cap then MACHINE) (case mount-ring then MACHINE) (case mount-cap then MACHINE) (case deliver then MACHINE)
    (case wait-for-window then AGENT) (case wait-until-it-works then AGENT)
    (default ROBOT)))

(deffunction sides (?input ?output)
  "The input of one machine and the output of another one, or of the same one; none: no side."
  (create$ (if (eq ?input none) then (create$) else (sym-cat input- ?input))
           (if (eq ?output none) then (create$) else (sym-cat output- ?output))))

(deffunction objects-of (?name ?params)
  "The product and the sides of machines that a step uses. While a product lies at the output of a machine, the next one can come
   to its input. Any number of steps can use the base station, or bring payments. Only its delivery waits for the window of a product."
  (bind ?first (nth$ 1 ?params))
  (bind ?second (nth$ 2 ?params))
  (bind ?third (nth$ 3 ?params))
  (switch ?name
    (case bring-base then (create$ ?first (sides ?third none)))
    (case transport then (create$ ?first (sides ?third ?second)))
    (case bring-to-delivery then (create$ (sym-cat window- ?first) ?first (sides ?third ?second)))
    (case deliver then (create$ ?first (sides ?second none)))
    (case fetch-carrier then (sides ?first none))
    (case retrieve-cap then (sides ?first ?first))
    (case pay-with-bare-base then (sides none ?first))
    (case discard-bare-base then (sides ?second ?first))
    (case pay-with-new-base then (create$))
    (case wait-for-window then (create$ (sym-cat window- ?first)))
    (case wait-until-it-works then (sides ?first ?first))
    (default (create$ ?first (sides ?second ?second)))))  ; mount-ring, mount-cap

(deffunction points-at (?product ?at)
  "The points for the delivery of a product at this time of the game."
  (if (> ?at ?*GAME*) then (return 0.0))
  (do-for-fact ((?o order)) (eq (product-of ?o:id) ?product)
    (return (points-of ?o:complexity ?o:rings ?o:bonus (- ?at ?o:end) (- ?o:end ?o:begin))))
  0.0)

(deffunction params-of (?action)
  "The parameters of an action of a plan, without the robot or the deadline that the planner has chosen."
  (bind ?params (create$))
  (foreach ?p (fact-slot-value ?action params) (bind ?params (create$ ?params (sym-cat ?p))))
  (if (or (eq (worker-of (fact-slot-value ?action name)) ROBOT) (eq (fact-slot-value ?action name) deliver))
   then (subseq$ ?params 1 (- (length$ ?params) 1))
   else ?params))

(deffunction robot-of (?action)
  "The robot that the planner has chosen for an action of a plan."
  (bind ?params (fact-slot-value ?action params))
  (if (eq (worker-of (fact-slot-value ?action name)) ROBOT) then (sym-cat (nth$ (length$ ?params) ?params)) else none))

(deffunction transports-in (?plan ?product)
  "How often a robot brings the product to its next machine in the plan."
  (length$ (find-all-facts ((?a pddl-action))
    (and (eq ?a:plan ?plan) (member$ ?a:name (create$ transport bring-to-delivery)) (eq (nth$ 1 (params-of ?a)) ?product)))))

(deffunction expected-points (?plan ?delivery)
  "The points for the delivery of a plan, times the chance that its product is not lost before."
  (bind ?product (nth$ 1 (params-of ?delivery)))
  (* (chance-of (transports-in ?plan ?product))
     (points-at ?product (+ (game-time) (fact-slot-value ?delivery planned-start-time)))))

(deffunction weigh (?plan)
  "The expected points of a plan, and the work of robots that it takes."
  (bind ?points 0.0)
  (bind ?work 0.0)
  (do-for-all-facts ((?a pddl-action)) (eq ?a:plan ?plan)
    (if (eq (worker-of ?a:name) ROBOT) then (bind ?work (+ ?work ?a:planned-duration)))
    (if (eq ?a:name deliver) then (bind ?points (+ ?points (expected-points ?plan ?a)))))
  (create$ ?points ?work))
