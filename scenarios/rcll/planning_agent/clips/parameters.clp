; Parameters of the node, checked before they are used.

(deffunction one-of (?parameter ?default $?words)
  "Read a parameter of the node that is one of these words. With any other word the agent gives up: it would play another game."
  (bind ?value (ros-param-get-value ?parameter ?default))
  (if (member$ ?value ?words) then (return ?value))
  (printout error ?parameter ": found '" ?value "', expected one of: " (implode$ ?words) crlf)
  (cx-shutdown)
  ?default)

(deffunction at-least (?least ?parameter ?default)
  "Reads a number, whole if the default is, from a parameter of the node. Reports one that is smaller, or nan, and takes the default."
  (bind ?value (ros-param-get-value ?parameter ?default))
  (if (and (= ?value ?value) (>= ?value ?least)) then (return ?value)) ; nan equals nothing
  (printout error ?parameter ": found " ?value ", expected a " (if (integerp ?default) then "whole " else "") "number of at least "
                  ?least "; taken: " ?default crlf)
  ?default)
