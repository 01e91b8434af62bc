; Ways are said before each plan. Times are means of this factory, in s.
(define (problem base) (:domain rcll-refinement)
  (:init (station-free) (robot-free) (= (dispense-time) 5) (= (handling-time) 15)
         (= (way-to input) 1) (= (way-to output) 1) (= (way-on input) 1) (= (way-on output) 1)))
