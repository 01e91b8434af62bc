; If an order becomes worthless, its half-built product is used for another order that begins in the same way.

(deffunction rings-done (?step)
  "The number of rings on a product whose next step is s0, s1, ..."
  (string-to-field (sub-string 2 2 ?step)))

(deffunction rings-left (?rings ?done)
  (subseq$ ?rings (+ ?done 1) (length$ ?rings)))

(deffunction same-beginning (?done ?rings ?others)
  "Whether both orders have these rings in common, and no cap is on the product."
  (and (>= (length$ ?rings) ?done) (eq (subseq$ ?rings 1 ?done) (subseq$ ?others 1 ?done))))

(deffunction is-worthless (?left ?begin ?end)
  "Whether no time is left for the product, or it will be so late that it loses all points that lateness can cost."
  (bind ?ready (+ (game-time) (time-to-make ?left)))
  (or (> ?ready ?*GAME*) (= (late-share (- ?ready ?end) (- ?end ?begin)) 0.75)))

(deffunction is-in-time (?left ?end)
  (<= (+ (game-time) (time-to-make ?left)) (min ?end ?*GAME*)))

(deffunction exchange (?product ?other ?machine ?step)
  "Exchange two products in the world: the other one, which has not begun, takes over the facts of this one."
  (no-fluent production at-output ?product ?machine)
  (no-fluent production at-step ?product ?step)
  (no-fluent production not-begun ?other)
  (no-fluent production at-step ?other s0)
  (fluent production at-output ?other ?machine)
  (fluent production at-step ?other ?step)
  (fluent production not-begun ?product)
  (fluent production at-step ?product s0))

(defrule exchange-order
  "A product of an order that became worthless lies at an output, and no step uses it: give it to an open order that begins alike."
  (planning (state IDLE))
  (not (replan))
  (pddl-fluent (instance production) (name at-output) (params ?product ?machine))
  (pddl-fluent (instance production) (name at-step) (params ?product ?step))
  ?late <- (order (id ?a&:(eq ?product (product-of ?a))) (state STARTED) (base ?base) (rings $?rings) (begin ?begin) (end ?end))
  ?fresh <- (order (id ?o) (state OPEN) (base ?base)
                   (rings $?others&:(same-beginning (rings-done ?step) ?rings ?others)) (end ?due))
  (not (skipped (order ?o)))
  (pddl-fluent (instance production) (name not-begun) (params =(product-of ?o)))
  (not (step (state CHECKING|APPROACHING|RUNNING) (params ?product $?)))
  (not (pddl-fluent-change (instance production)))
  (not (pddl-action-get-effect))
  (time ?)
  (test (not (without-cap ?o)))
  (test (is-worthless (rings-left ?rings (rings-done ?step)) ?begin ?end))
  (test (is-in-time (rings-left ?others (rings-done ?step)) ?due))
  =>
  (exchange ?product (product-of ?o) ?machine ?step)
  (modify ?late (state OPEN))
  (modify ?fresh (state STARTED))
  (decide (str-cat "use " ?product " for order " ?o) (str-cat "order " ?a " is worth nothing any more"))
  (assert (replan (reason (str-cat ?product " is now for order " ?o)))))
