; Templates and rules in one, for agents that define no template of their own. Needs cx::AmentIndexPlugin.
(batch* (str-cat (ament-index-get-package-share-directory "cx_pddl_clips") "/clips/cx_pddl_clips/saliences.clp"))
(batch* (str-cat (ament-index-get-package-share-directory "cx_pddl_clips") "/clips/cx_pddl_clips/deftemplates.clp"))
(batch* (str-cat (ament-index-get-package-share-directory "cx_pddl_clips") "/clips/cx_pddl_clips/pddl-no-deftemplates.clp"))
