; Finds the goal of a grid that it cannot see: steps into cells that it does not know, and where there is none goes back
; the way it came. It learns of walls by bumping into them.

(deftemplate direction
  (slot name)
  (slot opposite)
  (slot rows)
  (slot columns))

(deftemplate cell
  "A cell that is known. The robot goes back from it in that direction; NONE from where it began."
  (slot row)
  (slot column)
  (slot is (allowed-values FREE WALL))
  (slot back (default NONE)))

(deftemplate robot
  "Where it is, and in which direction it is on its way; NONE: it stands and may go."
  (slot row)
  (slot column)
  (slot going))

(deffacts compass
  (direction (name north) (opposite south) (rows -1) (columns 0))
  (direction (name east) (opposite west) (rows 0) (columns 1))
  (direction (name south) (opposite north) (rows 1) (columns 0))
  (direction (name west) (opposite east) (rows 0) (columns -1)))

(deffunction ask-to-move (?direction)
  (bind ?request (grid-move-request-create))
  (grid-move-request-set-field ?request "direction" ?direction)
  (grid-move-send-request ?request "/grid/move")
  (grid-move-request-destroy ?request))

(deffacts start (look))

(defrule look
  "At the start: ask where the robot is."
  ?look <- (look)
  =>
  (retract ?look)
  (grid-move-create-client "/grid/move")
  (ask-to-move stay))

(defrule hear
  "The robot has answered."
  ?response <- (grid-move-response (msg-ptr ?message))
  =>
  (assert (answer (grid-move-response-get-field ?message "moved")
                  (grid-move-response-get-field ?message "row")
                  (grid-move-response-get-field ?message "column")
                  (grid-move-response-get-field ?message "at_goal")))
  (grid-move-response-destroy ?message)
  (retract ?response))

(defrule begin
  "The first answer says where the robot is."
  ?answer <- (answer TRUE ?row ?column FALSE)
  (not (robot))
  =>
  (retract ?answer)
  (assert (robot (row ?row) (column ?column) (going NONE)) (cell (row ?row) (column ?column) (is FREE))))

(defrule arrive
  "The robot has moved: what it may not have known, it knows now."
  ?answer <- (answer TRUE ?row ?column FALSE)
  ?robot <- (robot (going ?going))
  (direction (name ?going) (opposite ?back))
  =>
  (retract ?answer)
  (modify ?robot (row ?row) (column ?column) (going NONE))
  (if (not (any-factp ((?cell cell)) (and (eq ?cell:row ?row) (eq ?cell:column ?column)))) then
    (assert (cell (row ?row) (column ?column) (is FREE) (back ?back)))))

(defrule stop
  "The robot is at the goal: it goes nowhere any more."
  (answer TRUE ?row ?column TRUE)
  =>
  (printout info "the goal is in row " ?row ", column " ?column crlf))

(defrule bump
  "The robot has not moved: there is a wall."
  ?answer <- (answer FALSE $?)
  ?robot <- (robot (row ?row) (column ?column) (going ?going))
  (direction (name ?going) (rows ?rows) (columns ?columns))
  =>
  (retract ?answer)
  (modify ?robot (going NONE))
  (assert (cell (row (+ ?row ?rows)) (column (+ ?column ?columns)) (is WALL))))

(defrule explore
  "There is a cell beside the robot that it does not know: go there."
  ?robot <- (robot (row ?row) (column ?column) (going NONE))
  (direction (name ?name) (rows ?rows) (columns ?columns))
  (not (cell (row =(+ ?row ?rows)) (column =(+ ?column ?columns))))
  =>
  (modify ?robot (going ?name))
  (ask-to-move ?name))

(defrule turn-back
  "All cells around are known: go back."
  ?robot <- (robot (row ?row) (column ?column) (going NONE))
  (forall (direction (rows ?rows) (columns ?columns))
          (cell (row =(+ ?row ?rows)) (column =(+ ?column ?columns))))
  (cell (row ?row) (column ?column) (back ?back&~NONE))
  =>
  (modify ?robot (going ?back))
  (ask-to-move ?back))

(defrule give-up
  "All that can be reached is known, and the game is not over."
  (robot (row ?row) (column ?column) (going NONE))
  (forall (direction (rows ?rows) (columns ?columns))
          (cell (row =(+ ?row ?rows)) (column =(+ ?column ?columns))))
  (cell (row ?row) (column ?column) (back NONE))
  =>
  (printout info "there is no way to the goal" crlf)
  (cx-shutdown))

(defrule close
  "The executive ends: close what is open."
  (executive-finalize)
  =>
  (grid-move-destroy-client "/grid/move"))
