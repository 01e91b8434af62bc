; strategy.dispatch: partial-order. A step waits for those before it that use its product or the same side of a machine, until they
; have begun.

(defrule dispatch-partial-order
  (declare (salience 20))
  (logical
    (candidate ?id)
    (not (and (waits-for (step ?id) (for ?before))
              (step (id ?before) (state OPEN|CHECKING|BLOCKED|APPROACHING|FAILED)))))
  =>
  (assert (allowed ?id)))

(deffunction why-held-back (?step)
  "The reason why the strategy holds a step back; FALSE if it does not."
  (why-linked ?step))
