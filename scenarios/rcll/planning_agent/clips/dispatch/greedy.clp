; strategy.dispatch: greedy. No plan: the rules of the rule agent choose orders, payments and the ways of products.

(defrule read-settings
  ?read <- (read-settings)
  =>
  (retract ?read)
  (read-settings-of-robots ?*PATIENCE* "nearest" "rested" "both"))
