; The strategy `external`: somebody outside chooses which order begins and which job a robot takes (package cxlab_choices). The choice
; of the rules in choose-orders.clp and choose-jobs.clp is the preferred option. docs/reference/learning.md documents the features.

(defglobal
  ?*WAIT* = 1.0     ; s until a robot that chose to wait is asked again
  ?*MORE* = 2       ; how many more products than robots may begin
  ?*INTERVAL* = 0.0) ; s between two choices of an order, also of none alone (parameter choices.interval); 0: once a second, if one can begin

(deftemplate waits
  "A robot that chose to wait."
  (slot robot (type STRING))
  (slot until (type FLOAT)))

(deffunction payments-missing ()
  (bind ?missing 0)
  (do-for-all-facts ((?s slide)) TRUE (bind ?missing (+ ?missing (max 0 (- ?s:wanted ?s:loaded ?s:coming)))))
  ?missing)

(deffunction situation (?time)
  (create$ (share ?time ?*GAME*)
           (share (length$ (find-all-facts ((?r robot)) (eq ?r:state IDLE))) 3)
           (share (length$ (find-all-facts ((?j job)) (eq ?j:step WAITING))) 8)
           (share (length$ (find-all-facts ((?p product)) TRUE)) 5)
           (share (length$ (find-all-facts ((?o order)) (eq ?o:state OPEN))) 10)
           (share (length$ (find-all-facts ((?s cap-station)) (eq ?s:phase LOADED))) 2)
           (share (payments-missing) 6)
           (share (length$ (find-all-facts ((?m machine)) (or (eq ?m:state DOWN) (eq ?m:state BROKEN)))) 7)))

; --- Which order is begun

(defrule choices-interval
  "At the start: read how often to ask."
  =>
  (bind ?*INTERVAL* (ros-param-get-value "choices.interval" ?*INTERVAL*)))

(deffunction ready-at (?rings ?time)
  (+ ?time (time-to-make ?rings)))

(deffunction common (?some ?others)
  "How many of these are also among the others."
  (bind ?n 0)
  (foreach ?one ?some (if (member$ ?one ?others) then (bind ?n (+ ?n 1))))
  ?n)

(deffunction meetings (?machines)
  "How often other products need one of these machines as well."
  (bind ?n 0)
  (do-for-all-facts ((?p product)) TRUE (bind ?n (+ ?n (common ?p:via ?machines))))
  ?n)

(deffunction features-of-order (?order ?preferred ?time)
  (bind ?rings (fact-slot-value ?order rings))
  (bind ?complexity (fact-slot-value ?order complexity))
  (bind ?bonus (fact-slot-value ?order bonus))
  (bind ?begin (fact-slot-value ?order begin))
  (bind ?end (fact-slot-value ?order end))
  (bind ?ready (ready-at ?rings ?time))
  (bind ?points (points-of ?complexity ?rings ?bonus (- ?ready ?end) (- ?end ?begin)))
  (bind ?payments (- (jobs-of ?rings) 4 (length$ ?rings)))
  (bind ?machines (machines-for (works-for ?rings (fact-slot-value ?order cap))))
  (create$ (flag ?preferred)
           0.0
           (share (worth ?complexity ?rings ?bonus ?begin ?end ?time) 20)
           (share ?points 200)
           (share (jobs-of ?rings) 12)
           (share (length$ ?rings) 3)
           (share ?payments 6)
           (share (- ?begin ?ready) 600)
           (share (- ?end ?ready) 600)
           (share (- ?*GAME* ?ready) ?*GAME*)
           (share ?bonus 10)
           (share (meetings (first$ ?machines)) 3)
           (share (meetings (rest$ ?machines)) 8)
           (flag (has-cap (nth$ (- (length$ ?machines) 1) ?machines)))
           0.0))

(deffunction features-of-no-order (?preferred ?spare)
  (create$ (flag ?preferred) 1.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 (share ?spare 3)))

