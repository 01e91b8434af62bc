; The files of the strategy: strategy.dispatch says whether the robots work by plans or, greedy, by the rules of the rule agent.

(deffunction load-files (?package $?files)
  (foreach ?file ?files
    (load* (str-cat (ament-index-get-package-share-directory ?package) "/clips/" ?file ".clp"))))

(if (eq (ros-param-get-value "strategy.dispatch" "partial-order") "greedy")
 then
  (load-files "rcll_agent" facts skills pauses refbox jobs robots exploration payments shelves cap-stations worth orders products
                           shared-machines trouble recovery maintenance repairs)
  (load-files "rcll_planning_agent" settings greedy)
 else
  (load-files "rcll_agent" facts skills pauses refbox jobs robots exploration shelves worth shared-machines trouble maintenance
                           repairs)
  (load-files "rcll_planning_agent" settings planning-facts problem alternatives execution copy plans refinement agenda finish
                                    failures exchange))
