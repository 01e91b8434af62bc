; Which order begins next: the one that earns most points for each job of a robot that it needs.

(deffunction choose-order (?time)
  (bind ?best (best-order ?time))
  (do-for-fact ((?o order)) (= ?o:id ?best)
    (decide (str-cat "begin order " ?best)
            (format nil "%.1f points for each job of a robot" (worth ?o:complexity ?o:rings ?o:bonus ?o:begin ?o:end ?time))))
  (assert (chosen ?best)))

(defrule order-choose
  "Once a second, if the agent makes fewer products than it has robots: choose the best order."
  ?choice <- (next-choice ?at)
  (game (phase PRODUCTION) (begin ?zero))
  (team (size ?robots))
  (time ?now&:(>= ?now ?at))
  =>
  (retract ?choice)
  (assert (next-choice (+ ?now 1.0)))
  (if (< (length$ (find-all-facts ((?p product)) TRUE)) ?robots) then (choose-order (- ?now ?zero))))
