; What an order earns, and what it costs.

(defglobal ?*C0-TIME* = 120.0)      ; time from the start of a C0 to its delivery, s
(defglobal ?*RING-TIME* = 80.0)     ; more time for each ring, s
(defglobal ?*EARLY* = 60.0)         ; how long a product may wait for its window, s

(deffunction price-of (?work)
  "The number of payments that a work needs."
  (do-for-fact ((?d does)) (eq ?d:work ?work) (return ?d:price))
  0)

(deffunction time-to-make (?rings)
  (+ ?*C0-TIME* (* ?*RING-TIME* (length$ ?rings))))

(deffunction late-share (?late ?window)
  "The share of the delivery's points that is lost if the product comes so long after its window."
  (if (<= ?late 0) then 0 else (* 0.1875 (min 4 (+ 1 (div (* 4 ?late) ?window))))))

(deffunction points-of (?complexity ?rings ?bonus ?late ?window)
  "The points of a product: delivery, cap, rings with their payments, and a bonus."
  (bind ?delivery (switch ?complexity (case "C0" then 20) (case "C1" then 30) (case "C2" then 50) (default 100)))
  (bind ?points (+ (* ?delivery (- 1 (late-share ?late ?window))) 12 ?bonus))
  (foreach ?ring ?rings
    (bind ?points (+ ?points (switch (price-of ?ring) (case 0 then 5) (case 1 then 12) (default 24)))))
  ?points)

(deffunction jobs-of (?rings)
  "How many jobs of robots an order needs: to the cap station, to the delivery station, the carrier in and out, each ring and payment."
  (bind ?jobs 4)
  (foreach ?ring ?rings (bind ?jobs (+ ?jobs 1 (price-of ?ring))))
  ?jobs)

(deffunction worth (?complexity ?rings ?bonus ?begin ?end ?time)
  "The points for each job, if the order is begun at this time of the game; 0 if no time is left for it."
  (bind ?ready (+ ?time (time-to-make ?rings)))
  (if (> ?ready ?*GAME*) then (return 0.0))
  (if (< ?ready (- ?begin ?*EARLY*)) then (return 0.0))
  (/ (points-of ?complexity ?rings ?bonus (- ?ready ?end) (- ?end ?begin)) (jobs-of ?rings)))

(deffunction machines-for (?works)
  "The machines that do these works, one after the other; nothing if one of them is not known yet."
  (bind ?machines (create$))
  (foreach ?work ?works
    (if (not (do-for-fact ((?d does)) (eq ?d:work ?work) (bind ?machines (create$ ?machines ?d:machine)) TRUE))
     then (return (create$))))
  ?machines)

(deffunction works-for (?rings ?cap)
  (create$ ?rings ?cap "DELIVER"))
