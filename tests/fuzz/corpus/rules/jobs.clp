; A job is carried out step by step: each step is one command; when it has succeeded the next step is due.

(deffunction machine-of (?spot)
  "C-CS1 of C-CS1-SHELF-LEFT."
  (bind ?dash (str-index "-" (sub-string 3 (str-length ?spot) ?spot)))
  (if ?dash then (sub-string 1 (+ ?dash 1) ?spot) else ?spot))

(deffunction base-of (?order-id)
  "The base colour of an order; any colour for order 0."
  (do-for-fact ((?o order)) (= ?o:id ?order-id) (return ?o:base))
  "BASE_RED")

(deffunction distance (?x1 ?y1 ?x2 ?y2)
  (sqrt (+ (* (- ?x1 ?x2) (- ?x1 ?x2)) (* (- ?y1 ?y2) (- ?y1 ?y2)))))

(defrule job-step-command
  "A step is due: command the skill for it."
  ?job <- (job (id ?id) (robot ?robot&~"") (step ?step&GO-FETCH|FETCH|GO-PUT|PUT) (moving NO) (from ?from) (to ?to)
               (not-before ?wait))
  (time ?now&:(>= ?now ?wait))
  (not (held-up (job ?id) (step ?step)))
  =>
  (bind ?skill (switch ?step (case FETCH then pick) (case PUT then place) (default drive_to)))
  (bind ?target (if (or (eq ?step GO-FETCH) (eq ?step FETCH)) then ?from else ?to))
  (modify ?job (moving YES))
  (assert (command (id ?id) (robot ?robot) (skill ?skill) (target ?target))))

(defrule job-step-succeeded
  "The skill of this step succeeded: on to the next."
  ?job <- (job (id ?id) (robot ?robot) (step ?step) (moving YES))
  ?command <- (command (id ?id) (state SUCCEEDED) (target ?target))
  ?r <- (robot (name ?robot))
  (machine (name =(machine-of ?target)) (x ?x) (y ?y))
  =>
  (retract ?command)