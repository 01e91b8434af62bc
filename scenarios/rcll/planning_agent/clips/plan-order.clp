; The order of the steps in a plan: groups, steps that use the same product, machine or robot, and which step is looked at first.

(deffunction later-step (?a ?b)
  "Order of steps for sort."
  (> (fact-slot-value ?a begin) (fact-slot-value ?b begin)))

(deffunction group-steps ()
  "Put steps that begin at the same time into a group."
  (bind ?group 0)
  (bind ?last -1.0)
  (foreach ?s (sort later-step (find-all-facts ((?s step)) (eq ?s:state OPEN)))
    (bind ?begin (fact-slot-value ?s begin))
    (if (> (- ?begin ?last) 0.1) then (bind ?group (+ ?group 1)))
    (bind ?last ?begin)
    (modify ?s (group ?group))))

(deffunction last-user (?users ?object)
  "The last step that used the object, from pairs of an object and a step."
  (bind ?at (member$ ?object ?users))
  (if ?at then (nth$ (+ ?at 1) ?users) else none))

(deffunction with-user (?users ?object ?step)
  (bind ?at (member$ ?object ?users))
  (if ?at then (replace$ ?users (+ ?at 1) (+ ?at 1) ?step) else (create$ ?users ?object ?step)))

(deffunction order-steps ()
  "Let each step wait for the last one before it that uses the same product or side of a machine, and follow the last one of its robot."
  (bind ?users (create$))
  (foreach ?s (sort later-step (find-all-facts ((?s step)) (eq ?s:state OPEN)))
    (bind ?id (fact-slot-value ?s id))
    (foreach ?object (objects-of (fact-slot-value ?s action) (fact-slot-value ?s params))
      (bind ?last (last-user ?users ?object))
      (if (not (member$ ?last (create$ none ?id))) then (assert (waits-for (step ?id) (for ?last))))
      (bind ?users (with-user ?users ?object ?id)))
    (bind ?robot (fact-slot-value ?s robot))
    (if (neq ?robot none)
     then
      (bind ?last (last-user ?users ?robot))
      (if (neq ?last none) then (assert (follows (step ?id) (after ?last))))
      (bind ?users (with-user ?users ?robot ?id)))))

(deffunction window-of (?product)
  "The end of the window of a product's order, s from now."
  (do-for-fact ((?o order)) (eq (product-of ?o:id) ?product) (return (- ?o:end (game-time))))
  10000.0)

(deffunction rank-of (?step)
  "The rank of a step; the least goes first. Order `plan`: as in the plan. Order `delivery`: steps for the next delivery of the plan.
   Order `slack`: steps that must begin first so that no product is late. Steps for no delivery go last, payments as in the plan."
  (bind ?begin (fact-slot-value ?step begin))
  (bind ?rank (if (member$ (fact-slot-value ?step action) (create$ pay-with-new-base pay-with-bare-base)) then ?begin else 10000.0))
  (if (eq (fact-slot-value ?step action) deliver)
   then (bind ?rank (switch ?*ORDER* (case "slack" then (window-of (nth$ 1 (fact-slot-value ?step params))))
                                     (case "delivery" then (fact-slot-value ?step end))
                                     (default ?begin))))
  (bind ?id (fact-slot-value ?step id))
  (do-for-all-facts ((?w waits-for)) (eq ?w:for ?id)
    (do-for-fact ((?s step)) (eq ?s:id ?w:step) (bind ?rank (min ?rank ?s:rank))))
  (switch ?*ORDER*
    (case "slack" then (- ?rank (- (fact-slot-value ?step end) ?begin)))
    (case "delivery" then (- ?rank 0.001))
    (default (if (>= ?rank 10000.0) then (+ ?rank ?begin) else ?begin))))

(deffunction rank-steps ()
  "Rank the last steps of the plan first, because a step gets its rank from those that wait for it."
  (bind ?steps (sort later-step (find-all-facts ((?s step)) (eq ?s:state OPEN))))
  (while (> (length$ ?steps) 0)
    (bind ?step (nth$ (length$ ?steps) ?steps))
    (bind ?steps (delete$ ?steps (length$ ?steps) (length$ ?steps)))
    (modify ?step (rank (rank-of ?step)))))

; --- Why a step may not begin yet

(deffunction source-of (?action ?params)
  "The machine or spot where a robot fetches the piece of a step."
  (nth$ (if (member$ ?action (create$ bring-base transport bring-to-delivery)) then 2 else 1) ?params))

(deffunction step-text (?step)
  (str-cat (fact-slot-value ?step action) " " (implode$ (fact-slot-value ?step params))))

(deffunction step-that-is-not (?id $?states)
  "The text of that step; FALSE if it does not exist or is in one of these states."
  (do-for-fact ((?s step)) (eq ?s:id ?id) (return (if (member$ ?s:state ?states) then FALSE else (step-text ?s))))
  FALSE)

(deffunction why-linked (?step)
  "The other step that must use the product, or a side of a machine, first, as a reason; FALSE if there is none."
  (do-for-all-facts ((?w waits-for)) (eq ?w:step (fact-slot-value ?step id))
    (bind ?first (step-that-is-not ?w:for RUNNING DONE))
    (if ?first then (return (str-cat ?first " uses its product or machine first"))))
  FALSE)
