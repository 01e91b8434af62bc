; Production in the Logistics League in coarse actions: the way of a product from machine to machine, payments for its
; rings, caps for its cap station. Robots are not in it: which one does an action is decided when it begins.
{% from 'robot_actions.jinja' import robot_actions %}
(define (domain rcll-production)
  (:requirements :typing :durative-actions :numeric-fluents :negative-preconditions :conditional-effects)
  (:types
    ring-station cap-station - station
    base-station station delivery-station - machine
    product step{% block types %}{% endblock %})
  (:constants s0 s1 s2 s3 s4 - step)
  (:predicates
    ; the works of a product, one step after the other; the last step is its delivery
    (at-step ?p - product ?s - step)
    (next-step ?p - product ?s ?next - step)
    (work-at ?p - product ?s - step ?m - machine)
    (window-near ?p - product)
    (delivered ?p - product)
    ; where it is
    (not-begun ?p - product)
    (at-input ?p - product ?m - machine)
    (at-output ?p - product ?m - machine)
    (working ?m - machine)             ; is not down or broken
    (output-ready ?m - machine)        ; what is in work there will come out; not where the machine is down meanwhile
    ; a side of a machine is free when nothing lies there and nobody brings a piece
    (input-free ?m - machine)
    (output-free ?m - machine)
    (shelf-stocked ?cs - cap-station)  ; carriers lie on its shelf, or will
    (carrier-at-input ?cs - cap-station)
    (cap-loaded ?cs - cap-station)
    (bare-base-at-output ?cs - cap-station)
    {% block predicates %}{% endblock %}{% block more_predicates %}{% endblock %})
  (:functions{% block functions %}{% endblock %}
    (price ?p - product ?s - step)
    (payments ?rs - ring-station)      ; that lie on the slide
    (slide-room ?rs - ring-station)    ; for payments that nobody brings yet
    (way-time ?from ?to - machine)
    (handling-time)                    ; of a transport besides the way
    (window-in ?p - product)           ; s until the product may be fetched for its delivery
    (down-for ?m - machine)            ; s until it works again
    (ring-time) (cap-time) (retrieve-time) (delivery-time))

  ; --- robots
{% for a in robot_actions %}
  (:durative-action {{ a.name }}
    :parameters ({{ a.params }}{% block robot %}{% endblock %})
    :duration (= ?duration {{ a.duration }})
    :condition (and{% for f in a.needs %} (at start {{ f }}){% endfor %}{% block robot_idle %}{% endblock %})
    :effect (and{% for f in a.claims %} (at start {{ f }}){% endfor %}{% for f in a.picks + a.places %} (at end {{ f }}){% endfor %}{% block robot_busy %}{% endblock %}))
{% endfor %}
  ; --- machines

  (:durative-action retrieve-cap
    :parameters (?cs - cap-station)
    :duration (= ?duration (retrieve-time))
    :condition (and (at start (carrier-at-input ?cs)) (at start (output-free ?cs)) (at start (working ?cs)))
    :effect (and (at start (not (carrier-at-input ?cs))) (at start (not (output-free ?cs)))
                 (at end (cap-loaded ?cs)) (at end (bare-base-at-output ?cs)) (at end (input-free ?cs))))

  (:durative-action mount-ring
    :parameters (?p - product ?rs - ring-station ?s ?next - step)
    :duration (= ?duration (ring-time))
    :condition (and (at start (at-input ?p ?rs)) (at start (output-free ?rs)) (at start (at-step ?p ?s))
                    (at start (work-at ?p ?s ?rs)) (at start (next-step ?p ?s ?next))
                    (at start (>= (payments ?rs) (price ?p ?s))) (at start (working ?rs)))
    :effect (and (at start (not (at-input ?p ?rs))) (at start (not (output-free ?rs))) (at start (not (at-step ?p ?s)))
                 (at start (decrease (payments ?rs) (price ?p ?s))) (at start (increase (slide-room ?rs) (price ?p ?s)))
                 (at end (at-step ?p ?next)) (at end (at-output ?p ?rs)) (at end (input-free ?rs))))

  (:durative-action mount-cap
    :parameters (?p - product ?cs - cap-station ?s ?next - step)
    :duration (= ?duration (cap-time))
    :condition (and (at start (at-input ?p ?cs)) (at start (output-free ?cs)) (at start (at-step ?p ?s))
                    (at start (work-at ?p ?s ?cs)) (at start (next-step ?p ?s ?next)) (at start (cap-loaded ?cs))
                    (at start (working ?cs)))
    :effect (and (at start (not (at-input ?p ?cs))) (at start (not (output-free ?cs))) (at start (not (at-step ?p ?s)))
                 (at start (not (cap-loaded ?cs)))
                 (at end (at-step ?p ?next)) (at end (at-output ?p ?cs)) (at end (input-free ?cs))))

  (:durative-action deliver
    :parameters (?p - product ?ds - delivery-station ?s - step{% block moment %}{% endblock %})
    :duration (= ?duration (delivery-time))
    :condition (and (at start (at-input ?p ?ds)) (at start (at-step ?p ?s)) (at start (work-at ?p ?s ?ds)) (at start (working ?ds)){% block in_time %}{% endblock %})
    :effect (and (at start (not (at-input ?p ?ds))) (at start (not (at-step ?p ?s)))
                 (at end (delivered ?p)) (at end (input-free ?ds)){% block loss %}{% endblock %}))

  ; --- the agent itself

  (:durative-action wait-for-window
    :parameters (?p - product)
    :duration (= ?duration (window-in ?p))
    :condition (at start (not (window-near ?p)))
    :effect (at end (window-near ?p)))

  (:durative-action wait-until-it-works
    :parameters (?m - machine)
    :duration (= ?duration (down-for ?m))
    :condition (and)
    :effect (and (at end (working ?m)) (at end (output-ready ?m))))

{% block more %}{% endblock %})
