; comment (with paren
(deffacts start "a \"quoted\" )" (a ?x&:(> 1 2)|b&~c)) word "string" 12
(defrule r (f $?x) => (printout t "x;y" crlf)) ; tail
(defrule open (a
(defrule next => )
) (deffunction M::f (?x) ?x)
