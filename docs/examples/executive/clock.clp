(defrule tell-time
  "Each refresh asserts a time fact: say it."
  (time ?t)
  =>
  (printout info "it is " ?t " s, " (now-systime) " s since 1970" crlf))

(defrule stop-after-two-seconds
  "The clock has run long enough: end the executive."
  (time ?t&:(>= ?t 2.0))
  =>
  (cx-shutdown))

(defrule say-goodbye
  "The executive ends: a last word."
  (executive-finalize)
  =>
  (printout yellow "goodbye" crlf))
