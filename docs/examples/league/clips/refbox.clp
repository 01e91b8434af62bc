; What the referee box says becomes facts; what we ask of a machine is said again until it is at work.

(deftemplate game
  (slot phase (type SYMBOL))
  (slot state (type SYMBOL))
  (slot time (type INTEGER))) ; s of the phase

(deftemplate machine
  (slot name (type STRING))
  (slot state (type SYMBOL))
  (slot known (type SYMBOL))) ; TRUE: it takes instructions

(deftemplate order
  (slot id (type INTEGER))
  (slot complexity (type SYMBOL))
  (slot base (type SYMBOL))
  (slot cap (type SYMBOL))
  (slot begin (type INTEGER)))

(defrule refbox-game-state
  (protobuf-msg (type "llsf_msgs.GameState") (ptr ?m))
  =>
  (bind ?time (pb-field-value ?m "game_time"))
  (do-for-all-facts ((?g game)) TRUE (retract ?g))
  (assert (game (phase (pb-field-value ?m "phase")) (state (pb-field-value ?m "state"))
                (time (pb-field-value ?time "sec"))))
  (pb-destroy ?time))

(defrule refbox-machine-info
  (protobuf-msg (type "llsf_msgs.MachineInfo") (ptr ?m))
  =>
  (foreach ?machine (pb-field-list ?m "machines")
    (bind ?name (pb-field-value ?machine "name"))
    (bind ?state (sym-cat (pb-field-value ?machine "state")))
    (bind ?known (pb-field-value ?machine "correctly_reported"))
    (if (not (do-for-fact ((?f machine)) (eq ?f:name ?name)
               (if (or (neq ?f:state ?state) (neq ?f:known ?known)) then (modify ?f (state ?state) (known ?known)))
               TRUE))
     then (assert (machine (name ?name) (state ?state) (known ?known))))
    (pb-destroy ?machine)))

(defrule refbox-order-info
  (protobuf-msg (type "llsf_msgs.OrderInfo") (ptr ?m))
  =>
  (foreach ?o (pb-field-list ?m "orders")
    (bind ?id (pb-field-value ?o "id"))
    (if (not (any-factp ((?f order)) (= ?f:id ?id)))
     then (assert (order (id ?id) (complexity (pb-field-value ?o "complexity"))
                         (base (pb-field-value ?o "base_color")) (cap (pb-field-value ?o "cap_color"))
                         (begin (pb-field-value ?o "delivery_period_begin")))))
    (pb-destroy ?o)))

(deffunction prepare (?peer ?machine ?kind ?field ?value $?more)
  "Instructs a machine: kind is bs, cs or ds; more fields and values may follow."
  (bind ?instruction (pb-create (str-cat "llsf_msgs.PrepareInstruction" (upcase ?kind))))
  (pb-set-field ?instruction ?field ?value)
  (if (> (length$ ?more) 0) then (pb-set-field ?instruction (nth$ 1 ?more) (nth$ 2 ?more)))
  (bind ?message (pb-create "llsf_msgs.PrepareMachine"))
  (pb-set-field ?message "team_color" ?*COLOR*)
  (pb-set-field ?message "machine" ?machine)
  (pb-set-field ?message (str-cat "instruction_" ?kind) ?instruction)
  (pb-set-field ?message "sent_at" (integer (now)))
  (pb-broadcast ?peer ?message)
  (pb-destroy ?instruction)
  (pb-destroy ?message))
