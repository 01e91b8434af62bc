; A robot goes to a place and works there while it is open.
(define (domain hall)
  (:requirements :typing :durative-actions :duration-inequalities :timed-initial-literals :numeric-fluents)
  (:types robot place)
  (:predicates (at ?r - robot ?p - place) (open ?p - place) (done ?p - place))
  (:functions (way ?a ?b - place))
  (:durative-action go
    :parameters (?r - robot ?a ?b - place)
    :duration (= ?duration (way ?a ?b))
    :condition (at start (at ?r ?a))
    :effect (and (at start (not (at ?r ?a))) (at end (at ?r ?b))))
  (:durative-action work
    :parameters (?r - robot ?p - place)
    :duration (and (>= ?duration 2) (<= ?duration 4))
    :condition (and (over all (at ?r ?p)) (over all (open ?p)))
    :effect (at end (done ?p))))