(deffunction ask-for-order (?time ?robots)
  "Ask which order begins; the last option is none. If no order can begin, nobody is asked, except at a fixed interval."
  (bind ?spare (- ?robots (length$ (find-all-facts ((?p product)) TRUE))))
  (bind ?more (> (+ ?spare ?*MORE*) 0))
  (if (not (or ?more (> ?*INTERVAL* 0))) then (return))
  (bind ?best (if (> ?spare 0) then (best-order ?time) else 0))
  (bind ?items (create$))
  (bind ?options (create$))
  (bind ?allowed (create$))
  (bind ?features (create$))
  (do-for-all-facts ((?o order)) (and ?more (eq ?o:state OPEN) (<= (ready-at ?o:rings ?time) ?*GAME*) (is-left ?o:cap)
                                      (can-begin (machines-for (works-for ?o:rings ?o:cap))))
    (bind ?items (create$ ?items ?o:id))
    (bind ?allowed (create$ ?allowed TRUE))
    (bind ?options (create$ ?options (str-cat "begin order " ?o:id)))
    (bind ?features (create$ ?features (features-of-order ?o (= ?o:id ?best) ?time))))
  (if (not (or (> (length$ ?items) 0) (> ?*INTERVAL* 0))) then (return))
  (bind ?items (create$ ?items 0))
  (assert (choice (id (new-choice)) (kind begin-order) (items ?items) (options ?options "begin no order") (allowed ?allowed TRUE)
                  (preferred (member$ ?best ?items)) (situation (situation ?time))
                  (features ?features (features-of-no-order (= ?best 0) ?spare)) (since (now)))))

(defrule order-choose
  "Once a second, or at the interval that is asked for: ask which order is begun."
  ?next <- (next-choice ?at)
  (game (phase PRODUCTION) (begin ?zero))
  (team (size ?robots))
  (time ?now&:(>= ?now ?at))
  (not (choice (kind begin-order)))
  =>
  (retract ?next)
  (assert (next-choice (+ ?now (if (> ?*INTERVAL* 0) then ?*INTERVAL* else 1.0))))
  (ask-for-order (- ?now ?zero) ?robots))

(defrule order-chosen
  "An order was chosen: begin it, unless rules have withdrawn it or taken its machine meanwhile."
  ?choice <- (choice (id ?id) (kind begin-order))
  (choice-made (choice ?id) (option ?option))
  =>
  (bind ?order (made-item ?choice ?option))
  (retract ?choice)
  (do-for-fact ((?o order)) (and (= ?o:id ?order) (eq ?o:state OPEN) (can-begin (machines-for (works-for ?o:rings ?o:cap))))
    (decide (str-cat "begin order " ?order) "it was chosen from outside")
    (assert (chosen ?order))))

; --- Which job a robot takes

(deffunction awake (?robot)
  (not (any-factp ((?w waits)) (eq ?w:robot ?robot))))

(deffunction most-urgent-job ()
  "The job that choose-jobs.clp would give next: the most urgent waiting job, the oldest among equals; FALSE if none waits."
  (bind ?best FALSE)
  (do-for-all-facts ((?j job)) (eq ?j:step WAITING)
    (if (or (not ?best)
            (< ?j:urgency (fact-slot-value ?best urgency))
            (and (= ?j:urgency (fact-slot-value ?best urgency)) (< ?j:id (fact-slot-value ?best id))))
     then (bind ?best ?j)))
  ?best)

(deffunction best-robot (?job ?now)
  "The idle robot with the least reluctance that may take the job; FALSE if there is none."
  (bind ?best FALSE)
  (bind ?least 1000000.0)
  (bind ?avoid (fact-slot-value ?job avoid))
  (bind ?wait (fact-slot-value ?job not-before))
  (do-for-fact ((?m machine)) (eq ?m:name (machine-of (fact-slot-value ?job from)))
    (do-for-all-facts ((?r robot)) (and (eq ?r:state IDLE) (awake ?r:name) (may-take ?r:name ?avoid ?wait ?now))
      (bind ?speaks-against (reluctance ?m:x ?m:y ?r:x ?r:y (- ?now ?r:idle-since)))
      (if (< ?speaks-against ?least) then (bind ?least ?speaks-against) (bind ?best ?r))))
  ?best)

