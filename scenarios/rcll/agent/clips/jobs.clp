; A job is carried out step by step. Each step is one command; when it has succeeded, the next step is due.

(deffunction machine-of (?spot)
  "The machine of a spot: C-CS1 for C-CS1-SHELF-LEFT."
  (bind ?dash (str-index "-" (sub-string 3 (str-length ?spot) ?spot)))
  (if ?dash then (sub-string 1 (+ ?dash 1) ?spot) else ?spot))

(defglobal ?*TRANSPORT* = TRUE)  ; one skill fetches and brings a piece, if nothing holds the job up in between

(deffunction output-of (?machine)
  (str-cat ?machine "-OUTPUT"))

(deffunction input-of (?machine)
  (str-cat ?machine "-INPUT"))

(deffunction base-of (?order-id)
  "The base colour of an order; any colour for order 0, which is waste."
  (do-for-fact ((?o order)) (= ?o:id ?order-id) (return ?o:base))
  "BASE_RED")

(deffunction dispense-base (?job)
  "Have the base for a job dispensed, at the side of the base station where the robot fetches it."
  (bind ?from (fact-slot-value ?job from))
  (bind ?bs (fact-slot-value ?job station))
  (assert (instruction (id (fact-slot-value ?job id)) (machine ?bs) (operation "DISPENSE_BASE")
                       (side (if (eq ?from (output-of ?bs)) then "OUTPUT" else "INPUT"))
                       (color (base-of (fact-slot-value ?job order))))))

(deffunction create-job (?purpose ?urgency ?order ?from ?to)
  "Add a job without a robot; returns its number."
  (bind ?id (new-id))
  (assert (job (id ?id) (purpose ?purpose) (urgency ?urgency) (station (machine-of ?from)) (order ?order) (from ?from) (to ?to)))
  ?id)

(deffunction hold-up (?id $?steps)
  "Hold these steps of a job back."
  (foreach ?step ?steps (assert (held-up (job ?id) (step ?step)))))

(deffunction distance (?x1 ?y1 ?x2 ?y2)
  (sqrt (+ (* (- ?x1 ?x2) (- ?x1 ?x2)) (* (- ?y1 ?y2) (- ?y1 ?y2)))))

(deffunction trouble-of (?step ?code ?tries ?target)
  "The trouble that this code means after so many failures of the step; NONE if another try is worth it."
  (if (and (= ?code 300) (str-index "SLIDE" ?target)) then (return OCCUPIED))
  (if (and (= ?code 300) (str-index "SHELF" ?target)) then (return BARRED))
  (bind ?fetches (or (eq ?step GO-FETCH) (eq ?step FETCH)))
  (if (and ?fetches (= ?code 207)) then (return (if (> ?tries 0) then HELD else FULL)))
  (if (and (not ?fetches) (= ?code 208)) then (return LOST))
  (if (or (< ?tries 2) (= ?code 210)) then (return NONE))
  (if (and ?fetches (= ?code 202)) then (return MISSING))
  (if ?fetches then (return UNABLE))
  (if (= ?code 209) then (return OCCUPIED))
  (if (< ?tries 5) then NONE else STUCK))

(defrule job-step-command
  "A step is due: command its skill. If nothing holds up the steps after a fetch, one skill does them all, which is faster."
  ?job <- (job (id ?id) (robot ?robot&~"") (step ?step&GO-FETCH|FETCH|GO-PUT|PUT) (moving NO) (from ?from) (to ?to)
               (not-before ?wait))
  (time ?now&:(>= ?now ?wait))
  (not (held-up (job ?id) (step ?step)))
  (not (trouble (job ?id)))
  =>
  (bind ?skill (switch ?step (case FETCH then pick) (case PUT then place) (default drive_to)))
  (bind ?target (if (or (eq ?step GO-FETCH) (eq ?step FETCH)) then ?from else ?to))
  (modify ?job (moving YES))
  (if (and ?*TRANSPORT* (eq ?step FETCH) (not (any-factp ((?h held-up)) (= ?h:job ?id))))
   then (assert (command (id ?id) (robot ?robot) (skill transport) (from ?from) (target ?to)))
   else (assert (command (id ?id) (robot ?robot) (skill ?skill) (target ?target)))))

(defrule job-fetched
  "The transport skill has picked up the piece: the next step is to bring it."
  (command (id ?id) (part "drive_to"|"place"))
  ?job <- (job (id ?id) (step FETCH))
  =>
  (modify ?job (step GO-PUT)))

(defrule job-step-succeeded
  "The skill of this step succeeded: go on to the next step."
  ?command <- (command (id ?id) (state SUCCEEDED) (skill ?skill) (target ?target))
  ?job <- (job (id ?id) (robot ?robot) (step ?step&:(or (neq ?skill transport) (eq ?step GO-PUT))) (moving YES))
  ?r <- (robot (name ?robot))
  (machine (name =(machine-of ?target)) (x ?x) (y ?y))
  =>
  (retract ?command)
  (modify ?r (place ?target) (x ?x) (y ?y))
  (modify ?job (moving NO) (tries 0)
               (step (if (eq ?skill transport) then DONE
                      else (switch ?step (case GO-FETCH then FETCH) (case FETCH then GO-PUT) (case GO-PUT then PUT) (default DONE))))))

(defrule job-step-failed
  "The skill failed: try it again a little later, or note the trouble so that other rules handle it."
  ?command <- (command (id ?id) (state FAILED) (skill ?skill) (part ?part) (target ?target) (error-code ?code) (error ?error))
  ?job <- (job (id ?id) (step ?step&:(not (and (eq ?step FETCH) (member$ ?part (create$ "drive_to" "place"))))) (moving YES)
               (tries ?tries) (from ?from))
  (time ?now)
  =>
  (printout warn "job " ?id ": " ?skill " " ?target " failed: " ?code " " ?error crlf)
  (retract ?command)
  (modify ?job (moving NO) (tries (+ ?tries 1)) (not-before (+ ?now 1.0)))
  (bind ?kind (trouble-of ?step ?code ?tries (if (eq ?step FETCH) then ?from else ?target)))
  (if (neq ?kind NONE) then (assert (trouble (job ?id) (kind ?kind)))))

(defrule job-robot-free
  "The piece is at its place, or the job was given up: the robot is idle."
  ?job <- (job (robot ?robot&~"") (step DONE|GIVEN-UP))
  ?r <- (robot (name ?robot))
  (time ?now)
  =>
  (modify ?r (state IDLE) (idle-since ?now))
  (modify ?job (robot "")))
