; A product goes from machine to machine until it is delivered. Before it moves, it reserves the next machine. It keeps the machine
; where it lies until a robot has it.

(defglobal ?*DELIVERY-LEAD* = 45.0)  ; how long before the window a product is fetched for the delivery station, s

(deffunction move-product (?product ?urgency ?next $?held-up)
  "Add the job that brings a product from its place to the next machine; it is held up until the robot can fetch the product."
  (bind ?at (fact-slot-value ?product at))
  (bind ?id (create-job MOVE ?urgency (fact-slot-value ?product order) (output-of ?at) (input-of ?next)))
  (if (any-factp ((?m machine)) (and (eq ?m:name ?at) (eq ?m:kind BS))) then (hold-up ?id GO-FETCH))
  (hold-up ?id FETCH ?held-up)
  (modify ?product (job ?id)))

; --- To the next machine

(defrule product-to-ring-station
  "The ring station is free, or keeps this product already: move the product there. It must not wait for a product that waits
   for it: none that must still come here is on a machine which this one needs later."
  ?product <- (product (order ?id) (via ?next $?after) (keeps $?keeps) (job 0) (state READY|WORKING))
  (machine (name ?next) (kind RS))
  (not (product (order ~?id) (keeps $? ?next $?)))
  (not (product (order ~?id) (keeps $? ?later&:(and (member$ ?later ?after) (not (member$ ?next ?keeps))) $?) (via $? ?next $?)))
  =>
  (move-product (modify ?product (keeps ?keeps ?next)) 3 ?next PUT))

(defrule product-to-cap-station
  "The cap station is free, and it has its cap or a robot is there to take away the bare base: move the product there."
  ?product <- (product (order ?id) (via ?next $?) (keeps $?keeps) (job 0) (state READY|WORKING))
  (or (cap-station (name ?next) (phase LOADED))
      (job (purpose CLEAR) (station ?next) (step GO-FETCH|FETCH)))
  (not (product (order ~?id) (keeps $? ?next $?)))
  =>
  (move-product (modify ?product (keeps ?keeps ?next)) 3 ?next PUT))

(defrule product-to-delivery
  "The product is complete and its window is near: bring it to the delivery station."
  ?product <- (product (order ?id) (todo "DELIVER") (via ?next) (job 0) (state READY|WORKING))
  (order (id ?id) (begin ?begin))
  (game (begin ?zero))
  (time ?now&:(> ?now (- (+ ?zero ?begin) ?*DELIVERY-LEAD*)))
  =>
  (move-product ?product 1 ?next GO-PUT))

(defrule product-fetchable
  "The machine has done its work: the robot may take the product."
  (product (job ?job) (at ?at) (state READY))
  (machine (name ?at) (kind ~BS))
  ?held <- (held-up (job ?job) (step FETCH))
  =>
  (retract ?held))

(defrule product-fetched
  "A robot has the product: the machine where it lay is free."
  (job (id ?job) (purpose MOVE) (step GO-PUT|DONE))
  ?product <- (product (job ?job) (keeps $?keeps) (state READY))
  =>
  (modify ?product (keeps (rest$ ?keeps)) (state MOVING)))

(defrule product-may-be-put
  "The next machine is idle, and a cap station has its cap: the robot may put the product down."
  (job (id ?job) (purpose MOVE) (step GO-FETCH|FETCH|PUT))
  (product (job ?job) (via ?next $?))
  (machine (name ?next) (state IDLE))
  (not (cap-station (name ?next) (phase ~LOADED)))
  (not (instruction (machine ?next) (operation "RESET")))
  ?held <- (held-up (job ?job) (step PUT))
  =>
  (retract ?held))

(defrule product-put
  "The product lies on the input of the next machine: it waits for its work."
  ?job <- (job (id ?id) (purpose MOVE) (step DONE) (robot ""))
  ?product <- (product (job ?id) (via ?next $?) (state MOVING))
  =>
  (retract ?job)
  (modify ?product (at ?next) (state WAITING)))

; --- In a machine

