; The hypothesis that the turtle goes on turning as fast as it does now.

(defglobal ?*HYPOTHESIS* = "turning")

(deffunction predicted (?x ?y ?theta ?speed ?turn ?seconds)
  "The predicted place (x y) of a turtle that goes on turning."
  (if (< (abs ?turn) 0.001) then
    (return (create$ (+ ?x (* ?speed ?seconds (cos ?theta))) (+ ?y (* ?speed ?seconds (sin ?theta))))))
  (bind ?radius (/ ?speed ?turn))
  (bind ?end (+ ?theta (* ?turn ?seconds)))
  (create$ (+ ?x (* ?radius (- (sin ?end) (sin ?theta)))) (+ ?y (* ?radius (- (cos ?theta) (cos ?end))))))
