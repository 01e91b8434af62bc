; As typed at the prompt of CLIPS. Facts that are asserted here go with the reset that follows.
(set-strategy breadth)
(printout t "the strategy is " (get-strategy) crlf)
