; What the agent knows. One template a thing; states are enumerated, so that order never hangs on salience.

(deftemplate robot
  "One of our robots; x and y are those of the machine at which it last was."
  (slot name (type STRING))
  (slot state (type SYMBOL) (allowed-values IDLE BUSY GOING-HOME))
  (slot home (type STRING))
  (slot place (type STRING) (default ""))
  (slot x (type FLOAT) (default 0.0))
  (slot y (type FLOAT) (default 0.0))
  (slot idle-since (type FLOAT) (default 0.0)))

(deftemplate machine
  "A machine as the referee box last reported it."
  (slot name (type STRING))
  (slot kind (type SYMBOL))
  (slot state (type SYMBOL))
  (slot x (type FLOAT))
  (slot y (type FLOAT)))

(deftemplate order
  "An order that is active. OPEN: nobody works on it. ASSIGNED: a cap station has it. DONE: delivered."
  (slot id (type INTEGER))
  (slot complexity (type STRING))
  (slot base (type STRING))
  (slot cap (type STRING))
  (slot begin (type FLOAT))
  (slot end (type FLOAT))
  (slot state (type SYMBOL) (allowed-values OPEN ASSIGNED DONE) (default OPEN)))

(deftemplate game
  (slot phase (type SYMBOL))
  (slot begin (type FLOAT))  ; when this phase began; windows of orders count from there
  (slot state (type SYMBOL)))

(deftemplate team
  "How many robots play."
  (slot size (type INTEGER)))

(deftemplate cap-station
  "The cycle of one cap station. EMPTY: no cap in it. BUFFERING: a carrier is on its way or inside. CLEARING: the bare
   base lies at the output. LOADED: the cap is in. MOUNTING: the base is inside. MOUNTED: the product is at the output."
  (slot name (type STRING))
  (slot cap (type STRING))
  (slot phase (type SYMBOL) (allowed-values EMPTY BUFFERING CLEARING LOADED MOUNTING MOUNTED) (default EMPTY))
  (slot order (type INTEGER) (default 0)))

(deftemplate shelf
  "One of the three slots of a cap station's shelf."
  (slot machine (type STRING))
  (slot spot (type STRING))
  (slot state (type SYMBOL) (allowed-values FULL TAKEN) (default FULL)))

(deftemplate shelf-refill
  "A shelf that we emptied: the crew fills it again."
  (slot machine (type STRING))
  (slot at (type FLOAT)))

(deftemplate slide
  "A ring station's slide and the payments that we put there."
  (slot machine (type STRING))
  (slot spot (type STRING))
  (slot count (type INTEGER) (default 0)))

(deftemplate job
  "One piece to be brought from one place to another by one robot.
   WAITING: no robot yet. GO-FETCH, FETCH, GO-PUT, PUT: the skill that runs or is next. DONE: the piece is there.
   GIVEN-UP: nothing more to do. A DISCARD begins with the piece in the gripper."
  (slot id (type INTEGER))
  (slot purpose (type SYMBOL) (allowed-values BUFFER CLEAR BASE DELIVER PAY DISCARD))
  (slot station (type STRING))
  (slot order (type INTEGER) (default 0))
  (slot from (type STRING))
  (slot to (type STRING))
  (slot robot (type STRING) (default ""))
  (slot step (type SYMBOL) (allowed-values WAITING GO-FETCH FETCH GO-PUT PUT DONE GIVEN-UP) (default WAITING))
  (slot moving (type SYMBOL) (allowed-values NO YES) (default NO))
  (slot tries (type INTEGER) (default 0))           ; failures of this step, one after the other
  (slot not-before (type FLOAT) (default 0.0))
  (slot handed-over (type INTEGER) (default 0))     ; how often a robot left it to others
  (slot avoid (type STRING) (default "")))          ; the robot that did; it stays away until not-before

(deftemplate trouble
  "Trying the step again does not help (recovery.clp).
   HELD: there is a piece in the gripper, ours. FULL: one, not ours. UNABLE: the piece cannot be fetched. MISSING: it is
   not there. GONE: its machine broke down with it. OCCUPIED: something lies where it should go. LOST: it fell. STUCK: it cannot be put down."
  (slot job (type INTEGER))
  (slot kind (type SYMBOL) (allowed-values HELD FULL UNABLE MISSING GONE OCCUPIED LOST STUCK)))

(deftemplate held-up
  "This step of a job must wait; the rule that sees its reason gone retracts it."
  (slot job (type INTEGER))
  (slot step (type SYMBOL)))

(deftemplate reserved
  "A machine that only one job may use at a time (base station, delivery station)."
  (slot machine (type STRING))
  (slot job (type INTEGER)))

(defglobal ?*last-id* = 0)

(deffunction new-id ()
  "Numbers for jobs, commands and instructions."
  (bind ?*last-id* (+ ?*last-id* 1))
  ?*last-id*)
