; Exploration: while the league does not tell where our machines stand, robots look for them, and we report what they see.

(deffacts viewpoints
  "Column and row of zones from which robots see all of their half."
  (viewpoint 2 5) (viewpoint 4 6) (viewpoint 6 4) (viewpoint 3 2))

; --- What robots see

(defrule explore-listen
  "A machine is still to be found: subscribe to the sightings of each robot."
  (exists (to-find ?))
  (robot (name ?robot))
  =>
  (assert (topic (name (str-cat "/" ?robot "/sightings")) (type "cxlab_skills/msg/Sightings"))))

(deffunction learn-sighting (?zone ?machine ?rotation)
  "Note what stands in a zone. A sighting with the machine's name replaces one without it."
  (if (or (not (any-factp ((?s sighting)) (eq ?s:zone ?zone)))
          (and (neq ?machine "") (do-for-fact ((?s sighting)) (and (eq ?s:zone ?zone) (eq ?s:machine "")) (retract ?s) TRUE)))
   then (assert (sighting (zone ?zone) (machine ?machine) (rotation ?rotation)))))

(defrule explore-seen
  (topic (name ?topic) (type "cxlab_skills/msg/Sightings"))
  ?message <- (ros-msgs-message (topic ?topic) (msg-ptr ?m))
  =>
  (foreach ?s (ros-msgs-get-field ?m "machines")
    (learn-sighting (ros-msgs-get-field ?s "zone") (ros-msgs-get-field ?s "machine") (ros-msgs-get-field ?s "rotation"))
    (ros-msgs-destroy-message ?s))
  (ros-msgs-destroy-message ?m)
  (retract ?message))

(deffunction mirrored (?name)
  "The machine or zone in the mirror: M-CS1 for C-CS1, M_Z23 for C_Z23."
  (str-cat (if (eq (sub-string 1 1 ?name) "C") then "M" else "C") (sub-string 2 5 ?name)))

(deffunction mirrored-rotation (?machine ?zone ?rotation)
  "The rotation in the mirror. A shelf or slide at the border faces away from the wall on either half."
  (if (or (str-index "CS" ?machine) (str-index "RS" ?machine))
   then (if (member$ (sub-string 5 5 ?zone) (create$ "1" "8")) then (return ?rotation))
        (if (eq (sub-string 4 4 ?zone) "7") then (return (- 360 ?rotation))))
  (mod (- 540 ?rotation) 360))

(defrule explore-mirror
  "The field is its own mirror image: a machine on one half tells where the other team's machine stands."
  (sighting (machine ?machine&~"") (zone ?zone) (rotation ?rotation))
  (not (sighting (machine =(mirrored ?machine))))
  =>
  (learn-sighting (mirrored ?zone) (mirrored ?machine) (mirrored-rotation ?machine ?zone ?rotation)))

; --- What we tell

(defrule explore-report-open
  (exists (to-find ?))
  (not (ros-msgs-publisher (topic "/machine_report")))
  (not (executive-finalize))
  =>
  (ros-msgs-create-publisher "/machine_report" "rcll_interfaces/msg/MachineReport"))

(defrule explore-report
  "One of our machines was seen: report it once. The league answers in its report of the machine."
  (game (phase PRODUCTION))
  (to-find ?name)
  (sighting (machine ?name) (zone ?zone) (rotation ?rotation))
  (ros-msgs-publisher (topic "/machine_report"))
  (not (reported ?name))
  =>
  (assert (reported ?name))
  (bind ?entry (ros-msgs-create-message "rcll_interfaces/msg/MachineReportEntry"))
  (ros-msgs-set-field ?entry "name" ?name)
  (ros-msgs-set-field ?entry "zone" ?zone)
  (ros-msgs-set-field ?entry "rotation" ?rotation)
  (bind ?report (ros-msgs-create-message "rcll_interfaces/msg/MachineReport"))
  (ros-msgs-set-field ?report "machines" (create$ ?entry))
  (ros-msgs-publish ?report "/machine_report")
  (ros-msgs-destroy-message ?entry)
  (ros-msgs-destroy-message ?report))

(defrule explore-found
  "The league tells where the machine stands, because we reported it or exploration is over: stop looking for it."
  ?find <- (to-find ?name)
  (machine (name ?name))
  =>
  (retract ?find))

; --- Where robots look

(defrule explore-viewpoint
  (exists (to-find ?))
  (we-are ?letter)
  (viewpoint ?column ?row)
  =>
  (assert (to-look (zone (str-cat ?letter "_Z" ?column ?row)) (skill drive_to))))

(defrule explore-unread
  "Something stands on our half, and no robot has read its markers: look at that zone."
  (logical (we-are ?letter)
           (sighting (zone ?zone&:(eq ?letter (sub-string 1 1 ?zone))) (machine "")))
  =>
  (assert (to-look (zone ?zone) (skill explore))))

(defrule explore-done
  "All machines that we wanted to find are reported: stop looking."
  ?look <- (to-look)
  (not (and (to-find ?name) (not (reported ?name))))
  =>
  (retract ?look))

(deffunction way-to-look (?x ?y ?zone ?skill)
  "The way to a zone in m, with 20 m added where no marker is known to wait there."
  (+ (distance ?x ?y (zone-x ?zone) (zone-y ?zone)) (if (eq ?skill explore) then 0 else 20)))

(defrule explore-go
  "A zone is to be looked at: the idle robot with the shortest way goes there."
  (game (phase PRODUCTION))
  ?look <- (to-look (zone ?zone) (skill ?skill))
  ?robot <- (robot (name ?name) (state IDLE) (x ?x) (y ?y))
  (not (and (to-look (zone ?z) (skill ?s))
            (robot (state IDLE) (x ?rx) (y ?ry&:(< (way-to-look ?rx ?ry ?z ?s) (way-to-look ?x ?y ?zone ?skill))))))
  =>
  (retract ?look)
  (decide (str-cat ?name " for a look at " ?zone)
          (format nil "%.1f m to go: the shortest way%s" (distance ?x ?y (zone-x ?zone) (zone-y ?zone)) (if (eq ?skill explore) then " to what can be read" else "")))
  (roam ?robot ?skill ?zone))

(defrule finalize-publishers
  (executive-finalize)
  (ros-msgs-publisher (topic ?topic))
  =>
  (ros-msgs-destroy-publisher ?topic))
