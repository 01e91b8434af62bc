; c stands on a, b beside them. A template: the blocks are named once.
{% set blocks = ["a", "b", "c"] %}
(define (problem three-blocks)
  (:domain blocksworld)
  (:objects {{ blocks | join(" ") }} - block)
  (:init (on c a) (ontable a) (ontable b) (clear b) (clear c) (handempty) (= (moves) 0))
  (:goal (and)))
