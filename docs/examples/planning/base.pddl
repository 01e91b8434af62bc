(define (domain delivery)
  (:types robot place)
  {% set stations = ['rs1', 'rs2'] %}
  (:constants {{ stations | join(' ') }} - place)
  (:predicates (at ?r - robot ?p - place))
  {% block actions %}{% endblock %}
)
