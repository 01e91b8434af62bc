; The instance `planning` becomes the future world: a copy of `production` in which all running steps have ended.

(defrule copy-true
  (planning (state COPY))
  (pddl-fluent (instance production) (name ?name&~output-ready) (params $?params))
  (not (pddl-fluent (instance planning) (name ?name) (params $?params)))
  =>
  (fluent planning ?name ?params))

(defrule copy-false
  "A fluent is false in `production`: it becomes false in `planning`, unless it is one that only plans use."
  (planning (state COPY))
  (pddl-fluent (instance planning) (name ?name&~idle&~before&~deadline) (params $?params))
  (not (pddl-fluent (instance production) (name ?name) (params $?params)))
  =>
  (no-fluent planning ?name ?params))

(defrule copy-number
  (planning (state COPY))
  (pddl-numeric-fluent (instance production) (name ?name&~window-in&~down-for&~handling-time) (params $?params) (value ?value))
  (not (pddl-numeric-fluent (instance planning) (name ?name) (params $?params) (value ?value)))
  =>
  (number planning ?name ?value ?params))

(defrule copy-window
  (planning (state COPY))
  (in-problem planning ?id)
  (order (id ?id) (begin ?begin))
  =>
  (number planning window-in (until-window-near ?begin) (product-of ?id)))

(defrule copy-handling
  (planning (state COPY))
  =>
  (number planning handling-time ?*HANDLING*))

(defrule copy-out-of-order
  (planning (state COPY))
  (out-of-order ?machine ?since ?mean)
  =>
  (number planning down-for (out-of-order-for ?machine ?since ?mean) (pddl-name ?machine)))

(defrule copy-output-not-ready
  "A machine is down with work in it: its output is not ready until it works again."
  (planning (state COPY))
  (out-of-order ?machine ? ?)
  (pddl-fluent (instance planning) (name output-ready) (params ?m&:(eq ?m (pddl-name ?machine))))
  (step (state RUNNING) (worker MACHINE) (params $? ?m $?))
  =>
  (no-fluent planning output-ready ?m))

(defrule copy-output-ready
  (planning (state COPY))
  (pddl-fluent (instance production) (name output-ready) (params ?m))
  (not (pddl-fluent (instance planning) (name output-ready) (params ?m)))
  (not (and (out-of-order ?machine&:(eq ?m (pddl-name ?machine)) ? ?)
            (step (state RUNNING) (worker MACHINE) (params $? ?m $?))))
  =>
  (fluent planning output-ready ?m))

(defrule copy-robot
  "The world is copied: robots on the field share the steps of the plan, robots off the field get none."
  (planning (state COPY))
  (robot (name ?name) (state ?state))
  (in-problem planning ?name)
  =>
  (if (eq ?state OFF-FIELD) then (no-fluent planning idle (sym-cat ?name)) else (fluent planning idle (sym-cat ?name))))

(deffunction end-in-plan (?name ?params ?time)
  (bind ?id (gensym*))
  (assert (pddl-action (instance planning) (id ?id) (plan ended) (name ?name) (params ?params)))
  (assert (pddl-action-get-effect (action ?id) (effect-type ?time) (apply TRUE))))

(deffunction end-what-runs ()
  "Have the remaining effects of running steps applied to `planning` after the copy."
  (do-for-all-facts ((?s step)) (eq ?s:state RUNNING)
    (if (neq ?s:worker ROBOT)
     then (end-in-plan ?s:action (create$ ?s:params (if (eq ?s:action deliver) then never else (create$))) END)
     else
      (if (not (and ?*SUB-ACTIONS* (any-factp ((?p picked)) (eq ?p:implied (create$ ?s:id)))))
       then (end-in-plan (sym-cat ?s:action -pick) ?s:params ALL))
      (end-in-plan (sym-cat ?s:action -place) ?s:params ALL))))

(defrule copy-done
  "Everything is copied, and no step ends now: let the running steps end in the copy."
  (declare (salience -10))
  ?planning <- (planning (state COPY))
  (not (pddl-action-get-effect))
  (not (pddl-fluent-change (instance production)))
  (not (pddl-numeric-fluent-change (instance production)))
  =>
  (end-what-runs)
  (modify ?planning (state END)))
