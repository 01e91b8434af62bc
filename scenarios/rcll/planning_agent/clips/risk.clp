; How often products are lost, learned from those that were: robots drop them, somebody takes them, machines break down. Until the
; first one is lost, plans are valued as if nothing could go wrong.

(defglobal
  ?*BROUGHT* = 0     ; products that robots have brought on from a machine
  ?*LOST* = 0        ; products that were lost at a machine or on the way from it
  ?*TRUST* = 10.0)   ; how many are thought to have been brought before the game

(deffunction chance-of (?transports)
  "The chance that a product survives so many transports from machine to machine."
  (** (- 1.0 (/ ?*LOST* (+ ?*LOST* ?*BROUGHT* ?*TRUST*))) ?transports))

(deffunction transports-of (?rings)
  "The number of transports of a product: from each ring station and the cap station to the next machine."
  (+ 1 (length$ ?rings)))

(deffunction note-brought (?action)
  "Count a product that a robot has brought to its next machine."
  (if (member$ ?action (create$ transport bring-to-delivery)) then (bind ?*BROUGHT* (+ ?*BROUGHT* 1))))

(defrule risk-begins
  "A product lies on its first machine: from now on it can be lost."
  (pddl-fluent (instance production) (name at-input) (params ?product ?))
  (not (pddl-fluent (instance production) (name not-begun) (params ?product)))
  (not (can-be-lost ?product))
  =>
  (assert (can-be-lost ?product)))

(defrule risk-lost
  "A product begins again: it was lost. If its order is open again, it was given up, which does not count."
  ?can-be-lost <- (can-be-lost ?product)
  (pddl-fluent (instance production) (name not-begun) (params ?product))
  (order (id ?id&:(eq ?product (product-of ?id))) (state ?state))
  =>
  (retract ?can-be-lost)
  (if (eq ?state STARTED) then (bind ?*LOST* (+ ?*LOST* 1))))
