; strategy.dispatch: groups, lookahead:N. Steps that begin together are a group. The first group that is not done may begin,
; and N more.

(defglobal ?*AHEAD* = (groups-ahead (ros-param-get-value "strategy.dispatch" "groups")))

(defrule dispatch-group
  "All steps of earlier groups are done, but for those of the last N. For waits of the agent itself no group waits."
  (declare (salience 20))
  (logical
    (candidate ?id)
    (step (id ?id) (group ?group))
    (not (step (state ~DONE) (worker ~AGENT) (group ?g&:(< 0 ?g (- ?group ?*AHEAD*))))))
  =>
  (assert (allowed ?id)))

(deffunction why-held-back (?step)
  "FALSE: the strategy does not hold it back."
  (bind ?group (fact-slot-value ?step group))
  (do-for-fact ((?s step)) (and (neq ?s:state DONE) (neq ?s:worker AGENT) (< 0 ?s:group (- ?group ?*AHEAD*)))
    (return (str-cat (step-text ?s) " of group " ?s:group " is not done, and this is group " ?group)))
  FALSE)
