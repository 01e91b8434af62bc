; Level two: how a base comes from its station to where it is wanted, for the robot that has the job. A coarse action takes
; the base station as one place; it has two sides.
(define (domain rcll-refinement)
  (:requirements :typing :durative-actions :numeric-fluents)
  (:types side)
  (:constants input output - side)
  (:predicates
    (station-free) (robot-free)
    (base-at ?s - side)
    (robot-at ?s - side)
    (holding-at ?s - side)
    (base-there))
  (:functions
    (way-to ?s - side)   ; s: of the robot, and until another one that stands there is gone
    (way-on ?s - side)   ; s: to where the base is wanted
    (dispense-time) (handling-time))

  (:durative-action dispense
    :parameters (?s - side)
    :duration (= ?duration (dispense-time))
    :condition (at start (station-free))
    :effect (and (at start (not (station-free))) (at end (base-at ?s))))

  (:durative-action drive-to
    :parameters (?s - side)
    :duration (= ?duration (way-to ?s))
    :condition (at start (robot-free))
    :effect (and (at start (not (robot-free))) (at end (robot-at ?s))))

  (:durative-action pick
    :parameters (?s - side)
    :duration (= ?duration (handling-time))
    :condition (and (at start (robot-at ?s)) (at start (base-at ?s)))
    :effect (and (at start (not (base-at ?s))) (at end (holding-at ?s))))

  (:durative-action bring
    :parameters (?s - side)
    :duration (= ?duration (way-on ?s))
    :condition (at start (holding-at ?s))
    :effect (and (at start (not (holding-at ?s))) (at end (base-there)))))
