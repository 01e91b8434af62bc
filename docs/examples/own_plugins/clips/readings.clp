; Hears of the readings of a plugin's thread. Several may come between two ticks.

(defrule hear
  "The oldest reading that was not heard of."
  (reading ?n)
  (not (heard ?n))
  (not (and (reading ?before&:(< ?before ?n)) (not (heard ?before))))
  =>
  (assert (heard ?n))
  (printout info "reading " ?n crlf))

(defrule enough
  "The third reading ends the run."
  (heard 3)
  =>
  (cx-shutdown))
