; The facts of the agent, a template for each kind of thing. States are enumerated, so the order of firing never depends on salience.

(defglobal ?*GAME* = 1200.0)  ; length of production in s, unless the league tells another one

(deftemplate robot
  "One of our robots. Its x and y are those of the machine or zone where it was last. ROAMING: it drives without a job."
  (slot name (type STRING))
  (slot state (type SYMBOL) (allowed-values IDLE BUSY ROAMING OFF-FIELD))
  (slot duty (type SYMBOL) (default ACTIVE))  ; as the referee box says
  (slot cycles (type INTEGER) (default 0))    ; how often it was in maintenance
  (slot number (type INTEGER) (default 0))    ; in its team, from 1
  (slot home (type STRING))
  (slot place (type STRING) (default ""))
  (slot x (type FLOAT) (default 0.0))
  (slot y (type FLOAT) (default 0.0))
  (slot idle-since (type FLOAT) (default 0.0)))

(deftemplate under-way
  "The time since which a robot or machine has been working on a goal."
  (slot goal-id (type SYMBOL))
  (slot since (type FLOAT)))

(deftemplate machine
  "A machine as the referee box last reported it."
  (slot name (type STRING))
  (slot kind (type SYMBOL))
  (slot state (type SYMBOL))
  (slot x (type FLOAT))
  (slot y (type FLOAT))
  (slot rotation (type INTEGER) (default 0)))  ; degrees; its input is on that side

(deftemplate does
  "What a machine does to a product: a ring's colour, a cap's colour, or DELIVER."
  (slot machine (type STRING))
  (slot work (type STRING))
  (slot price (type INTEGER) (default 0)))  ; payments

(deftemplate order
  "An order that is active. OPEN: nobody works on it. STARTED: there is a product for it. DONE: delivered."
  (slot id (type INTEGER))
  (slot complexity (type STRING))
  (slot base (type STRING))
  (multislot rings (type STRING))
  (slot cap (type STRING))
  (slot bonus (type INTEGER) (default 0))  ; of a competitive one: the first team gains 10 points, the second one loses them
  (slot begin (type FLOAT))
  (slot end (type FLOAT))
  (slot state (type SYMBOL) (allowed-values OPEN STARTED DONE) (default OPEN)))

(deftemplate product
  "The product that the agent makes for an order. READY: it lies at the output of a machine (at first the base station, which has yet to
   dispense the base). MOVING: a robot brings it. WAITING: it lies on the input. WORKING: the machine works on it."
  (slot order (type INTEGER))
  (multislot todo (type STRING))      ; works still to be begun
  (multislot via (type STRING))       ; the machines for them
  (slot at (type STRING))             ; where it lies, or was fetched last
  (multislot keeps (type STRING))     ; machines that nobody else may use: where it lies, where it goes next
  (slot job (type INTEGER) (default 0)) ; that moves it, or the instruction that works on it
  (slot state (type SYMBOL) (allowed-values READY MOVING WAITING WORKING) (default READY)))

(deftemplate game
  (slot phase (type SYMBOL))
  (slot begin (type FLOAT))  ; when this phase began; windows of orders count from there
  (slot state (type SYMBOL)))

(deftemplate team
  "How many robots play."
  (slot size (type INTEGER)))

(deftemplate cap-station
  "How far a cap station is with its next cap. EMPTY: no cap in it. BUFFERING: a carrier is on its way or inside.
   CLEARING: the bare base lies at the output. LOADED: the cap is in."
  (slot name (type STRING))
  (slot cap (type STRING))
  (slot phase (type SYMBOL) (allowed-values EMPTY BUFFERING CLEARING LOADED) (default EMPTY)))

(deftemplate shelf
  "One of the three slots of a cap station's shelf. BARRED: it has a carrier, and there is no way to it."
  (slot machine (type STRING))
  (slot spot (type STRING))
  (slot state (type SYMBOL) (allowed-values FULL TAKEN BARRED) (default FULL)))

(deftemplate shelf-refill
  "A shelf that we emptied: the crew fills it again."
  (slot machine (type STRING))
  (slot at (type FLOAT)))

(deftemplate slide
  "A ring station's slide: the payments that lie there, that are on their way, and that the products need."
  (slot machine (type STRING))
  (slot spot (type STRING))
  (slot loaded (type INTEGER) (default 0))
  (slot coming (type INTEGER) (default 0))
  (slot wanted (type INTEGER) (default 0)))

(deftemplate job
  "One piece to be brought from one place to another by one robot.
   WAITING: no robot yet. GO-FETCH, FETCH, GO-PUT, PUT: the skill that runs or is next. DONE: the piece is there.
   GIVEN-UP: nothing more to do. A DISCARD begins with the piece in the gripper."
  (slot id (type INTEGER))
  (slot purpose (type SYMBOL) (allowed-values BUFFER CLEAR PAY MOVE DISCARD))
  (slot urgency (type INTEGER) (default 5))         ; small is urgent
  (slot station (type STRING) (default ""))         ; the machine from which it is fetched
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
   not there. BARRED: there is no way to it. GONE: its machine broke down with it. OCCUPIED: something lies where it should go. LOST: it fell. STUCK: it cannot be put down."
  (slot job (type INTEGER))
  (slot kind (type SYMBOL) (allowed-values HELD FULL UNABLE MISSING BARRED GONE OCCUPIED LOST STUCK)))

(deftemplate held-up
  "This step of a job must wait; the rule that sees its reason gone retracts it."
  (slot job (type INTEGER))
  (slot step (type SYMBOL)))

(deftemplate reserved
  "A machine that only one job may use at a time (base station, delivery station)."
  (slot machine (type STRING))
  (slot job (type INTEGER)))

(deftemplate sighting
  "What stands in a zone. Without a name: a robot saw something there, and nobody has read its markers yet."
  (slot zone (type STRING))
  (slot machine (type STRING) (default ""))
  (slot rotation (type INTEGER) (default -1)))

(deftemplate to-look
  "A zone to which a robot must go: to read the markers of what stands there, or only to look around."
  (slot zone (type STRING))
  (slot skill (type SYMBOL) (allowed-values explore drive_to)))

; --- What it decides

(deftemplate decision
  "A decision, and its reason: the journal has them as records of their own."
  (slot what (type STRING))
  (slot why (type STRING)))

(deffunction decide (?what ?why) ; mutate: skip
  "No rule needs it: it is there for the journal."
  (retract (assert (decision (what ?what) (why ?why)))))

(deffunction text-of-job (?job)
  "MOVE C-BS-OUTPUT C-RS1-INPUT"
  (str-cat (fact-slot-value ?job purpose) " " (fact-slot-value ?job from) " " (fact-slot-value ?job to)))

(defglobal ?*last-id* = 0)

(deffunction new-id ()
  "Numbers for jobs, commands, instructions and what else comes in an order."
  (bind ?*last-id* (+ ?*last-id* 1))
  ?*last-id*)
