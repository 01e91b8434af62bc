(defrule greet
  "It has begun: say so."
  =>
  (printout info "hello, world" crlf))

(defrule stop
  "The executive has refreshed for three seconds: that is enough."
  (time ?t&:(>= ?t 3))
  =>
  (cx-shutdown))
