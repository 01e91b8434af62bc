(defrule greet
  "It has begun: say so."
  =>
  (printout info "hello, world" crlf)
  (assert (begun (now))))

(defrule stop
  "The executive has refreshed for three seconds: that is enough."
  (begun ?begun)
  (time ?t&:(>= (- ?t ?begun) 3))
  =>
  (cx-shutdown))
