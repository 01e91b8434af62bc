; What a trainer that chooses over cx_rl_interfaces is told (trainer.clp of the package cxlab_choices): an episode is a game.

(deffacts training
  (training (kinds begin-order take-job) (situation 8) (features 21)))

(defrule training-points
  "The league reports our points: they are the reward."
  (declare (salience 10)) ; before refbox-game-state, which destroys the message
  (ros-msgs-message (topic "/game_state") (msg-ptr ?m))
  (we-are ?letter)
  ?training <- (training (points ?points))
  =>
  (bind ?now (ros-msgs-get-field ?m (if (eq ?letter "C") then "points_cyan" else "points_magenta")))
  (if (<> ?now ?points) then (modify ?training (points ?now))))

(defrule training-game-is-over
  (game (phase POST_GAME))
  ?training <- (training (over FALSE))
  =>
  (modify ?training (over TRUE)))

(defrule training-next-game
  "Nobody can restart a game for us: the run ends, and the next episode is the next run."
  (or (reset-wanted)
      (training-is-over))
  =>
  (cx-shutdown))
