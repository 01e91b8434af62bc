; Hears of the readings of a plugin's thread.

(defrule hear
  "A reading has come."
  (reading ?n)
  =>
  (printout info "reading " ?n crlf))

(defrule enough
  "The third reading ends the run."
  (reading 3)
  =>
  (cx-shutdown))
