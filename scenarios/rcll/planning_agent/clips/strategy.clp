; The files of the strategy that strategy.dispatch names: robots work by plans, whose steps begin as a file of dispatch/ says, or
; by the rules of the rule agent (greedy).

(deffunction load-files (?package $?files)
  (bind ?folder (ament-index-get-package-share-directory ?package))
  (if (not ?folder) then (return))  ; ament-index has said so
  (foreach ?file ?files
    (load* (str-cat ?folder "/clips/" ?file ".clp"))))

(load-files "rcll_planning_agent" parameters)

(deffunction groups-ahead (?dispatch)
  "The n of the strategy lookahead:n, or 0 for groups; FALSE for any other strategy."
  (if (eq ?dispatch "groups") then (return 0))
  (if (neq (sub-string 1 10 ?dispatch) "lookahead:") then (return FALSE))
  (bind ?text (sub-string 11 (str-length ?dispatch) ?dispatch))
  (if (eq ?text "unlimited") then (return 1000000))
  (bind ?n (nth$ 1 (explode$ ?text)))
  (if (and (integerp ?n) (>= ?n 0) (eq (str-cat ?n) ?text)) then ?n else FALSE))

(deffunction dispatch-file ()
  (if (groups-ahead (ros-param-get-value "strategy.dispatch" "partial-order"))
   then groups
   else (sym-cat (one-of "strategy.dispatch" "partial-order" "external" "greedy" "groups" "lookahead:N, N >= 0" "lookahead:unlimited" "partial-order" "stn"))))

(deffunction load-strategy (?file)
  (if (eq ?file greedy)
   then
    (load-files "rcll_agent" facts skills pauses refbox jobs robots choose-jobs exploration payments shelves cap-stations worth orders
                             choose-orders products shared-machines trouble recovery maintenance repairs)
    (load-files "rcll_planning_agent" settings dispatch/greedy)
   else
    (if (eq ?file external) then (load-files "cxlab_choices" choices))
    (load-files "rcll_agent" facts skills pauses refbox jobs robots choose-jobs exploration shelves worth shared-machines trouble
                             maintenance repairs)
    (load-files "rcll_planning_agent" settings planning-facts durations risk foresight problem alternatives execution copy plan-order (sym-cat dispatch/ ?file)
                                      plans refinement agenda finish failures exchange)))

(load-strategy (dispatch-file))
