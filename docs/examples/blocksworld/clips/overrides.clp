; Steps of this agent have a state: the helper rules fill the other slots and leave these alone.
(deftemplate pddl-action
  (slot instance) (slot id) (slot name (type SYMBOL)) (multislot params) (slot plan)
  (slot planned-start-time (type FLOAT)) (slot planned-duration (type FLOAT))
  (slot state (type SYMBOL) (allowed-values IDLE CHECKED STARTED RUNNING ENDING DONE) (default IDLE))
  (slot actual-start-time (type FLOAT) (default 0.0)))
