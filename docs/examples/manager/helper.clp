; Loaded at run time: no reset comes, so what happens has to start from the time fact.
(defrule help
  "The first refresh of this environment."
  (time ?now)
  (not (helping))
  =>
  (assert (helping))
  (println "helping since " ?now))
