; The game is paused: machines hear nothing, robots rest by themselves, and our clock stands still like the game's.

(deffunction postpone (?length)
  "Move all future times by the length of the pause that has ended."
  (delayed-do-for-all-facts ((?r robot)) TRUE (modify ?r (idle-since (+ ?r:idle-since ?length))))
  (delayed-do-for-all-facts ((?j job)) TRUE (modify ?j (not-before (+ ?j:not-before ?length))))
  (delayed-do-for-all-facts ((?u under-way)) TRUE (modify ?u (since (+ ?u:since ?length))))
  (delayed-do-for-all-facts ((?s shelf-refill)) TRUE (modify ?s (at (+ ?s:at ?length)))))

(defrule pause-time-stands
  "The game is paused: take the time away before any other rule sees it, so that nothing is due and nothing gets a date."
  (declare (salience 1000)) ; check: allow salience - no rule may see the time of a pause
  (game (state PAUSED))
  ?time <- (time ?)
  =>
  (retract ?time))
