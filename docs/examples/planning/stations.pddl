{% extends 'base.pddl' %}
{% block actions %}
{%- for station in stations %}
  (:durative-action use-{{ station }} :parameters (?r - robot) :duration (= ?duration {{ 5 * loop.index }})
    :condition (over all (at ?r {{ station }})) :effect (and))
{%- endfor %}
{% endblock %}
