(deffacts start (load-team))

(defrule load-team
  "At the start: read the team's file."
  (load-team)
  =>
  (config-load (str-cat (ament-index-get-package-share-directory "example") "/team.yaml") "/team"))

(defrule greet-robot
  "A robot of the list: greet it by its name."
  (confval (path ?path&:(str-index "/robots/" ?path)) (value ?name))
  (test (str-index "/name" ?path))
  =>
  (printout t "hello " ?name crlf))

(defrule count-machines
  "The list of machines: count it."
  (confval (path "/team/machines") (is-list TRUE) (list-value $?machines))
  =>
  (printout t (length$ ?machines) " machines" crlf))
