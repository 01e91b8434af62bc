(defrule tell-time
  "Each refresh asserts a time fact: say it."
  (time ?t)
  =>
  (printout info "it is " ?t " s, " (now-systime) " s since 1970" crlf))

(defrule begin
  "The first refresh: note its time, which counts from 1970 on a robot."
  (time ?t)
  (not (begun ?))
  =>
  (assert (begun ?t)))

(defrule stop-after-two-seconds
  "The clock has run long enough: end the executive."
  (begun ?begun)
  (time ?t&:(>= (- ?t ?begun) 2.0))
  =>
  (cx-shutdown))

(defrule say-goodbye
  "The executive ends: a last word."
  (executive-finalize)
  =>
  (printout yellow "goodbye" crlf))