(deffunction detour (?robot ?x ?y)
  "By how many metres the way of the nearest other idle robot is shorter."
  (bind ?most -14.0)
  (bind ?own (distance (fact-slot-value ?robot x) (fact-slot-value ?robot y) ?x ?y))
  (do-for-all-facts ((?r robot)) (and (eq ?r:state IDLE) (neq ?r:name (fact-slot-value ?robot name)))
    (bind ?most (max ?most (- ?own (distance ?r:x ?r:y ?x ?y)))))
  ?most)

(deffunction base-is-taken (?station)
  "Whether the base station is reserved for a job."
  (any-factp ((?r reserved)) (eq ?r:machine ?station)))

(deffunction users (?machine)
  "How many products still need the machine, and how many need it next."
  (bind ?all 0)
  (bind ?next 0)
  (do-for-all-facts ((?p product)) (member$ ?machine ?p:via)
    (bind ?all (+ ?all 1))
    (if (eq ?machine (nth$ 1 ?p:via)) then (bind ?next (+ ?next 1))))
  (create$ ?all ?next))

(deffunction features-of-job (?robot ?job ?preferred ?now ?zero)
  (bind ?id (fact-slot-value ?job id))
  (bind ?purpose (fact-slot-value ?job purpose))
  (bind ?station (fact-slot-value ?job station))
  (bind ?goal (machine-of (fact-slot-value ?job to)))
  (bind ?way 14.0) (bind ?haul 14.0) (bind ?detour 0.0) (bind ?kind BS) (bind ?missing 0) (bind ?left 0.0) (bind ?points 0.0) (bind ?todo 0)
  (do-for-fact ((?m machine)) (eq ?m:name ?station)
    (bind ?way (distance (fact-slot-value ?robot x) (fact-slot-value ?robot y) ?m:x ?m:y))
    (bind ?detour (detour ?robot ?m:x ?m:y))
    (do-for-fact ((?g machine)) (eq ?g:name ?goal) (bind ?kind ?g:kind) (bind ?haul (distance ?m:x ?m:y ?g:x ?g:y))))
  (if (member$ ?purpose (create$ PAY CLEAR))
   then (do-for-fact ((?s slide)) (eq ?s:machine ?goal) (bind ?missing (- ?s:wanted ?s:loaded))))
  (if (eq ?purpose MOVE)
   then (do-for-fact ((?o order) (?p product)) (and (= ?o:id (fact-slot-value ?job order)) (= ?p:order ?o:id))
          (bind ?left (- ?o:end (- ?now ?zero)))
          (bind ?todo (length$ ?p:todo))
          (bind ?points (points-of ?o:complexity ?o:rings ?o:bonus (- 0.0 ?left) (- ?o:end ?o:begin)))))
  (bind ?users (users ?goal))
  (create$ (flag ?preferred)
           0.0
           (share (fact-slot-value ?job urgency) 5)
           (share ?way 14)
           (share ?haul 14)
           (share ?detour 14)
           (flag (eq ?purpose BUFFER))
           (flag (eq ?purpose CLEAR))
           (flag (eq ?purpose PAY))
           (flag (and (eq ?purpose MOVE) (eq ?kind RS)))
           (flag (and (eq ?purpose MOVE) (eq ?kind CS)))
           (flag (and (eq ?purpose MOVE) (eq ?kind DS)))
           (flag (any-factp ((?h held-up)) (and (= ?h:job ?id) (eq ?h:step FETCH))))
           (flag (any-factp ((?h held-up)) (and (= ?h:job ?id) (eq ?h:step PUT))))
           (flag (and (any-factp ((?h held-up)) (and (= ?h:job ?id) (eq ?h:step GO-FETCH))) (base-is-taken ?station)))
           (share ?missing 3)
           (share ?points 200)
           (share ?left 600)
           (share ?todo 5)
           (share (nth$ 1 ?users) 3)
           (share (nth$ 2 ?users) 2)))

