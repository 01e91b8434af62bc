; Sees a cup after one second, and notifies the hand.

(defrule see-a-cup
  "A second has passed and nothing was seen yet."
  (time ?now&:(> ?now 1.0))
  (not (seen $?))
  =>
  (assert (seen cup))
  (bridge-send hand (str-cat "(seen cup " ?now ")")))

(defrule hear-of-it
  "The hand has it."
  (grasped ?what)
  =>
  (printout info "the hand has the " ?what crlf))
