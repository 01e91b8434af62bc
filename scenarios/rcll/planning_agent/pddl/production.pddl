{#- The coarse actions of coarse.pddl, and what they are made of and what can go wrong with them. For an action NAME of a robot:
   NAME-drive, NAME-pick, NAME-place   its sub-actions, which the robot reports one after the other;
   NAME-return                         the robot gives up without having had the piece;
   NAME-lose                           the piece is gone. -#}
{% extends 'coarse.pddl' %}
{% from 'robot_actions.jinja' import robot_actions, begin_anew %}
{% block predicates %}{% for a in robot_actions -%}
({{ a.name }}-driving {{ a.params }}) ({{ a.name }}-holding {{ a.params }})
    {% endfor %}{% endblock %}
{% block more %}
  ; --- what actions of robots are made of, and what goes wrong with them
{% for a in robot_actions %}
  (:action {{ a.name }}-drive
    :parameters ({{ a.params }})
    :precondition (and {{ a.needs | join(' ') }})
    :effect (and {{ a.claims | join(' ') }} ({{ a.name }}-driving {{ a.args }})))
  (:action {{ a.name }}-pick
    :parameters ({{ a.params }})
    :precondition ({{ a.name }}-driving {{ a.args }})
    :effect (and (not ({{ a.name }}-driving {{ a.args }})) ({{ a.name }}-holding {{ a.args }}) {{ a.picks | join(' ') }}))
  (:action {{ a.name }}-place
    :parameters ({{ a.params }})
    :precondition ({{ a.name }}-holding {{ a.args }})
    :effect (and (not ({{ a.name }}-holding {{ a.args }})) {{ a.places | join(' ') }}))
  (:action {{ a.name }}-return
    :parameters ({{ a.params }})
    :precondition (and)
    :effect (and (not ({{ a.name }}-driving {{ a.args }})) {{ a.returns | join(' ') }}))
  (:action {{ a.name }}-lose
    :parameters ({{ a.params }})
    :precondition (and)
    :effect (and (not ({{ a.name }}-driving {{ a.args }})) (not ({{ a.name }}-holding {{ a.args }})) {{ a.loses | join(' ') }}
                ))
{% endfor %}
  ; --- what goes wrong at machines

  (:action lose-work
    :parameters (?p - product ?m - machine)
    :precondition (and)
    :effect (and (input-free ?m) (output-free ?m) {{ begin_anew }}))

  (:action lose-carrier
    :parameters (?cs - cap-station)
    :precondition (and)
    :effect (and (input-free ?cs) (output-free ?cs)))

  (:action empty-input
    :parameters (?m - machine)
    :precondition (and)
    :effect (and (when (exists (?p - product) (at-input ?p ?m)) (input-free ?m))
                 (forall (?p - product) (when (at-input ?p ?m) (and (not (at-input ?p ?m)) {{ begin_anew }})))))

  (:action empty-output
    :parameters (?m - machine)
    :precondition (and)
    :effect (and (when (exists (?p - product) (at-output ?p ?m)) (output-free ?m))
                 (forall (?p - product) (when (at-output ?p ?m) (and (not (at-output ?p ?m)) {{ begin_anew }})))))

  (:action empty-cap-station
    :parameters (?cs - cap-station)
    :precondition (and)
    :effect (and (not (cap-loaded ?cs))
                 (when (carrier-at-input ?cs) (and (not (carrier-at-input ?cs)) (input-free ?cs)))
                 (when (bare-base-at-output ?cs) (and (not (bare-base-at-output ?cs)) (output-free ?cs)))))

  (:action empty-slide
    :parameters (?rs - ring-station)
    :precondition (and)
    :effect (and (increase (slide-room ?rs) (payments ?rs)) (assign (payments ?rs) 0)))
{% endblock %}