(deffunction begin-work (?product ?operation ?color ?order)
  "Instruct the machine on whose input the product lies."
  (assert (instruction (id (fact-slot-value ?product job)) (machine (fact-slot-value ?product at)) (operation ?operation)
                       (color ?color) (order ?order)))
  (modify ?product (job 0) (state WORKING)
                   (todo (rest$ (fact-slot-value ?product todo))) (via (rest$ (fact-slot-value ?product via))))
  (count-payments))

(defrule product-mount-ring
  "The payments for the ring lie on the slide: have the ring mounted."
  ?product <- (product (todo ?ring $?) (at ?name) (state WAITING))
  (does (machine ?name) (work ?ring) (price ?price))
  ?slide <- (slide (machine ?name) (loaded ?loaded&:(>= ?loaded ?price)))
  (machine (name ?name) (state IDLE))
  =>
  (modify ?slide (loaded (- ?loaded ?price)))
  (begin-work ?product "MOUNT_RING" ?ring 0))

(defrule product-mount-cap
  ?product <- (product (at ?name) (state WAITING))
  ?station <- (cap-station (name ?name) (phase LOADED))
  =>
  (modify ?station (phase EMPTY))
  (begin-work ?product "MOUNT_CAP" "" 0))

(defrule product-deliver
  "The product lies at the delivery station and its window is open: deliver it."
  ?product <- (product (order ?id) (todo "DELIVER") (state WAITING))
  (order (id ?id) (begin ?begin))
  (game (begin ?zero))
  (time ?now&:(>= ?now (+ ?zero ?begin)))
  =>
  (begin-work ?product "DELIVER" "" ?id))

(defrule product-ready
  "The machine has done its work: the product is ready at the output."
  ?instruction <- (instruction (machine ?name) (operation "MOUNT_RING"|"MOUNT_CAP") (state SUCCEEDED))
  ?product <- (product (at ?name) (state WORKING))
  =>
  (retract ?instruction)
  (modify ?product (state READY)))

(defrule product-delivered
  ?delivered <- (delivered ?id SUCCEEDED)
  ?product <- (product (order ?id))
  ?order <- (order (id ?id))
  =>
  (retract ?delivered ?product)
  (modify ?order (state DONE)))

; --- What goes wrong: without its product an order is open again

(defrule product-gone-with-machine
  "The machine with the product broke down: the product is lost."
  (product (order ?id) (at ?name) (state ~MOVING))
  (machine (name ?name) (kind ~BS) (state BROKEN))
  (not (job (purpose MOVE) (order ?id)))
  =>
  (assert (lost ?id)))

(defrule product-work-failed
  "The machine did not do its work: the product is lost, and payments for a ring stay if the machine is not broken."
  ?instruction <- (instruction (machine ?name) (operation ?operation&"MOUNT_RING"|"MOUNT_CAP") (color ?work) (state FAILED)
                               (error ?error))
  (machine (name ?name) (state ?state))
  =>
  (printout warn ?operation " at " ?name " failed: " ?error crlf)
  (retract ?instruction)
  (if (neq ?state BROKEN) then (unpay ?name (price-of ?work)))
  (do-for-fact ((?p product)) (and (eq ?p:at ?name) (eq ?p:state WORKING)) (assert (lost ?p:order))))

(defrule product-not-delivered
  ?delivered <- (delivered ?id FAILED)
  =>
  (retract ?delivered)
  (assert (lost ?id)))

(defrule product-lost
  "A product is lost: its order is open again, and the job that brings the product or waits for it is given up."
  ?lost <- (lost ?id)
  ?product <- (product (order ?id) (job ?job))
  ?order <- (order (id ?id))
  =>
  (retract ?lost ?product)
  (decide (str-cat "open order " ?id " again") "its product is lost")
  (modify ?order (state OPEN))
  (do-for-all-facts ((?r reserved)) (= ?r:job ?job) (retract ?r))
  (do-for-fact ((?j job)) (= ?j:id ?job) (if (neq ?j:step GIVEN-UP) then (assert (trouble (job ?job) (kind GONE)))))
  (count-payments))
