; The hypothesis that the turtle goes straight on.

(defglobal ?*HYPOTHESIS* = "straight")

(deffunction predicted (?x ?y ?theta ?speed ?turn ?seconds)
  "The predicted place (x y) of a turtle that goes straight on."
  (create$ (+ ?x (* ?speed ?seconds (cos ?theta))) (+ ?y (* ?speed ?seconds (sin ?theta)))))
