; Grasps what the eye has seen, and says so.

(defrule grasp
  "The eye tells of something."
  (seen ?what ?when)
  =>
  (printout info "grasping the " ?what ", seen at " ?when crlf)
  (bridge-send eye (str-cat "(grasped " ?what ")")))
