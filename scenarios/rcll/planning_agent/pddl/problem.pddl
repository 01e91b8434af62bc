; The problem before the league has told anything: no machines, no orders. Times are means of this factory, in s.
(define (problem game) (:domain rcll-production)
{% block objects %}{% endblock %}
  (:init (= (ring-time) 24) (= (cap-time) 24) (= (retrieve-time) 24) (= (delivery-time) 15) (= (handling-time) 34){% block init %}{% endblock %}){% block metric %}{% endblock %})
