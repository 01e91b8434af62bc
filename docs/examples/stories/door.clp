(deftemplate door
  (slot name (type SYMBOL))
  (slot state (type SYMBOL) (allowed-values CLOSED OPENING OPEN)))

(defrule open-door
  "Somebody is in front of a closed door: open it."
  (person-at ?name)
  ?door <- (door (name ?name) (state CLOSED))
  =>
  (modify ?door (state OPENING)))

(defrule door-is-open
  "A second later it is open."
  ?door <- (door (state OPENING))
  (time ?t&:(>= ?t 1.0))
  =>
  (modify ?door (state OPEN)))
