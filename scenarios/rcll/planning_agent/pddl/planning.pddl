{#- The world as plans see it. Robots: each step of a robot takes one, so that plans share them; which robot does the step is
   decided when it begins. Deadlines: a delivery loses points the later it is. The planner's choice of robot and deadline is the
   last parameter of a step. -#}
{% extends 'production.pddl' %}
{% block types %} robot moment{% endblock %}
{% block more_predicates %}(idle ?r - robot)
    (before ?t - moment)
    (deadline ?p - product ?t - moment){% endblock %}
{% block functions %}
    (lost)                             ; points
    (loss ?p - product ?t - moment)    ; of points, if the product is delivered before that moment and not before an earlier one{% endblock %}
{% block robot %} ?r - robot{% endblock %}
{% block robot_idle %} (at start (idle ?r)){% endblock %}
{% block robot_busy %} (at start (not (idle ?r))) (at end (idle ?r)){% endblock %}
{% block moment %} ?t - moment{% endblock %}
{% block in_time %} (at start (deadline ?p ?t)) (at start (before ?t)){% endblock %}
{% block loss %} (at start (increase (lost) (loss ?p ?t))){% endblock %}
