; Grasps what the eye has seen, and reports it.

(defrule grasp
  "The eye reports something."
  (seen ?what ?when)
  =>
  (printout info "grasping the " ?what ", seen at " ?when crlf)
  (bridge-send eye (str-cat "(grasped " ?what ")")))
