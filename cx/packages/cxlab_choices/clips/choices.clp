; Choices that somebody outside makes: a learned policy, a program, a person. Rules assert a fact `choice`; it goes out on the topic
; `choices`. The answer comes on the topic `choices/made` and becomes a fact `choice-made`, on which the rules act before they
; retract the choice. Without an answer the choice falls on the option that the rules prefer.

(defglobal
  ?*PATIENCE-FOR-CHOICE* = 1.0  ; s for an answer
  ?*ANSWERED* = TRUE            ; FALSE: nobody answers, so the rules choose at once
  ?*last-choice* = 0)

(deftemplate choice
  "A choice among options. It never changes; to withdraw it, retract it."
  (slot id (type INTEGER))
  (slot kind (type SYMBOL))        ; what is chosen
  (slot who (type STRING))         ; for whom: a robot; empty: the team
  (multislot items)                ; the options as the agent knows them
  (multislot options)              ; the same for people
  (multislot allowed)              ; TRUE, FALSE: which may be chosen
  (slot preferred (type INTEGER))  ; what the rules would choose, from 1
  (multislot situation)            ; features of the situation
  (multislot features)             ; features of the options, one option after the other
  (slot since (type FLOAT)))

(deftemplate choice-made
  "The answer to a choice."
  (slot choice (type INTEGER))
  (slot option (type INTEGER)))    ; from 1

(deffunction new-choice ()
  (bind ?*last-choice* (+ ?*last-choice* 1))
  ?*last-choice*)

(deffunction share (?value ?most)
  "A feature: the value as a share of the largest likely value, between -1 and 1."
  (max -1.0 (min 1.0 (/ ?value ?most))))

(deffunction flag (?condition)
  "A feature: 1.0 or 0.0."
  (if ?condition then 1.0 else 0.0))

(deffunction made-item (?choice ?option)
  "The item of the option that was chosen."
  (nth$ ?option (fact-slot-value ?choice items)))

; --- Out

(defrule choices-publish
  (not (ros-msgs-publisher (topic "choices")))
  (not (executive-finalize))
  =>
  (ros-msgs-create-publisher "choices" "cxlab_msgs/msg/Choice"))

(defrule choices-ask
  "A choice is new: ask for it once."
  (choice (id ?id) (kind ?kind) (who ?who) (options $?options) (allowed $?allowed) (preferred ?preferred)
          (situation $?situation) (features $?features))
  (ros-msgs-publisher (topic "choices"))
  =>
  (bind ?m (ros-msgs-create-message "cxlab_msgs/msg/Choice"))
  (ros-msgs-set-field ?m "id" ?id)
  (ros-msgs-set-field ?m "kind" ?kind)
  (ros-msgs-set-field ?m "who" ?who)
  (ros-msgs-set-field ?m "options" ?options)
  (ros-msgs-set-field ?m "allowed" ?allowed)
  (ros-msgs-set-field ?m "preferred" (- ?preferred 1))
  (ros-msgs-set-field ?m "situation" ?situation)
  (ros-msgs-set-field ?m "features" ?features)
  (ros-msgs-publish ?m "choices")
  (ros-msgs-destroy-message ?m))

; --- In

(defrule choices-listen
  (not (ros-msgs-subscription (topic "choices/made")))
  (not (executive-finalize))
  =>
  (ros-msgs-create-subscription "choices/made" "cxlab_msgs/msg/ChoiceMade"))

(deffunction take-answer (?id ?option)
  "Take an answer. Refuse an option that may not be chosen, and ignore an answer to a withdrawn choice."
  (bind ?*ANSWERED* TRUE)
  (do-for-fact ((?c choice)) (= ?c:id ?id)
    (if (and (<= 1 ?option (length$ ?c:allowed)) (nth$ ?option ?c:allowed))
     then (assert (choice-made (choice ?id) (option ?option)))
     else (printout warn "choice " ?id " (" ?c:kind "): option " (- ?option 1) " may not be chosen; ignored" crlf))))

(defrule choices-answered
  ?message <- (ros-msgs-message (topic "choices/made") (msg-ptr ?m))
  =>
  (take-answer (ros-msgs-get-field ?m "id") (+ 1 (ros-msgs-get-field ?m "option")))
  (ros-msgs-destroy-message ?m)
  (retract ?message))

(defrule choices-unanswered
  "Nobody answers in time: the agent does what its rules prefer. From now on it does not wait, until somebody answers."
  (choice (id ?id) (kind ?kind) (preferred ?option) (since ?since))
  (not (choice-made (choice ?id)))
  (time ?now&:(>= ?now (+ ?since (if ?*ANSWERED* then ?*PATIENCE-FOR-CHOICE* else 0.0))))
  =>
  (if ?*ANSWERED*
   then (printout warn "nobody answers choice " ?id " (" ?kind ") on the topic choices/made: the rules choose by themselves" crlf))
  (bind ?*ANSWERED* FALSE)
  (assert (choice-made (choice ?id) (option ?option))))

(defrule choices-over
  "The agent has acted on the choice, or withdrew it: forget the question."
  ?made <- (choice-made (choice ?id))
  (not (choice (id ?id)))
  =>
  (retract ?made))

; --- The end

(defrule choices-finalize-publisher
  (executive-finalize)
  (ros-msgs-publisher (topic "choices"))
  =>
  (ros-msgs-destroy-publisher "choices"))

(defrule choices-finalize-subscription
  (executive-finalize)
  (ros-msgs-subscription (topic "choices/made"))
  =>
  (ros-msgs-destroy-subscription "choices/made"))
