(deffacts start (greet "world"))

(defrule greet
  "Somebody is to be greeted."
  (greet ?name)
  =>
  (printout t "hello " ?name crlf))
