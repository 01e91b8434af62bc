; Which orders are worked for: plans are made for several sets of them at once, and the most valuable plan is taken.

(deffunction game-time ()
  (do-for-fact ((?g game) (?t time)) TRUE (return (- (nth$ 1 ?t:implied) ?g:begin)))
  0.0)

(deffunction best-of (?orders)
  "The order of these that earns most for each job, if it is begun now; 0: none is worth it."
  (bind ?best 0)
  (bind ?most 0.0)
  (foreach ?id ?orders
    (do-for-fact ((?o order)) (= ?o:id ?id)
      (bind ?worth (worth ?o:complexity ?o:rings ?o:competitive ?o:begin ?o:end (game-time)))
      (if (> ?worth ?most) then (bind ?most ?worth) (bind ?best ?id))))
  ?best)

(deffunction orders-in (?state)
  "Orders of that state that are in the problem."
  (bind ?ids (create$))
  (do-for-all-facts ((?o order)) (and (eq ?o:state ?state) (any-factp ((?k in-problem)) (eq ?k:implied (create$ planning ?o:id))))
    (bind ?ids (create$ ?ids ?o:id)))
  ?ids)

(deffunction propose (?number $?orders)
  (assert (alternative (name (sym-cat alternative- ?number)) (orders ?orders))))

(deffunction propose-alternatives ()
  "What we work for, and that with each of the best open orders."
  (bind ?ours (orders-in STARTED))
  (if (neq ?ours (create$)) then (propose 0 ?ours))
  (if (>= (length$ ?ours) ?*PRODUCTS*) then (return))
  (bind ?open (orders-in OPEN))
  (loop-for-count (?i 1 ?*ALTERNATIVES*)
    (bind ?id (best-of ?open))
    (if (= ?id 0) then (return))
    (bind ?open (delete-member$ ?open ?id))
    (propose ?i ?ours ?id)))

; --- What a plan is worth, if as many robots carry it out as there are

(deffunction available (?times ?object)
  "When the last step that uses the object has ended; times are pairs."
  (bind ?at (member$ ?object ?times))
  (if ?at then (nth$ (+ ?at 1) ?times) else 0.0))

(deffunction keep (?times ?object ?end)
  (bind ?at (member$ ?object ?times))
  (if ?at then (replace$ ?times (+ ?at 1) (+ ?at 1) ?end) else (create$ ?times ?object ?end)))

(deffunction earlier (?a ?b)
  "For sort: whether step a begins after step b."
  (> (fact-slot-value ?a planned-start-time) (fact-slot-value ?b planned-start-time)))

(deffunction worker-of (?action)
  (switch ?action
    (case retrieve-cap then MACHINE) (case mount-ring then MACHINE) (case mount-cap then MACHINE) (case deliver then MACHINE)
    (case wait-for-window then AGENT)
    (default ROBOT)))

(deffunction objects-of (?name ?params)
  "The product and the machines that a step uses; any number of steps can use the base station, or bring payments. Only its
   delivery waits for the window of a product."
  (if (eq ?name wait-for-window) then (return (create$ (sym-cat window- (nth$ 1 ?params)))))
  (if (eq ?name pay-with-new-base) then (return (create$)))
  (if (eq ?name pay-with-bare-base) then (return (create$ (sym-cat (nth$ 1 ?params)))))
  (bind ?objects (if (eq ?name bring-to-delivery) then (create$ (sym-cat window- (nth$ 1 ?params))) else (create$)))
  (foreach ?p ?params
    (if (not (member$ (sym-cat ?p) (create$ bs s0 s1 s2 s3 s4))) then (bind ?objects (create$ ?objects (sym-cat ?p)))))
  ?objects)

(deffunction points-at (?product ?at)
  "What the delivery of a product earns at this time of the game."
  (if (> ?at ?*GAME*) then (return 0.0))
  (do-for-fact ((?o order)) (eq (product-of ?o:id) ?product)
    (return (points-of ?o:complexity ?o:rings ?o:competitive (- ?at ?o:end) (- ?o:end ?o:begin))))
  0.0)

(deffunction weigh (?plan)
  "Points and robots' work of a plan. Its steps in their order: each begins when the objects that it uses, and a robot if it
   needs one, are done with what came before."
  (bind ?now (game-time))
  (bind ?free (create$))
  (do-for-all-facts ((?r robot)) (neq ?r:state OFF-FIELD) (bind ?free (create$ ?free 0.0)))
  (bind ?times (create$))
  (bind ?points 0.0)
  (bind ?work 0.0)
  (foreach ?a (sort earlier (find-all-facts ((?a pddl-action)) (eq ?a:plan ?plan)))
    (bind ?name (fact-slot-value ?a name))
    (bind ?objects (objects-of ?name (fact-slot-value ?a params)))
    (bind ?duration (fact-slot-value ?a planned-duration))
    (bind ?begin 0.0)
    (foreach ?o ?objects (bind ?begin (max ?begin (available ?times ?o))))
    (if (and (eq (worker-of ?name) ROBOT) (> (length$ ?free) 0))
     then
      (bind ?free (sort > ?free))
      (bind ?begin (max ?begin (nth$ 1 ?free)))
      (bind ?free (replace$ ?free 1 1 (+ ?begin ?duration)))
      (bind ?work (+ ?work ?duration)))
    (foreach ?o ?objects (bind ?times (keep ?times ?o (+ ?begin ?duration))))
    (if (eq ?name deliver) then (bind ?points (+ ?points (points-at (nth$ 1 ?objects) (+ ?now ?begin))))))
  (create$ ?points ?work))
