; The hypothesis that the turtle goes straight on.

(defglobal ?*HYPOTHESIS* = "straight")

(deffunction predicted (?x ?y ?theta ?speed ?turn ?seconds)
  "Where it will be: (x y)."
  (create$ (+ ?x (* ?speed ?seconds (cos ?theta))) (+ ?y (* ?speed ?seconds (sin ?theta)))))
