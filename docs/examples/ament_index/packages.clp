(deffacts start (list-packages))

(defrule list-packages
  "At the start: say what there is."
  (list-packages)
  =>
  (bind ?pairs (ament-index-get-packages-with-prefixes))
  (printout t "first package: " (nth$ 1 ?pairs) crlf)
  (if (not (ament-index-has-resource packages nothing)) then
    (printout t "no package of the name nothing" crlf)))
