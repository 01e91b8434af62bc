; Which orders can be begun, which of them is the best, and how one begins.

(deffunction has-cap (?station)
  "Whether a cap station has its cap, or a robot is there to take away the bare base."
  (or (any-factp ((?s cap-station)) (and (eq ?s:name ?station) (eq ?s:phase LOADED)))
      (any-factp ((?j job)) (and (eq ?j:purpose CLEAR) (eq ?j:station ?station)
                                 (or (eq ?j:step GO-FETCH) (eq ?j:step FETCH))))))

(deffunction is-left (?cap)
  "Whether a cap is left for one more product. Each product uses up a cap of a shelf that nobody fills again."
  (do-for-fact ((?s cap-station)) (and (eq ?s:cap ?cap) (has-no-way ?s:name))
    (return (< (length$ (find-all-facts ((?p product)) (member$ ?cap ?p:todo)))
               (+ (carriers-left ?s:name) (if (eq ?s:phase EMPTY) then 0 else 1)))))
  TRUE)

(deffunction can-begin (?via)
  "Whether the first of these machines could take a base now, and no product is about to go there."
  (bind ?first (nth$ 1 ?via))
  (not (or (eq ?via (create$))
           (any-factp ((?p product)) (member$ ?first (create$ ?p:keeps (first$ ?p:via))))
           (and (any-factp ((?s cap-station)) (eq ?s:name ?first)) (not (has-cap ?first))))))

(deffunction best-order (?time)
  "Among the open orders that can begin, the one with the highest worth at this time of the game; 0 if none can."
  (bind ?best 0)
  (bind ?most 0.0)
  (do-for-all-facts ((?o order)) (and (eq ?o:state OPEN) (is-left ?o:cap) (can-begin (machines-for (works-for ?o:rings ?o:cap))))
    (bind ?worth (worth ?o:complexity ?o:rings ?o:bonus ?o:begin ?o:end ?time))
    (if (> ?worth ?most) then (bind ?most ?worth) (bind ?best ?o:id)))
  ?best)

(deffacts orders
  (next-choice 0.0))

(defrule order-choose-none
  ?chosen <- (chosen 0)
  =>
  (retract ?chosen))

(defrule order-begin
  "An order was chosen: its product begins at the base station."
  ?chosen <- (chosen ?id)
  ?order <- (order (id ?id) (rings $?rings) (cap ?cap))
  (machine (name ?bs) (kind BS))
  =>
  (retract ?chosen)
  (modify ?order (state STARTED))
  (bind ?works (works-for ?rings ?cap))
  (assert (product (order ?id) (todo ?works) (via (machines-for ?works)) (at ?bs) (keeps ?bs)))
  (count-payments))
