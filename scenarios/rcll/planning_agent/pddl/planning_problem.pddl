{#- Moments at which points can be lost, in s from the beginning: set-up, game, overtime and pauses of half an hour. -#}
{% set moments = 360 %}
{% extends 'problem.pddl' %}
{% block objects %}
  (:objects {% for i in range(1, moments) %}t{{ 10 * i }} {% endfor %}never - moment)
{% endblock %}
{% block init %}
    (= (lost) 0) (before never)
    {% for i in range(1, moments) %}(before t{{ 10 * i }}) (at {{ 10 * i }} (not (before t{{ 10 * i }})))
    {% endfor %}
{% endblock %}
{% block metric %}
  (:metric minimize (+ (lost) (* 0.01 (total-time)))){% endblock %}
