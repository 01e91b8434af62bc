; One hand, blocks on a table. Lifting and putting down take time.
(define (domain blocksworld)
  (:requirements :strips :typing :durative-actions :numeric-fluents)
  (:types block)
  (:predicates (on ?x ?y - block) (ontable ?x - block) (clear ?x - block) (handempty) (holding ?x - block))
  (:functions (moves))

  (:durative-action pick-up
    :parameters (?x - block)
    :duration (= ?duration 2)
    :condition (and (at start (clear ?x)) (at start (ontable ?x)) (at start (handempty)))
    :effect (and (at start (not (handempty))) (at start (not (clear ?x))) (at end (not (ontable ?x))) (at end (holding ?x))
                 (at end (increase (moves) 1))))

  (:durative-action put-down
    :parameters (?x - block)
    :duration (= ?duration 2)
    :condition (and (at start (holding ?x)))
    :effect (and (at start (not (holding ?x))) (at end (clear ?x)) (at end (ontable ?x)) (at end (handempty))))

  (:durative-action stack
    :parameters (?x ?y - block)
    :duration (= ?duration 3)
    :condition (and (at start (holding ?x)) (at start (clear ?y)))
    :effect (and (at start (not (holding ?x))) (at start (not (clear ?y))) (at end (clear ?x)) (at end (on ?x ?y)) (at end (handempty))))

  (:durative-action unstack
    :parameters (?x ?y - block)
    :duration (= ?duration 3)
    :condition (and (at start (on ?x ?y)) (at start (clear ?x)) (at start (handempty)))
    :effect (and (at start (not (handempty))) (at start (not (clear ?x))) (at end (not (on ?x ?y))) (at end (holding ?x)) (at end (clear ?y))
                 (at end (increase (moves) 1)))))