(deffunction features-of-waiting (?preferred)
  (create$ (flag ?preferred) 1.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0))

(deffunction first-idle-robot ()
  "The first idle robot that has not chosen to wait; FALSE if there is none."
  (do-for-fact ((?r robot)) (and (eq ?r:state IDLE) (awake ?r:name)) (return ?r))
  FALSE)

(deffunction ask-for-job (?now ?zero)
  "Ask the robot that the rules would send which job it takes; the last option is to wait. If they would send none, ask any idle robot."
  (bind ?urgent (most-urgent-job))
  (bind ?robot (best-robot ?urgent ?now))
  (if (not ?robot)
   then (bind ?robot (first-idle-robot))
        (bind ?urgent FALSE)
        (if (not ?robot) then (return)))
  (bind ?name (fact-slot-value ?robot name))
  (bind ?items (create$))
  (bind ?options (create$))
  (bind ?allowed (create$))
  (bind ?features (create$))
  (do-for-all-facts ((?j job)) (and (eq ?j:step WAITING) (may-take ?name ?j:avoid ?j:not-before ?now))
    (bind ?items (create$ ?items ?j:id))
    (bind ?options (create$ ?options (text-of-job ?j)))
    (bind ?allowed (create$ ?allowed TRUE))
    (bind ?features (create$ ?features (features-of-job ?robot ?j (eq ?j ?urgent) ?now ?zero))))
  (if (= (length$ ?items) 0) then (return))
  (bind ?preferred (if ?urgent then (member$ (fact-slot-value ?urgent id) ?items) else (+ 1 (length$ ?items))))
  (assert (choice (id (new-choice)) (kind take-job) (who ?name) (items ?items 0) (options ?options "wait") (allowed ?allowed TRUE)
                  (preferred ?preferred) (situation (situation (- ?now ?zero)))
                  (features ?features (features-of-waiting (not ?urgent))) (since ?now))))

(defrule job-ask
  "A robot is idle, and jobs wait: ask one robot at a time."
  (not (to-look))
  (exists (job (step WAITING)))
  (robot (name ?name) (state IDLE))
  (not (waits (robot ?name)))
  (not (choice (kind take-job)))
  (game (begin ?zero))
  (time ?now)
  =>
  (ask-for-job ?now ?zero))

(deffunction send-robot (?robot ?job)
  (bind ?name (fact-slot-value ?robot name))
  (decide (str-cat ?name " for " (text-of-job ?job)) "it was chosen from outside")
  (modify ?robot (state BUSY))
  (modify ?job (robot ?name) (step GO-FETCH) (not-before 0.0)))

(defrule robot-take-job
  "Robot and job may have something else to do by now: then the robot is asked again."
  ?choice <- (choice (id ?id) (kind take-job) (who ?name))
  (choice-made (choice ?id) (option ?option))
  (time ?now)
  =>
  (bind ?item (made-item ?choice ?option))
  (retract ?choice)
  (if (= ?item 0)
   then (assert (waits (robot ?name) (until (+ ?now ?*WAIT*))))
   else (do-for-fact ((?r robot) (?j job)) (and (eq ?r:name ?name) (eq ?r:state IDLE) (= ?j:id ?item) (eq ?j:step WAITING))
          (send-robot ?r ?j))))

(defrule robot-withdrawn
  "The asked robot got something else to do, or all robots must look for machines: withdraw the choice."
  ?choice <- (choice (kind take-job) (who ?name))
  (or (robot (name ?name) (state ~IDLE))
      (to-look))
  =>
  (retract ?choice))

(defrule robot-waited
  ?waits <- (waits (until ?until))
  (time ?now&:(>= ?now ?until))
  =>
  (retract ?waits))
