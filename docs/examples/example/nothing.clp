(defrule say-goodbye
  "The executive ends: a last word."
  (executive-finalize)
  =>
  (printout t "nothing was to do" crlf))
