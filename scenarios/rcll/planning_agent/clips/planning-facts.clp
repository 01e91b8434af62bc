; What the agent knows besides the facts of the rule agent (rcll_agent) and of the PDDL helper rules (cx_pddl_clips).
; The instance `production` is the present world. The agent makes plans for the instance `planning`, which is the world after all
; running steps have ended.

(defglobal
  ?*SUB-ACTIONS* = TRUE          ; whether effects are applied when a robot reports a part of its action, or only at its end
  ?*ORDER* = "plan"              ; the order of steps that may begin: plan, delivery, slack (docs/reference/planning-agent.md)
  ?*BASE-SIDE* = "nearest"       ; where bases come out: nearest, output, planned
  ?*IN-ADVANCE* = TRUE           ; cap stations get their next cap when robots have nothing else to do
  ?*PRODUCTS* = 3                ; how many products are planned for at once
  ?*ALTERNATIVES* = 3)           ; how many sets of orders are planned for at once

(deffunction choose-base-side-by (?word)
  (bind ?*BASE-SIDE* ?word)
  (if (eq ?word "planned") then (assert (plans-sides))))

(defrule read-settings
  "At the start: read the parameters of the node, which choose the strategy."
  ?read <- (read-settings)
  =>
  (retract ?read)
  (read-settings-of-robots 10.0 "nearest" "rested" "both" "finish")
  (bind ?*SUB-ACTIONS* (ros-param-get-value "strategy.sub_actions" ?*SUB-ACTIONS*))
  (bind ?*ORDER* (one-of "strategy.order" ?*ORDER* "plan" "delivery" "slack"))
  (choose-base-side-by (one-of "strategy.base_side" ?*BASE-SIDE* "nearest" "output" "planned"))
  (bind ?*IN-ADVANCE* (ros-param-get-value "strategy.in_advance" ?*IN-ADVANCE*))
  (if (ros-param-get-value "strategy.clairvoyant" FALSE) then (assert (clairvoyant)))
  (bind ?*PRODUCTS* (at-least 1 "strategy.products" ?*PRODUCTS*))
  (bind ?*ALTERNATIVES* (at-least 1 "strategy.alternatives" ?*ALTERNATIVES*))
  (assert (pddl-manager (node (ros-param-get-value "planner.node" "/pddl_manager")))))

(deftemplate step
  "An action of the plan in execution. OPEN: not yet looked at. CHECKING: the PDDL manager is asked for its conditions.
   BLOCKED: they did not hold. APPROACHING: a robot drives there already. RUNNING, DONE, FAILED. Its pddl-action has the same id."
  (slot id (type SYMBOL))
  (slot action (type SYMBOL))
  (multislot params (type SYMBOL))
  (slot begin (type FLOAT))                 ; in the plan, s
  (slot end (type FLOAT))
  (slot rank (type FLOAT) (default 0.0))    ; the smallest goes first
  (slot group (type INTEGER) (default 0))   ; of steps that begin together
  (slot worker (type SYMBOL) (allowed-values ROBOT MACHINE AGENT))
  (slot robot (type SYMBOL) (default none)) ; of the plan
  (slot state (type SYMBOL) (allowed-values OPEN CHECKING BLOCKED APPROACHING RUNNING DONE FAILED) (default OPEN))
  (slot was (type SYMBOL) (default OPEN))   ; before it was checked
  (slot seen (type INTEGER) (default -1))   ; the world's version in which its conditions did not hold
  (slot held-for (type STRING) (default "")); why it was held back the last time
  (slot work (type INTEGER) (default 0)))   ; its job or instruction

(deftemplate effects
  "Effects of an action that are to come true: those with the smallest number next."
  (slot number (type INTEGER))
  (slot action (type SYMBOL))
  (slot time (type SYMBOL) (allowed-values START END ALL)))

(deftemplate waits-for
  "A step of the plan that begins after another one, because both use a product or the same side of a machine."
  (slot step (type SYMBOL))
  (slot for (type SYMBOL)))

(deftemplate follows
  "A step that the plan gives to the same robot after another one."
  (slot step (type SYMBOL))
  (slot after (type SYMBOL)))

(deftemplate planning
  "How far the next plan is. IDLE: nothing to plan. COPY: the world is copied. END: the copy assumes that every running step completes.
   GOALS: plans are made for the alternatives."
  (slot state (type SYMBOL) (allowed-values IDLE COPY END GOALS) (default IDLE)))

(deftemplate planned
  "When the last plan was made, or when there was nothing to plan, s of the game."
  (slot at (type FLOAT)))

(deftemplate begun
  "A step that began while a new plan was made, and whether the new plan has it, too."
  (slot action (type SYMBOL))
  (multislot params (type SYMBOL))
  (slot in-plan (type SYMBOL) (default FALSE)))

(deftemplate bare-shelf
  "A cap station for which no robot can fetch carriers: slots of its shelf are empty, or there is no way to them."
  (slot station (type SYMBOL))
  (slot since (type FLOAT)))   ; s of the game

(deftemplate replan
  "A new plan is wanted, for this reason."
  (slot reason (type STRING)))

(deftemplate robot-to-spare
  "A robot has nothing to do: the next plan may be for one product more.")

(deftemplate without-plan
  "No plan was found for our orders, and none has been wanted since."
  (slot since (type FLOAT)))

(deftemplate alternative
  "A set of orders, and the plan for it."
  (slot name (type SYMBOL))
  (multislot orders (type INTEGER))
  (slot state (type SYMBOL) (allowed-values NEW CLEARED PLANNING PLANNED WITHOUT-PLAN) (default NEW))
  (slot points (type FLOAT) (default 0.0))  ; that the plan earns
  (slot work (type FLOAT) (default 0.0)))   ; s of robots that it takes

(deftemplate skipped
  "An order without a plan in the present world. It is not proposed until a machine works again, a product is
   delivered, or there was nothing to do for a while."
  (slot order (type INTEGER))
  (slot since (type FLOAT)))

(deftemplate left-open
  "Why nobody works for an open order though there is nothing else to do. It is told once."
  (slot order (type INTEGER))
  (slot why (type STRING)))

(deffunction skip-no-more ()
  (do-for-all-facts ((?s skipped)) TRUE (retract ?s)))

(deffacts planning
  (planning)
  (world-version 0))

(deffunction look-again ()
  "Have the agent look again at the steps that it held back."
  (do-for-fact ((?v world-version)) TRUE
    (bind ?n (nth$ 1 ?v:implied))
    (retract ?v)
    (assert (world-version (+ ?n 1)))))

(deffunction game-time ()
  (do-for-fact ((?g game) (?t time)) TRUE (return (- (nth$ 1 ?t:implied) ?g:begin)))
  0.0)

(deffunction list-text (?text ?more)
  "Both texts, separated by a semicolon."
  (if (eq ?text "") then ?more else (str-cat ?text "; " ?more)))

; --- Names: the domain knows cs1, the league C-CS1

(deffunction pddl-name (?machine)
  (sym-cat (lowcase (sub-string 3 (str-length ?machine) ?machine))))

(deffunction product-of (?order)
  (sym-cat o ?order))

(deffunction order-of (?product)
  (string-to-field (sub-string 2 (str-length ?product) ?product)))

(deffunction machine-named (?name)
  (do-for-fact ((?w we-are)) TRUE (return (str-cat (nth$ 1 ?w:implied) "-" (upcase ?name))))
  "")
