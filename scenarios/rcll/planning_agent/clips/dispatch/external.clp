; strategy.dispatch: external. Somebody outside chooses which step is looked at next, among the steps of robots that partial-order
; lets begin (package cxlab_choices; docs/reference/learning.md). Without an answer the step of the smallest rank is looked at, as ever.

(defrule dispatch-free
  "No step that must come before this one, because of a product or machine, is still to begin: this step is free."
  (declare (salience 20))
  (logical
    (candidate ?id)
    (not (and (waits-for (step ?id) (for ?before))
              (step (id ?before) (state OPEN|CHECKING|BLOCKED|APPROACHING|FAILED)))))
  =>
  (assert (free ?id)))

(defrule dispatch-without-choice
  "A free step of a machine, or one for which a robot drives already, needs no choice: it is allowed."
  (declare (salience 20))
  (logical
    (free ?id)
    (or (step (id ?id) (worker ~ROBOT))
        (step (id ?id) (state APPROACHING))))
  =>
  (assert (allowed ?id)))

(defrule dispatch-chosen
  "A free step was chosen: it is allowed until the world changes."
  (declare (salience 20))
  (logical
    (free ?id)
    (looks-at ?id ?version)
    (world-version ?version))
  =>
  (assert (allowed ?id)))

; --- The choice

(deffunction way-of-nearest (?spot)
  "The distance of the nearest idle robot, m."
  (bind ?least 14.0)
  (do-for-fact ((?m machine)) (eq ?m:name ?spot)
    (do-for-all-facts ((?r robot)) (eq ?r:state IDLE) (bind ?least (min ?least (distance ?r:x ?r:y ?m:x ?m:y)))))
  ?least)

(deffunction features-of-step (?step ?preferred)
  (bind ?action (fact-slot-value ?step action))
  (create$ (flag ?preferred)
           0.0
           (share (fact-slot-value ?step begin) 300)
           (share (- (fact-slot-value ?step end) (fact-slot-value ?step begin)) 120)
           (share (way-of-nearest (machine-named (source-of ?action (fact-slot-value ?step params)))) 14)
           (flag (eq ?action fetch-carrier))
           (flag (eq ?action bring-base))
           (flag (eq ?action transport))
           (flag (eq ?action bring-to-delivery))
           (flag (eq ?action pay-with-new-base))
           (flag (eq ?action pay-with-bare-base))
           (flag (neq (fact-slot-value ?step held-for) ""))))

(deffunction situation ()
  (create$ (share (game-time) ?*GAME*)
           (share (length$ (find-all-facts ((?r robot)) (eq ?r:state IDLE))) 3)
           (share (length$ (find-all-facts ((?s step)) (eq ?s:state RUNNING))) 10)
           (share (length$ (find-all-facts ((?s step)) (eq ?s:state OPEN))) 40)))

(deffunction earlier-step (?a ?b)
  "Order of steps for sort: by rank, and then by name, as in agenda-look."
  (bind ?one (fact-slot-value ?a rank))
  (bind ?other (fact-slot-value ?b rank))
  (or (> ?one ?other) (and (= ?one ?other) (> (str-compare (fact-slot-value ?a id) (fact-slot-value ?b id)) 0))))

(deffunction ask-for-step (?version ?now)
  "Ask for one of the steps, by rank, that nobody has looked at since the world changed. The last option is none of them."
  (bind ?items (create$))
  (bind ?options (create$))
  (bind ?allowed (create$))
  (bind ?features (create$))
  (bind ?steps (find-all-facts ((?s step)) (and (eq ?s:worker ROBOT) (< ?s:seen ?version) (any-factp ((?f free)) (eq ?f:implied (create$ ?s:id))))))
  (foreach ?s (sort earlier-step ?steps)
    (bind ?features (create$ ?features (features-of-step ?s (= (length$ ?items) 0))))
    (bind ?items (create$ ?items (fact-slot-value ?s id)))
    (bind ?options (create$ ?options (step-text ?s)))
    (bind ?allowed (create$ ?allowed TRUE)))
  (assert (choice (id (new-choice)) (kind begin-step) (items ?items none) (options ?options "wait") (allowed ?allowed TRUE) (preferred 1)
                  (situation (situation)) (features ?features 0.0 1.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0) (since ?now))))

(defrule dispatch-ask
  "A robot is idle, and every allowed step has been looked at: ask for a choice."
  (may-begin)
  (not (choice (kind begin-step)))
  (not (step (state CHECKING)))
  (world-version ?version)
  (not (looks-at none ?version))
  (exists (free ?id)
          (step (id ?id) (worker ROBOT) (state OPEN|BLOCKED) (seen ?seen&:(< ?seen ?version))))
  (not (and (allowed ?other)
            (step (id ?other) (seen ?last&:(< ?last ?version)))))
  (time ?now)
  =>
  (ask-for-step ?version ?now))

(defrule dispatch-answered
  ?choice <- (choice (id ?id) (kind begin-step))
  (choice-made (choice ?id) (option ?option))
  (world-version ?version)
  =>
  (bind ?step (made-item ?choice ?option))
  (retract ?choice)
  (assert (looks-at ?step ?version)))

(defrule dispatch-withdrawn
  "A new plan replaces the steps of an open choice: withdraw it."
  ?choice <- (choice (kind begin-step))
  (not (may-begin))
  =>
  (retract ?choice))

(defrule dispatch-forgotten
  ?looked <- (looks-at ? ?version)
  (world-version ~?version)
  =>
  (retract ?looked))

(deffunction why-held-back (?step)
  "The reason why the strategy holds a step back; FALSE if it does not."
  (why-linked ?step))
