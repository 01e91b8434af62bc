; strategy.dispatch: stn. The whole temporal network of the plan: a step waits as in the partial order, and until the robot that
; the plan gives it is done with its step before.

(defrule dispatch-stn
  (declare (salience 20))
  (logical
    (candidate ?id)
    (not (and (waits-for (step ?id) (for ?before))
              (step (id ?before) (state OPEN|CHECKING|BLOCKED|APPROACHING|FAILED))))
    (not (and (follows (step ?id) (after ?last))
              (step (id ?last) (state ~DONE)))))
  =>
  (assert (allowed ?id)))

(deffunction why-held-back (?step)
  "The reason why the strategy holds a step back; FALSE if it does not."
  (do-for-all-facts ((?f follows)) (eq ?f:step (fact-slot-value ?step id))
    (bind ?first (step-that-is-not ?f:after DONE))
    (if ?first then (return (str-cat "the plan gives its robot " ?first " first"))))
  (why-linked ?step))
