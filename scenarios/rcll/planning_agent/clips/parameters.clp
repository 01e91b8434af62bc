; Parameters of the node, looked at before they are used.

(deffunction one-of (?parameter ?default $?words)
  "A parameter of the node that is one of these words. Any other word is reported, and the agent gives up: it would play another game."
  (bind ?value (ros-param-get-value ?parameter ?default))
  (if (member$ ?value ?words) then (return ?value))
  (printout error ?parameter ": found '" ?value "', expected one of: " (implode$ ?words) crlf)
  (cx-shutdown)
  ?default)

(deffunction at-least (?least ?parameter ?default)
  "A parameter of the node that is a number, whole if the default is; of a smaller one, or nan, it is said, and the default is taken."
  (bind ?value (ros-param-get-value ?parameter ?default))
  (if (and (= ?value ?value) (>= ?value ?least)) then (return ?value)) ; nan equals nothing
  (printout error ?parameter ": found " ?value ", expected a " (if (integerp ?default) then "whole " else "") "number of at least "
                  ?least "; taken: " ?default crlf)
  ?default)
