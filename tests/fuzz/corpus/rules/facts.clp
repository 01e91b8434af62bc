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
   base lies at the output. LOADED: 