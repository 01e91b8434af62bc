; strategy.dispatch: groups, lookahead:N. Steps that begin together are a group. The first group that is not done may begin,
; and N more.

(defglobal ?*AHEAD* = (groups-ahead (ros-param-get-value "strategy.dispatch" "groups")))

(defrule dispatch-group
  "All steps of earlier groups are done, except for the last N groups: the step is allowed. No group waits for waits of the agent."
  (declare (salience 20))
  (logical
    (candidate ?id)
    (step (id ?id) (group ?group))
    (not (step (state ~DONE) (worker ~AGENT) (group ?g&:(< 0 ?g (- ?group ?*AHEAD*))))))
  =>
  (assert (allowed ?id)))

(deffunction why-held-back (?step)
  "The reason why the strategy holds a step back; FALSE if it does not."
  (bind ?group (fact-slot-value ?step group))
  (do-for-fact ((?s step)) (and (neq ?s:state DONE) (neq ?s:worker AGENT) (< 0 ?s:group (- ?group ?*AHEAD*)))
    (return (str-cat (step-text ?s) " of group " ?s:group " is not done, and this is group " ?group)))
  FALSE)
