; Builds a tower of three blocks: plans with the helper rules, then does each step when its condition holds. A step
; takes its planned duration; its effects are applied at its start and its end. When a step cannot begin, somebody else
; has moved a block: the agent looks what there is and plans again.

(deffacts wanted
  (pddl-manager (node "/pddl_manager"))
  (pddl-goal-fluent (instance blocks) (goal tower) (name on) (params a b))
  (pddl-goal-fluent (instance blocks) (goal tower) (name on) (params b c)))

(defrule load
  "At the start: the problem, by its folder."
  (not (pddl-instance))
  (pddl-manager)
  =>
  (assert (pddl-instance (name blocks) (domain "domain.pddl") (problem "problem.pddl")
                         (directory (str-cat (ament-index-get-package-share-directory "blocksworld") "/pddl")))))

(defrule ask
  "It is loaded: what is there, and a goal instance for the tower."
  (pddl-instance (name blocks) (state LOADED))
  (not (pddl-get-fluents))
  =>
  (assert (pddl-get-fluents (instance blocks))
          (pddl-get-numeric-fluents (instance blocks))
          (pddl-create-goal-instance (instance blocks) (goal tower))))

(defrule aim
  "The goal instance exists: set its goal."
  (pddl-create-goal-instance (goal tower) (state DONE))
  (not (pddl-set-goals))
  =>
  (assert (pddl-set-goals (instance blocks) (goal tower))))

(defrule plan
  "The goals are set and all is known: plan."
  (pddl-set-goals (goal tower) (state DONE))
  (pddl-get-fluents (state DONE))
  (pddl-get-numeric-fluents (state DONE))
  (not (pddl-plan))
  =>
  (assert (pddl-plan (instance blocks) (id tower-plan) (goal tower))))

(defrule no-plan
  (pddl-plan (state FAILURE))
  =>
  (printout error "there is no plan" crlf))

(defrule check-next
  "The step before has ended: may this one begin?"
  (pddl-plan (id ?plan) (state SUCCESS))
  (pddl-action (plan ?plan) (id ?id) (state IDLE))
  (not (pddl-action (plan ?plan) (id ?other&:(< ?other ?id)) (state ~DONE)))
  (not (pddl-action-condition (action ?id)))
  =>
  (assert (pddl-action-condition (instance blocks) (action ?id))))

(defrule start
  "It may: its effects at the start."
  ?check <- (pddl-action-condition (action ?id) (state CONDITION-SAT))
  ?action <- (pddl-action (id ?id) (name ?name) (params $?params) (state IDLE))
  (time ?now)
  =>
  (retract ?check)
  (println "start " ?name " " (implode$ (pddl-symbols ?params)))
  (assert (pddl-action-get-effect (action ?id) (effect-type START) (apply TRUE)))
  (modify ?action (state RUNNING) (actual-start-time ?now)))

(defrule cannot-start
  "It may not: its plan goes; what there is now is asked for, and then planned for."
  ?check <- (pddl-action-condition (action ?step) (state CONDITION-UNSAT) (unsatisfied-conditions $?missing))
  (pddl-action (id ?step) (plan ?id))
  ?plan <- (pddl-plan (id ?id))
  ?known <- (pddl-get-fluents (state DONE))
  =>
  (println "step " ?step " cannot begin, plan again: " (implode$ ?missing))
  (do-for-all-facts ((?action pddl-action)) (eq ?action:plan ?id) (retract ?action))
  (modify ?known (state PENDING))
  (retract ?check ?plan))

(defrule end
  "Its time is over: its effects at the end."
  ?action <- (pddl-action (id ?id) (state RUNNING) (actual-start-time ?start) (planned-duration ?duration))
  (time ?now&:(>= ?now (+ ?start ?duration)))
  ?effect <- (pddl-action-get-effect (action ?id) (effect-type START) (state DONE))
  =>
  (retract ?effect)
  (assert (pddl-action-get-effect (action ?id) (effect-type END) (apply TRUE)))
  (modify ?action (state ENDING)))

(defrule done
  "They have come true."
  ?action <- (pddl-action (id ?id) (state ENDING))
  ?effect <- (pddl-action-get-effect (action ?id) (effect-type END) (state DONE))
  (not (pddl-fluent-change))
  (not (pddl-numeric-fluent-change))
  =>
  (retract ?effect)
  (modify ?action (state DONE)))

(defrule tower
  "All steps are done: look."
  (pddl-action)
  (not (pddl-action (state ~DONE)))
  (pddl-fluent (name on) (params a b))
  (pddl-fluent (name on) (params b c))
  (pddl-numeric-fluent (name moves) (value ?moves))
  (time ?now)
  (not (built))
  =>
  (assert (built))
  (println "a is on b, b is on c: " (integer ?moves) " moves, " (format nil "%.1f" ?now) " s"))
