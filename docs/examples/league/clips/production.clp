; Robot 1 makes the first C0 that is ordered, step by step.

(deftemplate step
  (slot number (type INTEGER))
  (slot do (type SYMBOL) (allowed-values TASK PREPARE AWAIT))
  (slot machine (type STRING))
  (multislot what)) ; TASK: part, type, fields and values; PREPARE: kind, field, value ...; AWAIT: state

(deffacts production
  (current 1)
  (said 0))

(deffunction machine-of (?type)
  (str-cat (sub-string 1 1 ?*COLOR*) "-" ?type))

(defrule production-plan
  "The steps of a C0. CS1 has grey caps, CS2 black ones; the bare base pays at a ring station."
  (game (phase PRODUCTION))
  (order (id ?id) (complexity C0) (base ?base) (cap ?cap))
  (not (step))
  =>
  (bind ?cs (machine-of (if (eq ?cap CAP_GREY) then CS1 else CS2)))
  (bind ?bs (machine-of BS))
  (bind ?ds (machine-of DS))
  (bind ?rs (machine-of RS1))
  (assert (making ?id)
   (step (number 1) (do TASK) (what buffer BufferStation machine_id ?cs shelf_number 1))
   (step (number 2) (do PREPARE) (machine ?cs) (what cs operation RETRIEVE_CAP))
   (step (number 3) (do AWAIT) (machine ?cs) (what READY-AT-OUTPUT))
   (step (number 4) (do TASK) (what move Move waypoint ?cs machine_point "OUTPUT"))
   (step (number 5) (do TASK) (what retrieve Retrieve machine_id ?cs machine_point "OUTPUT"))
   (step (number 6) (do TASK) (what deliver Deliver machine_id ?rs machine_point "SLIDE"))
   (step (number 7) (do PREPARE) (machine ?bs) (what bs side OUTPUT color ?base))
   (step (number 8) (do AWAIT) (machine ?bs) (what READY-AT-OUTPUT))
   (step (number 9) (do TASK) (what retrieve Retrieve machine_id ?bs machine_point "OUTPUT"))
   (step (number 10) (do TASK) (what deliver Deliver machine_id ?cs machine_point "INPUT"))
   (step (number 11) (do PREPARE) (machine ?cs) (what cs operation MOUNT_CAP))
   (step (number 12) (do AWAIT) (machine ?cs) (what READY-AT-OUTPUT))
   (step (number 13) (do TASK) (what retrieve Retrieve machine_id ?cs machine_point "OUTPUT"))
   (step (number 14) (do TASK) (what deliver Deliver machine_id ?ds machine_point "INPUT"))
   (step (number 15) (do PREPARE) (machine ?ds) (what ds order_id ?id))
   (step (number 16) (do AWAIT) (machine ?ds) (what IDLE))))

(defrule production-may-begin
  "All machines are known and robot 1 has nothing to explore any more."
  (exists (machine))
  (not (machine (known FALSE)))
  (robot (number 1) (state ~BUSY))
  =>
  (assert (may-begin)))

(defrule production-task
  (may-begin)
  (current ?n)
  (step (number ?n) (do TASK) (what ?part ?type $?values))
  (not (sent ?n))
  (robot (number 1) (state ~BUSY))
  =>
  (assert (sent ?n))
  (send-task 1 ?part ?type ?values))

(defrule production-task-done
  ?current <- (current ?n)
  ?sent <- (sent ?n)
  (robot (number 1) (state IDLE))
  =>
  (retract ?current ?sent)
  (assert (current (+ ?n 1))))

(defrule production-task-failed
  "Once more."
  (current ?n)
  ?sent <- (sent ?n)
  (robot (number 1) (state FAILED))
  =>
  (retract ?sent))

(defrule production-prepare
  "Every second until the machine is at work; the delivery station not before the window of the order."
  (may-begin)
  (time ?now)
  (current ?n)
  (step (number ?n) (do PREPARE) (machine ?machine) (what ?kind $?instruction))
  (machine (name ?machine) (state IDLE))
  (making ?id)
  (order (id ?id) (begin ?begin))
  (game (time ?time&:(or (neq ?kind ds) (>= ?time ?begin))))
  (peer (name TEAM) (id ?peer))
  ?said <- (said ?last&:(>= ?now (+ ?last 1)))
  =>
  (retract ?said)
  (assert (said ?now))
  (prepare ?peer ?machine ?kind (expand$ ?instruction)))

(defrule production-prepared
  ?current <- (current ?n)
  (step (number ?n) (do PREPARE) (machine ?machine))
  (machine (name ?machine) (state ~IDLE&~DOWN&~WAIT-IDLE))
  =>
  (retract ?current)
  (assert (current (+ ?n 1))))

(defrule production-awaited
  ?current <- (current ?n)
  (step (number ?n) (do AWAIT) (machine ?machine) (what ?state))
  (machine (name ?machine) (state ?state))
  =>
  (retract ?current)
  (assert (current (+ ?n 1))))

(defrule production-done
  (current 17)
  (making ?id)
  =>
  (printout t "order " ?id " is delivered" crlf))
