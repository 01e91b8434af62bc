; Which order is begun next: the one that earns most for each robot's job that it costs.

(deffunction choose-order (?time)
  (bind ?best (best-order ?time))
  (do-for-fact ((?o order)) (= ?o:id ?best)
    (decide (str-cat "begin order " ?best)
            (format nil "%.1f points for each job of a robot" (worth ?o:complexity ?o:rings ?o:bonus ?o:begin ?o:end ?time))))
  (assert (chosen ?best)))

(defrule order-choose
  "Once a second, if there are fewer products than robots: have the best order made."
  ?choice <- (next-choice ?at)
  (game (phase PRODUCTION) (begin ?zero))
  (team (size ?robots))
  (time ?now&:(>= ?now ?at))
  =>
  (retract ?choice)
  (assert (next-choice (+ ?now 1.0)))
  (if (< (length$ (find-all-facts ((?p product)) TRUE)) ?robots) then (choose-order (- ?now ?zero))))
