"""What rules of a stranger try, and how it ends. tests/app/attacks.py plays the rows; tests/support/rows.py has their form."""

import os
from lab import SCENARIO
from rows import Row

CONFIG = """/**:
  ros__parameters:
    environments: ["main"]
    main: {plugins: ["executive", "ros_msgs", "ament", "config", "params", "tf", "files"]}
    executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 10}
    ros_msgs: {plugin: "cx::RosMsgsPlugin"}
    ament: {plugin: "cx::AmentIndexPlugin"}
    config: {plugin: "cx::ConfigPlugin"}
    params: {plugin: "cx::RosParamPlugin"}
    tf: {plugin: "cx::Tf2PoseTrackerPlugin"}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["rules"], load: ["rules.clp"]}
"""

SECRET = "S3CRET"
FIXED = {
    "agent.yaml": CONFIG,
    "scenario.yaml": SCENARIO + "servers: [pddl_manager]\n",
    "outside/secret.txt": SECRET,
    "outside/secret.clp": f"(deffacts {SECRET} ({SECRET}))\n",
    "outside/secret.proto": f"message M {{ optional {SECRET} a = 1; }}\n",
    "rules/proto": lambda path: os.symlink("../outside", path),
    "outside/secret.yaml": f"secret: {SECRET}\n",
    "outside/secret.pddl": "(define (domain other))\n",
    "outside/msg/Secret.msg": f"string {SECRET}\n",
    "outside/victim.txt": "mine\n",
    "rules/link": lambda path: os.symlink("../outside/secret.clp", path),
    "rules/folder": lambda path: os.symlink("../outside", path),
    "rules/fifo": os.mkfifo,
    "rules/zero": lambda path: os.symlink("/dev/zero", path),
}

RUN = ["run", "scenario.yaml", "--quiet", "--out", "out"]


def act(actions):
    return f"(defrule stranger\n  =>\n  {actions})\n"


def attack(name, rules, code, command=("--memory", "50MB"), **more):
    return Row(name, [*RUN, *command], code, {"rules/rules.clp": rules}, never=[SECRET], **more)


def prints(name, rules, code=0):
    """The log of these rules shows what came of it."""
    return Row(name, [a for a in RUN if a != "--quiet"], code, {"rules/rules.clp": rules}, never=[SECRET])


# --- files that rules may not read

READERS = {
    "open": '(open "{}" f "r")',
    "open rb": '(open "{}" f "rb")',
    "load": '(load "{}")',
    "load*": '(load* "{}")',
    "batch": '(batch "{}")',
    "batch*": '(batch* "{}")',
    "load-facts": '(load-facts "{}")',
    "load-instances": '(load-instances "{}")',
    "restore-instances": '(restore-instances "{}")',
    "fetch": '(fetch "{}")',
    "bload": '(bload "{}")',
    "bload-facts": '(bload-facts "{}")',
    "bload-instances": '(bload-instances "{}")',
}
UNREADABLE = {
    "absolute": "{here}/outside/secret.clp",
    "parent": "../outside/secret.clp",
    "from a package": "{here}/rules/../outside/secret.clp",
    "from the run": "{here}/out/../outside/secret.clp",
    "link": "{here}/rules/link",
    "link to a folder": "{here}/rules/folder/secret.clp",
    "home": "~/secret.clp",
    "environment": "/proc/self/environ",
    "memory": "/proc/self/mem",
    "device": "/dev/zero",
    "terminal": "/dev/stdin",
    "device in a package": "{here}/rules/zero",
    "fifo in a package": "{here}/rules/fifo",
    "folder": "{here}/rules",
    "long": "/" + "a" * 5000,
    "many parts": "/a" * 3000 + "/../outside/secret.clp",
}

ROWS = {}
ROWS["reads"] = [attack(f"{function} {kind}", act(call.format(path)), 4)
                 for function, call in READERS.items() for kind, path in UNREADABLE.items()
                 if function in ("open", "load", "bload-facts") or kind in ("absolute", "link", "fifo in a package")]

ROWS["reads"] += [attack(f"open of the run's own {name}", act(f'(open "{{here}}/out/{name}" f "r")'), 4) for name in ("manifest.json", "inputs.bin", "logs/main.log", "written/../result.json")]
ROWS["reads"].append(attack("open of what rules wrote", act('(open "x" f "w") (close f) (open "{here}/out/written/x" f "r")'), 0))

WRITERS = {
    "open w": '(open "{}" f "w") (printout f "by rules" crlf) (close f)',
    "open a": '(open "{}" f "a") (printout f "by rules" crlf) (close f)',
    "open r+": '(open "{}" f "r+") (printout f "by rules" crlf) (close f)',
    "open w+": '(open "{}" f "w+") (printout f "by rules" crlf) (close f)',
    "open wb": '(open "{}" f "wb") (put-char f 65) (close f)',
    "save": '(save "{}")',
    "bsave": '(bsave "{}")',
    "save-facts": '(save-facts "{}")',
    "bsave-facts": '(bsave-facts "{}")',
    "save-instances": '(save-instances "{}")',
    "bsave-instances": '(bsave-instances "{}")',
    "dribble-on": '(dribble-on "{}") (printout t "by rules" crlf) (dribble-off)',
    "remove": '(printout t "removed: " (remove "{}") crlf)',
    "rename": '(printout t "renamed: " (rename "{}" "mine.txt") crlf)',
    "rename to": '(open "mine.txt" f "w") (close f) (printout t "renamed: " (rename "mine.txt" "{}") crlf)',
}
UNWRITABLE = {
    "absolute": "{here}/outside/victim.txt",
    "parent": "../outside/victim.txt",
    "package": "{here}/rules/rules.clp",
    "link": "{here}/rules/link",
    "manifest": "{here}/out/manifest.json",
    "inputs": "{here}/out/inputs.bin",
    "journal": "{here}/out/journal.jsonl",
    "index of copies": "{here}/out/files/index.jsonl",
    "out of the run": "{here}/out/written/../manifest.json",
    "home": "~/victim.txt",
    "device": "/dev/full",
    "long": "/" + "a" * 5000,
}
KEPT = {"manifest": {"out/manifest.json": '"command"'}, "out of the run": {"out/manifest.json": '"command"'}, "inputs": {"out/inputs.bin": "CXLABIN2"},
        "index of copies": {"out/files/index.jsonl": "scenario.yaml"}}
ROWS["writes"] = [attack(f"{function} {kind}", act(call.format(path)), 4 if kind in ("parent", "long") or function == "open r+" else 0, kept=KEPT.get(kind, {}))
                  for function, call in WRITERS.items() for kind, path in UNWRITABLE.items()
                  if function in ("open w", "remove", "rename to") or kind in ("absolute", "parent", "manifest")]
ROWS["writes"].append(attack("open w lands in the run", act(WRITERS["open w"].format("{here}/outside/victim.txt")), 0, kept={"out/written{here}/outside/victim.txt": "by rules"}))

# --- plugins, services and managers that read or write for rules


def calls(service, kind, fields, first=""):
    """Rules that call a service once it is there, and print its answer."""
    package, name = kind.split("/")
    sets = " ".join(f"(ros-msgs-set-field ?q \"{key}\" {value})" for key, value in fields.items())
    return f"""(defrule start => {first} (ros-msgs-create-client "{service}" "{package}/srv/{name}"))
(defrule call (ros-msgs-client (service ?s))
  => (bind ?q (ros-msgs-create-request "{package}/srv/{name}")) {sets}
  (printout t "sent: " (ros-msgs-async-send-request ?q ?s) crlf) (ros-msgs-destroy-message ?q))
(defrule answered (ros-msgs-response (msg-ptr ?r))
  => (printout t "answer: " (ros-msgs-get-field ?r "success") " " (ros-msgs-get-field ?r "error") crlf))
"""


def parameter(name, *values):
    return f'(ros-param-get-value "{name}" {"(create$ " + " ".join(values) + ")" if len(values) > 1 else values[0]})'


def load_plugin(name, **parameters):
    sets = " ".join(parameter(f"{name}.{key}", *(values if isinstance(values, tuple) else (values,))) for key, values in parameters.items())
    return calls("/clips_manager/load_plugin", "cx_msgs/LoadClipsPlugin", {"env_name": '"main"', "plugin_name": f'"{name}"'}, sets)


def instance(directory, domain, problem=""):
    return calls("/pddl_manager/add_pddl_instance", "cx_pddl_interfaces/AddPddlInstance",
                 {"name": '"x"', "directory": f'"{directory}"', "domain_file": f'"{domain}"', "problem_file": f'"{problem}"'})


def list_of(text):
    return f'(create$ "{text}")'


MANAGER = "/clips_manager/"
ROWS["plugins"] = [
    *[prints(f"config-load {kind}", act(f'(config-load "{path}" "secret")')) for kind, path in UNREADABLE.items()
      if kind not in ("environment", "memory", "many parts")],
    prints("config-load of deep yaml", act('(open "deep.yaml" f "w") (loop-for-count 20000 (printout f "[")) (close f) (config-load "deep.yaml" "/")')),
    prints("config-load of a cycle of aliases", act('(open "c.yaml" f "w") (printout f "a: &a {b: *a}" crlf) (close f) (config-load "c.yaml" "/")')),
    prints("config-load of many aliases", act("""(open "c.yaml" f "w") (printout f "a0: &a0 [x, x, x, x, x, x, x, x, x, x]" crlf)
  (loop-for-count (?i 1 12) (format f "a%d: &a%d [" ?i ?i) (loop-for-count 9 (format f "*a%d, " (- ?i 1))) (format f "*a%d]%n" (- ?i 1)))
  (close f) (config-load "c.yaml" "/")""")),
    prints("config-load of a map as key", act('(open "c.yaml" f "w") (printout f "{a: b}: c" crlf "[d]: e" crlf) (close f) (config-load "c.yaml" "/")')),
    *[prints(f"{function} {kind}", act(f'(printout t ({function} {argument}) crlf)'))
      for function in ("ament-index-get-resource", "ament-index-has-resource") for kind, argument in (
          ("parent", '"../outside" "secret.txt"'), ("absolute", '"{here}/outside" "secret.txt"'), ("parts", '"packages" "../../outside/secret.txt"'),
          ("nothing", '"" ""'))],
    prints("ament-index-get-resources parent", act('(printout t (ament-index-get-resources "../..") crlf)')),
    prints("ament-index share directory of a path", act('(printout t (ament-index-get-package-share-directory "../outside") crlf)')),
    *[attack(f"file load {kind}", load_plugin("stolen", plugin='"cx::FileLoadPlugin"', load=list_of(path)), 3)
      for kind, path in UNREADABLE.items()],
    attack("file load batch", load_plugin("stolen", plugin='"cx::FileLoadPlugin"', batch=list_of("{here}/outside/secret.clp")), 3),
    attack("file load cleanup_batch", load_plugin("stolen", plugin='"cx::FileLoadPlugin"', cleanup_batch=list_of("{here}/outside/secret.clp")), 3),
    attack("file load link of a package", load_plugin("stolen", plugin='"cx::FileLoadPlugin"', pkg_share_dirs=list_of("rules"), load=list_of("link")), 3),
    attack("file load folder of a package", load_plugin("stolen", plugin='"cx::FileLoadPlugin"', pkg_share_dirs=list_of("rules"), load=list_of("folder/secret.clp")), 3),
    attack("file load parent of a package", load_plugin("stolen", plugin='"cx::FileLoadPlugin"', pkg_share_dirs=list_of("rules"), load=list_of("../outside/secret.clp")), 3),
    attack("file load package of a path", load_plugin("stolen", plugin='"cx::FileLoadPlugin"', pkg_share_dirs=list_of("{here}/outside"), load=list_of("secret.clp")), 3),
    *[attack(f"proto file of {name}", load_plugin("stolen", plugin='"cx::ProtobufPlugin"', pkg_share_dirs=list_of("rules"), proto_paths=list_of(path)), 3)
      for name, path in [("a path", "{here}/outside"), ("a link", "folder"), ("the parent", "../outside")]],
    attack("proto files of the whole disk", load_plugin("stolen", plugin='"cx::ProtobufPlugin"', proto_paths=list_of("/")), 3),
    attack("proto files of a linked class", load_plugin("stolen", plugin='"cx::StolenProtobufPlugin"'), 3),
    attack("plugin class of a path", load_plugin("stolen", plugin='"{here}/outside/libevil.so"'), 3),
    attack("plugin class nothing", load_plugin("stolen", plugin='""'), 3),
    *[prints(f"environment {kind}", calls(MANAGER + "create_env", "cx_msgs/CreateClipsEnv", {"env_name": name}))
      for kind, name in (("parent", '"../../evil"'), ("absolute", '"/tmp/cxlab-evil"'), ("slash", '"a/b"'), ("nothing", '""'), ("dots", '".."'),
                         ("line", '"a\nb"'), ("long", f'"{"e" * 3000}"'), ("bytes", '(format nil "%c%c" 255 254)'), ("itself", '"main"'),
                         ("tags", '"<b>x</b>"'), ("escapes", '(format nil "%c[31m" 27)'))],
    *[attack(f"message {kind}", act(f'(ros-msgs-create-message {name})'), 4)
      for kind, name in (("of a path", '"{here}/outside/msg/Secret"'), ("parent", '"../outside/msg/Secret"'), ("parts", '"rules/../outside/msg/Secret"'),
                         ("msg parent", '"std_msgs/msg/../../../outside/msg/Secret"'), ("link", '"rules/folder/msg/Secret"'), ("nothing", '""'),
                         ("long", f'"{"a" * 5000}/msg/X"'), ("bytes", '(format nil "%c/msg/%c" 255 254)'), ("line", '"std_msgs/msg/String\n"'))],
    *[prints(f"pddl {kind}", instance(*where))
      for kind, where in (("absolute", ("{here}/outside", "secret.txt")), ("slash", ("/", "{here}/outside/secret.txt")), ("parent", ("{here}/rules", "../outside/secret.txt")),
                          ("fifo", ("{here}/rules", "fifo")), ("device", ("{here}/rules", "zero")), ("device outside", ("/dev", "zero")), ("folder", ("{here}", "rules")),
                          ("nothing", ("", "")), ("problem", ("{here}/outside", "secret.pddl", "secret.txt")), ("long", ("/" + "a" * 5000, "x.pddl")),
                          ("environment", ("/proc/self", "environ")), ("manifest", ("{here}/out", "manifest.json")))],
    *[prints(f"pddl template {kind}", act(f'(open "d.pddl" f "w") (printout f "{text}" crlf) (close f)') + instance("{here}/out/written", "d.pddl"))
      for kind, text in (("include", "{% include '{here}/outside/secret.txt' %}"), ("include parent", "{% include '../../outside/secret.txt' %}"),
                         ("include itself", "{% include 'd.pddl' %}"), ("extends", "{% extends '../../outside/secret.txt' %}"),
                         ("import", "{% import '../../outside/secret.txt' as x %}"), ("range", "{% for i in range(1000000000) %}x{% endfor %}"),
                         ("ranges", "{% for i in range(100000) %}{% for j in range(100000) %}x{% endfor %}{% endfor %}"),
                         ("power", "{{ 9**9**9**9 }}"), ("text", "{{ 'x' * 10000000000 }}"), ("recursion", "{% macro m() %}{{ m() }}{% endmacro %}{{ m() }}"),
                         ("class", "{{ ''.__class__.__mro__ }}"), ("division", "{{ 1 // 0 }}"), ("format", "{{ '%1000000000d' % 1 }}"),
                         ("deep", "(" * 3000))],
    *[attack(f"{maker} {kind}", act(f'(ros-msgs-create-{maker} {name} "{interface}")'), 4)
      for maker, interface in (("publisher", "std_msgs/msg/String"), ("subscription", "std_msgs/msg/String"), ("client", "std_srvs/srv/Trigger"),
                               ("service", "std_srvs/srv/Trigger"), ("action-client", "cxlab_skills/action/Pick"))
      for kind, name in (("nothing", '""'), ("parent", '"../x"'), ("line", '"a\nb"'), ("bytes", '(format nil "%c" 255)'), ("blank", '"a b"'))],
]

# --- memory of the process

HUGE, TINY = 9223372036854775807, -9223372036854775808
ROWS["corruption"] = [
    *[prints(f"format {kind}", act(f'(bind ?s (format nil {call})) (printout t "length " (str-length ?s) crlf)'))
      for kind, call in (("of a huge number", '"%f" 1e308'), ("width", '"%1000d" 1'), ("precision", '"%.600f" 0.1'), ("text", f'"%700s" "{"x" * 600}"'),
                         ("minus", '"%-99999s" x'), ("character", '"%c" 300'), ("zero", '"%c" 0'), ("tiny", f'"%d" {TINY}'), ("octal", '"%o" -1'),
                         ("hex", '"%0500x" 255'), ("exponent", '"%.400e" 1e-300'))],
    *[attack(f"format {kind}", act(f'(format nil {call})'), 4)
      for kind, call in (("too wide", '"%9999999d" 1'), ("too precise", '"%.2000000f" 1'), ("star", '"%*d" 5 5'), ("pointer", '"%p" 5'), ("number of written", '"%hn" 5'),
                         ("position", '"%1$s" x'), ("long flag", f'"%{"-" * 200}d" 5'), ("too few", '"%d %d" 1'), ("too many", '"%d" 1 2'), ("cut off", '"%5" 1'),
                         ("digits", f'"%{"9" * 60}d" 1'), ("wrong type", '"%d" x'))],
    *[prints(f"{kind}", act(f'(printout t "result " {call} crlf)'))
      for kind, call in (("sub-string huge", f'(sub-string {TINY} {HUGE} "abc")'), ("sub-string reversed", '(sub-string 3 1 "abc")'), ("sub-string of bytes", '(sub-string 2 2 "ä")'),
                         ("str-index nothing", '(str-index "" "abc")'), ("str-index long", '(str-index "abcd" "abc")'), ("upcase bytes", '(upcase (format nil "%c%c" 195 40))'),
                         ("string-to-field deep", f'(string-to-field "{"(" * 3000}")'), ("implode", '(implode$ (create$ "a" b 1))'),
                         ("sym-cat spaces", '(sym-cat "a b" "(c" ")")'), ("length", '(length$ (create$))'), ("replace-member", '(replace-member$ (create$ a b) (create$) a)'),
                         ("nth huge", f'(nth$ {HUGE} (create$ a))'), ("nth tiny", f'(nth$ {TINY} (create$ a))'), ("insert huge", f'(insert$ (create$ a) {HUGE} b)'),
                         ("subseq huge", f'(subseq$ (create$ a b) {HUGE} {HUGE})'), ("subseq tiny", f'(subseq$ (create$ a b) {TINY} {TINY})'))],
    *[attack(kind, act(f'(printout t "result " {call} crlf)'), 4)
      for kind, call in (("string-to-field quote", '(string-to-field (format nil "%c" 34))'), ("explode open quote", '(explode$ (format nil "a %cb" 34))'), ("delete huge", f'(delete$ (create$ a b) 1 {HUGE})'),
                         ("delete tiny", f'(delete$ (create$ a b) {TINY} 1)'), ("replace tiny", f'(replace$ (create$ a) {TINY} 1 b)'),
                         ("delete zero", '(delete$ (create$ a b) 0 0)'),
                         ("eval deep", '(eval (str-cat "(+ 1 " (implode$ (create$ x)) ))'), ("eval cut off", '(eval "(+ 1")'),
                         ("eval nested", f'(eval "{"(+ 1 " * 1200}{")" * 1200}")'), ("build nested", f'(build "(defrule x => {"(progn " * 1200}{")" * 1200})")'),
                         ("assert nested", f'(assert-string "(a {"(b " * 1200}{")" * 1200})")'), ("expand", '(funcall + (expand$ (create$ a b)))'),
                         ("funcall itself", '(funcall funcall funcall funcall)'))],
    *[attack(f"{reader} {kind}", act(f'(open "w.bin" f "wb") {bytes_} (close f) ({reader} "w.bin")'), 4)
      for reader in ("bload", "bload-facts", "bload-instances")
      for kind, bytes_ in (("own bytes", '(loop-for-count (?i 1 200) (put-char f (mod (* ?i 37) 256)))'), ("nothing", ""),
                           ("prefix", '(printout f "\\5\\6\\7CLIPS")'))],
    attack("bload-facts changed", "(deffacts d (a 1) (b 2))\n" + act('(bsave-facts "w.bin") (open "w.bin" f "ab") (put-char f 1) (close f) (bload-facts "w.bin")'), 4),
    prints("bload-facts own", "(deffacts d (a 1) (b 2))\n" + act('(bsave-facts "w.bin") (bload-facts "w.bin") (printout t "loaded" crlf)')),
    *[attack(f"{function} of no handle", act(f"({function} {arguments})"), 3)
      for function, arguments in (("ros-msgs-destroy-message", "42"), ("ros-msgs-get-field", '42 "data"'), ("ros-msgs-set-field", 'x "data" 1'),
                                  ("ros-msgs-publish", '42 "/x"'), ("ros-msgs-async-send-goal", '42 "/x"'), ("tf2-stop-periodic-lookup", "42"),
                                  ("ros-msgs-destroy-client-goal-handle", "7"))],
    *[prints(f"handle {kind}", act(f'(bind ?m (ros-msgs-create-message "std_msgs/msg/String")) {actions}'), code)
      for code, kind, actions in ((0, "destroyed twice", "(ros-msgs-destroy-message ?m) (ros-msgs-destroy-message ?m)"), (4, "read after its end", '(ros-msgs-destroy-message ?m) (ros-msgs-get-field ?m "data")'),
                            (4, "set after its end", '(ros-msgs-destroy-message ?m) (ros-msgs-set-field ?m "data" x)'),
                            (0, "published after its end", '(ros-msgs-create-publisher "/x" "std_msgs/msg/String") (ros-msgs-destroy-message ?m) (ros-msgs-publish ?m "/x")'),
                            (0, "of another kind", '(ros-msgs-destroy-client-goal-handle ?m)'), (4, "field of another type", '(ros-msgs-set-field ?m "data" (create$ 1 2))'),
                            (4, "field of itself", '(ros-msgs-set-field ?m "data" ?m)'), (0, "as timer", "(tf2-stop-periodic-lookup ?m)"))],
    attack("nested message after the end of its owner", act("""(bind ?m (ros-msgs-create-message "geometry_msgs/msg/PoseStamped")) (bind ?p (ros-msgs-get-field ?m "pose"))
  (ros-msgs-destroy-message ?m) (ros-msgs-set-field ?p "position" 1)"""), 4),
    attack("message within itself", act("""(bind ?m (ros-msgs-create-message "geometry_msgs/msg/PoseStamped")) (ros-msgs-set-field ?m "pose" ?m)"""), 4),
    prints("fixed length", act("""(bind ?m (ros-msgs-create-message "geometry_msgs/msg/PoseWithCovariance")) (ros-msgs-set-field ?m "covariance" (create$ 1.0 2.0))
  (printout t "length " (length$ (ros-msgs-get-field ?m "covariance")) crlf)"""), 4),
    *[attack(f"number {kind}", act(f'(bind ?m (ros-msgs-create-message "std_msgs/msg/{message}")) (ros-msgs-set-field ?m "data" {value})'), 0 if message in ("UInt64", "Bool") else 4)
      for kind, message, value in (("too large for uint8", "UInt8", "256"), ("negative for uint64", "UInt64", "-1"), ("huge for int32", "Int32", str(HUGE)), ("infinite for int32", "Int32", "(* 1e308 10)"),
                                   ("text for bool", "Bool", '"x"'), ("too large for float32", "Float32", "1e300"))],
    attack("uuid of too few", act("(ros-msgs-goal-uuid-to-string (create$ 1 2 3))"), 4),
    attack("uuid of large numbers", act(f"(ros-msgs-goal-uuid-to-string (create$ {' '.join([str(HUGE)] * 16)}))"), 4),
]

# --- ends

ROWS["ends"] = [
    *[prints(f"{kind}", act(f'(printout t "before" crlf) {call}') + "(defrule later (time ?t&:(> ?t 1)) (not (later)) => (assert (later)) (printout t later crlf))",
             {"undefmodule": 3, "break": 3}.get(kind, 4 if kind.startswith(("reset", "clear", "undefrule", "undeftemplate", "undefglobal", "set-reset")) else 0))
      for kind, call in (("exit", "(exit)"), ("exit with a code", "(exit 7)"), ("exit with a huge code", f"(exit {HUGE})"), ("exit of a text", '(exit (str-length "abc"))'),
                         ("halt", "(halt)"), ("reset", "(reset)"), ("clear", "(clear)"), ("undefrule of all", "(undefrule *)"), ("undefrule of itself", "(undefrule stranger)"),
                         ("undeftemplate of all", "(undeftemplate *)"), ("undeffunction of all", "(undeffunction *)"), ("unmake of all", "(unmake-instance *)"), ("undefclass of all", "(undefclass *)"),
                         ("undefmodule", "(undefmodule *)"), ("undefglobal", "(undefglobal *)"), ("retract of all", "(retract *)"), ("run", "(run)"), ("run in run", "(run 5)"),
                         ("shutdown", "(cx-shutdown)"), ("break", "(break)"), ("return", "(return 5)"), ("set-reset-globals", "(set-reset-globals FALSE) (reset)"),
                         ("focus of nothing", "(clear-focus-stack)"), ("pop-focus", "(pop-focus) (pop-focus)"), ("remove-break", "(set-break stranger) (run)"))],
    prints("exit in a callback", """(deffunction /door-service-callback (?service ?request ?response) (exit 3))
(defrule start => (ros-msgs-create-service "/door" "std_srvs/srv/Trigger") (ros-msgs-create-client "/door" "std_srvs/srv/Trigger"))
(defrule call (ros-msgs-client (service "/door")) => (bind ?q (ros-msgs-create-request "std_srvs/srv/Trigger")) (ros-msgs-async-send-request ?q "/door"))
"""),
    prints("clear in a callback", """(deffunction /door-service-callback (?service ?request ?response) (clear))
(defrule start => (ros-msgs-create-service "/door" "std_srvs/srv/Trigger") (ros-msgs-create-client "/door" "std_srvs/srv/Trigger"))
(defrule call (ros-msgs-client (service "/door")) => (bind ?q (ros-msgs-create-request "std_srvs/srv/Trigger")) (ros-msgs-async-send-request ?q "/door"))
""", 4),
    prints("undeffunction in its callback", """(deffunction /door-service-callback (?service ?request ?response) (undeffunction /door-service-callback))
(defrule start => (ros-msgs-create-service "/door" "std_srvs/srv/Trigger") (ros-msgs-create-client "/door" "std_srvs/srv/Trigger"))
(defrule call (ros-msgs-client (service "/door")) => (bind ?q (ros-msgs-create-request "std_srvs/srv/Trigger")) (ros-msgs-async-send-request ?q "/door"))
""", 4),
    prints("service ended in its callback", """(deffunction /door-service-callback (?service ?request ?response) (ros-msgs-destroy-service "/door"))
(defrule start => (ros-msgs-create-service "/door" "std_srvs/srv/Trigger") (ros-msgs-create-client "/door" "std_srvs/srv/Trigger"))
(defrule call (ros-msgs-client (service "/door")) => (bind ?q (ros-msgs-create-request "std_srvs/srv/Trigger")) (ros-msgs-async-send-request ?q "/door"))
"""),
    prints("response destroyed in its callback", """(deffunction /door-service-callback (?service ?request ?response) (ros-msgs-destroy-message ?response) (ros-msgs-destroy-message ?request))
(defrule start => (ros-msgs-create-service "/door" "std_srvs/srv/Trigger") (ros-msgs-create-client "/door" "std_srvs/srv/Trigger"))
(defrule call (ros-msgs-client (service "/door")) => (bind ?q (ros-msgs-create-request "std_srvs/srv/Trigger")) (ros-msgs-async-send-request ?q "/door"))
"""),
    *[prints(f"manager {kind}", calls(MANAGER + service, "cx_msgs/" + name, fields))
      for kind, service, name, fields in (("destroys its caller", "destroy_env", "DestroyClipsEnv", {"env_name": '"main"'}),
                                          ("unloads the executive", "unload_plugin", "UnloadClipsPlugin", {"env_name": '"main"', "plugin_name": '"executive"'}),
                                          ("unloads the messages", "unload_plugin", "UnloadClipsPlugin", {"env_name": '"main"', "plugin_name": '"ros_msgs"'}),
                                          ("unloads the files", "unload_plugin", "UnloadClipsPlugin", {"env_name": '"main"', "plugin_name": '"files"'}),
                                          ("unloads nothing", "unload_plugin", "UnloadClipsPlugin", {"env_name": '""', "plugin_name": '""'}),
                                          ("loads again", "load_plugin", "LoadClipsPlugin", {"env_name": '"main"', "plugin_name": '"files"'}))],
    *[prints(f"manager asked for {label}", f"""(defrule start => (ros-msgs-create-client "/clips_manager/change_state" "lifecycle_msgs/srv/ChangeState"))
(defrule call (ros-msgs-client (service ?s)) => (bind ?q (ros-msgs-create-request "lifecycle_msgs/srv/ChangeState")) (bind ?t (ros-msgs-get-field ?q "transition"))
  (ros-msgs-set-field ?t "label" "{label}") (ros-msgs-set-field ?q "transition" ?t) (ros-msgs-async-send-request ?q ?s))
""") for label in ("deactivate", "cleanup", "shutdown", "destroy", "nonsense", "")],
]

# --- never ends

ROWS["hangs"] = [
    *[attack(kind, act(actions), 4)
      for kind, actions in (("while", "(while TRUE)"), ("while with a body", "(while TRUE do (bind ?x 1))"), ("loop-for-count", f"(loop-for-count {HUGE} (bind ?x 1))"),
                            ("loops in loops", "(loop-for-count (?i 1 1000000) (loop-for-count (?j 1 1000000) (bind ?x 1)))"), ("progn$", '(progn$ (?f (create$ a b c)) (while TRUE))'),
                            ("foreach", '(foreach ?f (create$ a b c) (while TRUE))'), ("evaluated", '(eval "(while TRUE)")'), ("switch", "(while TRUE (switch 1 (case 1 then (bind ?x 1))))"), ("delayed", "(assert (x)) (delayed-do-for-all-facts ((?f x)) (while TRUE) (bind ?x 1))"),
                            ("test of a query", "(assert (x)) (any-factp ((?f x)) (while TRUE))"), ("if", "(if (while TRUE) then (bind ?x 1))"))],
    attack("recursion", "(deffunction f (?x) (f (+ ?x 1)))\n" + act("(f 1)"), 4),
    attack("recursion of two", "(deffunction g (?x)) (deffunction f (?x) (g ?x)) (deffunction g (?x) (f ?x)) (defrule stranger => (f 1))\n", 4,
           alike={"Function 'g'": "Function 'f'"}),
    attack("recursion that branches", "(deffunction f (?x) (if (> ?x 0) then (f (- ?x 1)) (f (- ?x 1)) (f (- ?x 1))))\n" + act("(f 60)"), 4),
    attack("recursion of a method", "(defmethod f ((?x NUMBER)) (f (+ ?x 1)))\n" + act("(f 1)"), 4),
    attack("recursion by eval", '(deffunction f (?x) (eval "(f 1)"))\n' + act("(f 1)"), 4, alike={"Function 'eval'": "Function 'f'", "rules.clp:2:": "rules.clp:4:"}),
    attack("text that evaluates itself", '(defglobal ?*e* = "(eval ?*e*)")\n' + act("(eval ?*e*)"), 4),
    *[attack(f"file that calls {call} of itself", act(f'(open "b.clp" f "w") (printout f "({call} \\"b.clp\\")" crlf) (close f) ({call} "b.clp")'), 3) for call in ("batch", "batch*")],
    attack("recursion by funcall", '(deffunction f (?x) (funcall f ?x))\n' + act("(f 1)"), 4),
    attack("recursion by assert", "(deffunction f (?x) (assert (a ?x)) (f (+ ?x 1)))\n" + act("(f 1)"), 4),
    attack("do-for-all-facts that asserts", act("(assert (x 0)) (do-for-all-facts ((?f x)) TRUE (assert (x (+ (nth$ 1 ?f:implied) 1))))"), 5, command=["--memory", "20MB"]),
    attack("rule that calls itself", "(deffacts n (n 0))\n(defrule stranger ?f <- (n ?n) => (retract ?f) (assert (n (+ ?n 1))))\n", 4),
    attack("two rules", "(deffacts n (a))\n(defrule stranger ?f <- (a) => (retract ?f) (assert (b)))\n(defrule other ?f <- (b) => (retract ?f) (assert (a)))\n", 4),
    attack("rule of the time", "(defrule stranger (time ?) => (refresh stranger) (assert (a)))\n", 4),
    attack("refresh", "(defrule stranger => (refresh stranger))\n", 4),
    attack("modify", "(deftemplate t (slot n))\n(deffacts d (t (n 0)))\n(defrule stranger ?f <- (t (n ?n)) => (modify ?f (n (+ ?n 1))))\n", 4),
    attack("logical", "(deffacts d (a))\n(defrule stranger (logical (a)) (not (b)) => (assert (b)))\n(defrule other ?b <- (b) => (retract ?b))\n", 4),
    attack("build in a loop", act('(assert (go 0))') + '(defrule more ?f <- (go ?i) => (retract ?f) (build (str-cat "(defrule r" ?i " (zz) =>)")) (assert (go (+ ?i 1))))\n', 4, command=["--set", "max_firings_per_tick=2000"]),
    attack("undefrule and build of itself", "(deffacts d (go))\n(defrule stranger (go) => (build \"(defrule stranger (go) => (refresh stranger))\"))\n", 4),
    attack("test that loops", "(deffacts d (go))\n(defrule stranger (go) (test (while TRUE)) =>)\n", 4),
    attack("predicate that loops", "(deffunction f (?x) (loop-for-count 1000000000 (bind ?y 1)) TRUE)\n(deffacts d (go 1))\n(defrule stranger (go ?x&:(f ?x)) =>)\n", 4),
    attack("return value that loops", "(deffunction f () (while TRUE) 1)\n(deffacts d (go 1))\n(defrule stranger (go =(f)) =>)\n", 4),
    attack("salience that loops", "(deffunction f () (while TRUE) 1)\n(deffacts d (go 1))\n(defrule stranger (declare (salience (f))) (go 1) =>)\n", 3),
    attack("salience that loops later", "(defglobal ?*n* = 0)\n(deffunction f () (bind ?*n* (+ ?*n* 1)) (if (> ?*n* 1) then (while TRUE)) 1)\n(defrule go => (set-salience-evaluation when-activated) (assert (go)))\n(defrule stranger (declare (salience (f))) (go) =>)\n", 0),
    attack("default that loops", "(deffunction f () (while TRUE) 1)\n(deftemplate t (slot x (default-dynamic (f))))\n" + act("(assert (t))"), 4),
    attack("default at load that loops", "(deffunction f () (while TRUE) 1)\n(deftemplate t (slot x (default (f))))\n", 3),
    attack("global that loops", "(deffunction f () (while TRUE) 1)\n(defglobal ?*x* = (f))\n", 3),
    attack("deffacts that loop", "(deffunction f () (while TRUE) 1)\n(deffacts d (x (f)))\n", 4),
    attack("many alternatives", "(defrule stranger " + "(or (a) (b)) " * 20 + "=>)\n", 3),
    attack("alternatives of values", "(defrule stranger " + "".join(f"(a{i} {'|'.join('abcdefgh')})" for i in range(12)) + " (x) =>)\n", 0),
    attack("deep conditions", "(defrule stranger " + "(and " * 2000 + "(a)" + ")" * 2000 + " =>)\n", 3),
    attack("service that calls itself", """(deffunction ask () (bind ?q (ros-msgs-create-request "std_srvs/srv/Trigger")) (ros-msgs-async-send-request ?q "/echo")
  (ros-msgs-async-send-request ?q "/echo") (ros-msgs-destroy-message ?q))
(deffunction /echo-service-callback (?service ?request ?response) (ask))
(defrule start => (ros-msgs-create-service "/echo" "std_srvs/srv/Trigger") (ros-msgs-create-client "/echo" "std_srvs/srv/Trigger"))
(defrule first (ros-msgs-client (service "/echo")) => (ask))
(defrule answered ?a <- (ros-msgs-response (msg-ptr ?m)) => (ros-msgs-destroy-message ?m) (retract ?a))
""", 4, command=["--set", "max_firings_per_tick=500"]),
    attack("callback that loops", """(deffunction /door-service-callback (?service ?request ?response) (while TRUE))
(defrule start => (ros-msgs-create-service "/door" "std_srvs/srv/Trigger") (ros-msgs-create-client "/door" "std_srvs/srv/Trigger"))
(defrule call (ros-msgs-client (service "/door")) => (bind ?q (ros-msgs-create-request "std_srvs/srv/Trigger")) (ros-msgs-async-send-request ?q "/door"))
""", 4),
    attack("topic that answers itself", """(defrule start => (ros-msgs-create-publisher "/x" "std_msgs/msg/String") (ros-msgs-create-subscription "/x" "std_msgs/msg/String"))
(deffunction say () (bind ?m (ros-msgs-create-message "std_msgs/msg/String")) (ros-msgs-publish ?m "/x") (ros-msgs-publish ?m "/x") (ros-msgs-destroy-message ?m))
(defrule first (ros-msgs-publisher) => (say))
(defrule again ?a <- (ros-msgs-message (msg-ptr ?m)) => (retract ?a) (ros-msgs-destroy-message ?m) (say))
""", 4, command=["--set", "max_firings_per_tick=500"]),
    *[prints(f"lookup {kind}", act(f'(printout t "made " (tf2-start-periodic-lookup "a" "b" {rate}) crlf)'))
      for kind, rate in (("0 Hz", "0.0"), ("negative", "-1.0"), ("infinite", "(* 1e308 10)"), ("not a number", "(- (* 1e308 10) (* 1e308 10))"), ("1e12 Hz", "1e12"), ("1e-300 Hz", "1e-300"))],
    attack("finalize that loops", "(defrule stranger (executive-finalize) => (while TRUE))\n", 0),
    attack("handlers", "(defclass A (is-a USER))\n(defmessage-handler A f () (send ?self f))\n" + act("(send (make-instance a of A) f)"), 4),
    attack("handlers that branch", "(defclass A (is-a USER))\n(defmessage-handler A f (?n) (if (> ?n 0) then (send ?self f (- ?n 1)) (send ?self f (- ?n 1))))\n" + act("(send (make-instance a of A) f 60)"), 4),
    attack("handler around itself", "(defclass A (is-a USER))\n(defmessage-handler A f around () (send ?self f))\n(defmessage-handler A f () 1)\n" + act("(send (make-instance a of A) f)"), 4),
    attack("handler of create", "(defclass A (is-a USER))\n(defmessage-handler A init after () (make-instance of A))\n" + act("(make-instance a of A)"), 4),
    attack("handler of print", "(defclass A (is-a USER))\n(defmessage-handler A print () (send ?self print))\n" + act("(send (make-instance a of A) print)"), 4),
    attack("method calls next without end", "(defmethod f ((?x INTEGER)) (override-next-method ?x) (f ?x))\n(defmethod f ((?x NUMBER)) (f ?x))\n" + act("(f 1)"), 4),
]

# --- takes memory


def fills(name, rules):
    return attack("memory of " + name, rules, 5, command=["--memory", "20MB", "--steps", "0"])


def forever(actions, first=""):
    return act(f"(bind ?i 0) {first} (while TRUE (bind ?i (+ ?i 1)) {actions})")


NUMBERS = "(deffacts numbers " + " ".join(f"(x {i})" for i in range(1000)) + ")\n"
ROWS["memory"] = [
    fills("facts", forever("(assert (x ?i))")),
    fills("facts of texts", forever('(assert (x (str-cat "abcdefghijklmnopqrstuvwxyz" ?i)))')),
    fills("texts", forever("(bind ?s (str-cat ?s ?s))", '(bind ?s "abcdefgh")')),
    fills("lists", forever("(bind ?s (create$ ?s ?s))", "(bind ?s (create$ a b c d))")),
    fills("inserted lists", forever("(bind ?s (insert$ ?s 1 ?s))", "(bind ?s (create$ a b c d))")),
    fills("formatted texts", forever('(bind ?s (create$ ?s (format nil "%99999d" ?i)))', "(bind ?s (create$))")),
    fills("a global", "(defglobal ?*g* = (create$ a b))\n" + forever("(bind ?*g* ?*g* ?*g*)")),
    fills("instances", "(defclass A (is-a USER) (slot x))\n" + forever("(make-instance (gensym*) of A (x ?i))")),
    fills("rules", forever('(build (str-cat "(defrule r" ?i " (a " ?i ") (b ?x) (c ?x) => (printout t ?x))"))')),
    fills("templates", forever('(build (str-cat "(deftemplate t" ?i " (slot a) (slot b))"))')),
    fills("classes", forever('(build (str-cat "(defclass C" ?i " (is-a USER) (slot x))"))')),
    fills("methods", forever('(build (str-cat "(defmethod m" ?i " ((?x INTEGER)) ?x)"))')),
    fills("publishers", forever('(ros-msgs-create-publisher (str-cat "/t" ?i) "std_msgs/msg/String")')),
    fills("subscriptions", forever('(ros-msgs-create-subscription (str-cat "/t" ?i) "std_msgs/msg/String")')),
    fills("clients", forever('(ros-msgs-create-client (str-cat "/t" ?i) "std_srvs/srv/Trigger")')),
    fills("services", forever('(ros-msgs-create-service (str-cat "/t" ?i) "std_srvs/srv/Trigger")')),
    fills("action clients", forever('(ros-msgs-create-action-client (str-cat "/t" ?i) "cxlab_skills/action/Pick")')),
    fills("a deffacts", "(deffunction f () (bind ?s (create$ a b)) (while TRUE (bind ?s (create$ ?s ?s))) ?s)\n(deffacts d (x (f)))\n"),
    fills("a condition", "(deffunction f () (bind ?s (create$ a b)) (while TRUE (bind ?s (create$ ?s ?s))) TRUE)\n(deffacts d (x))\n(defrule stranger (x) (test (f)) =>)\n"),
    fills("partial matches", "(deffacts d " + " ".join(f"(x {i})" for i in range(200)) + ")\n(defrule stranger (x ?a) (x ?b) (x ?c) (x ?d) (y) =>)\n"),
    fills("a service callback", """(deffunction /door-service-callback (?service ?request ?response) (bind ?s (create$ a b)) (while TRUE (bind ?s (create$ ?s ?s))))
(defrule start => (ros-msgs-create-service "/door" "std_srvs/srv/Trigger") (ros-msgs-create-client "/door" "std_srvs/srv/Trigger"))
(defrule call (ros-msgs-client (service "/door")) => (bind ?q (ros-msgs-create-request "std_srvs/srv/Trigger")) (ros-msgs-async-send-request ?q "/door"))
"""),
    fills("environments", """(defrule start => (ros-msgs-create-client "/clips_manager/create_env" "cx_msgs/srv/CreateClipsEnv"))
(defrule call (time ?) (ros-msgs-client (service ?s)) => (loop-for-count (?i 1 500) (bind ?q (ros-msgs-create-request "cx_msgs/srv/CreateClipsEnv"))
  (ros-msgs-set-field ?q "env_name" (str-cat (gensym*))) (ros-msgs-async-send-request ?q ?s) (ros-msgs-destroy-message ?q)))
"""),
    fills("a pile of bindings", act("(bind ?x (create$ (loop-for-count (?i 1 100000) (assert (x ?i (format nil \"%1000d\" ?i))))))")),
    fills("messages", forever('(ros-msgs-create-message "std_msgs/msg/String")')),
    fills("texts in messages", forever('(bind ?m (ros-msgs-create-message "std_msgs/msg/String")) (ros-msgs-set-field ?m "data" ?s)', '(bind ?s (format nil "%99999d" 1))')),
    fills("lists in messages", forever('(bind ?m (ros-msgs-create-message "std_msgs/msg/UInt8MultiArray")) (ros-msgs-set-field ?m "data" ?s)',
                                       "(bind ?s (create$ 1)) (loop-for-count 10 (bind ?s (create$ ?s ?s)))")),
    fills("messages in messages", forever('(bind ?m (ros-msgs-create-message "geometry_msgs/msg/PoseStamped")) (bind ?p (ros-msgs-get-field ?m "pose"))')),
    fills("messages that wait", """(defrule start => (ros-msgs-create-publisher "/x" "std_msgs/msg/String") (ros-msgs-create-subscription "/x" "std_msgs/msg/String"))
(defrule stranger (ros-msgs-publisher) => (bind ?m (ros-msgs-create-message "std_msgs/msg/String")) (while TRUE (ros-msgs-publish ?m "/x")))
"""),
    fills("requests", """(defrule start => (ros-msgs-create-client "/x" "std_srvs/srv/Trigger"))
(defrule stranger (ros-msgs-client) => (while TRUE (bind ?q (ros-msgs-create-request "std_srvs/srv/Trigger")) (ros-msgs-async-send-request ?q "/x")))
"""),
    fills("goals", """(defrule start => (ros-msgs-create-action-client "/x" "cxlab_skills/action/Pick"))
(defrule stranger (ros-msgs-action-client) => (while TRUE (bind ?g (ros-msgs-create-goal-request "cxlab_skills/action/Pick")) (ros-msgs-async-send-goal ?g "/x")))
"""),
    fills("lookups", forever('(tf2-start-periodic-lookup "a" (str-cat "b" ?i) 10.0)')),
    fills("parameters", forever('(ros-param-get-value (str-cat "p" ?i) ?s)', '(bind ?s (format nil "%9999d" 1))')),
    fills("a line without an end", act('(while TRUE (printout t "again and again "))')),
    fills("instances of the PDDL manager", """(defrule start => (open "d.pddl" f "w") (printout f "(define (domain d) (:predicates (p))" crlf)
  (loop-for-count (?i 1 2000) (printout f "(:action a" ?i " :parameters () :precondition (p) :effect (not (p)))" crlf)) (printout f ")" crlf) (close f)
  (ros-msgs-create-client "/pddl_manager/add_pddl_instance" "cx_pddl_interfaces/srv/AddPddlInstance"))
(defrule stranger (time ?) (ros-msgs-client (service ?s)) => (loop-for-count 20 (bind ?q (ros-msgs-create-request "cx_pddl_interfaces/srv/AddPddlInstance"))
  (ros-msgs-set-field ?q "name" (str-cat (gensym*))) (ros-msgs-set-field ?q "directory" "{here}/out/written") (ros-msgs-set-field ?q "domain_file" "d.pddl")
  (ros-msgs-async-send-request ?q ?s) (ros-msgs-destroy-message ?q)))
(defrule answered ?a <- (ros-msgs-response (msg-ptr ?r)) => (ros-msgs-destroy-message ?r) (retract ?a))
"""),
    fills("a cross product", NUMBERS + "(defrule stranger (x ?a) (x ?b) (x ?c) (x ?d) (x ?e) =>)\n"),
    fills("deleted members", act("(bind ?l (create$ 1)) (loop-for-count 16 (bind ?l (create$ ?l ?l))) (delete-member$ ?l 1)")),
    fills("explode", act('(bind ?s "a ") (loop-for-count 22 (bind ?s (str-cat ?s ?s))) (bind ?m (explode$ ?s))')),
]

# --- fills the disk


def writes(name, rules):
    return attack("disk full of " + name, rules, 5, command=["--disk", "5MB", "--journal", "full", "--steps", "0"])


ROWS["disk"] = [
    writes("log lines", act('(while TRUE (printout t "again and again" crlf))')),
    writes("empty lines", act("(while TRUE (printout t crlf))")),
    writes("facts that are shown", act("(loop-for-count (?i 1 1000) (assert (x ?i))) (while TRUE (facts))")),
    writes("what is watched", "(deffunction f (?x))\n" + act('(watch deffunctions) (bind ?s (format nil "%999d" 1)) (while TRUE (f ?s))')),
    writes("a file", act('(open "x" f "w") (while TRUE (printout f "again and again" crlf))')),
    writes("one list", act('(bind ?l (format nil "%99999d" 1)) (loop-for-count 14 (bind ?l (create$ ?l ?l))) (open "x" f "w") (printout f ?l crlf)')),
    writes("many files", forever('(bind ?n (str-cat "x" ?i)) (open ?n f "w") (printout f ?s) (close f)', '(bind ?s (format nil "%99999d" 1))')),
    writes("a file written again", forever('(open "x" f "w") (printout f ?s) (close f) (remove "x")', '(bind ?s (format nil "%99999d" 1))')),
    writes("formatted texts", act('(open "x" f "w") (while TRUE (format f "%99999d" 1))')),
    writes("gaps", act('(open "x" f "w") (seek f 1000000000 seek-set) (printout f x)')),
    writes("gaps one after another", act('(open "x" f "w") (while TRUE (seek f 1000000 seek-cur) (printout f x))')),
    writes("characters", act('(open "x" f "wb") (while TRUE (put-char f 65))')),
    *[writes(f"{function}", "(defclass A (is-a USER) (slot x))\n" + act(f'(loop-for-count (?i 1 1000) (assert (x ?i)) (make-instance of A (x ?i))) (bind ?i 0) (while TRUE (bind ?i (+ ?i 1)) ({function} (str-cat "x" ?i)))'))
      for function in ("save-facts", "bsave-facts", "save-instances", "bsave-instances", "save", "bsave")],
    writes("a dribble", act('(dribble-on "x") (while TRUE (printout t "again and again" crlf))')),
    writes("the journal", act('(bind ?s (format nil "%99999d" 1)) (while TRUE (assert (x ?s)) (retract *))')),
    writes("inputs", """(defrule start => (ros-msgs-create-publisher "/x" "std_msgs/msg/String") (ros-msgs-create-subscription "/x" "std_msgs/msg/String"))
(defrule stranger (time ?) (ros-msgs-publisher) => (bind ?m (ros-msgs-create-message "std_msgs/msg/String")) (ros-msgs-set-field ?m "data" (format nil "%999999d" 1))
  (ros-msgs-publish ?m "/x") (ros-msgs-destroy-message ?m))
(defrule heard ?h <- (ros-msgs-message (msg-ptr ?m)) => (ros-msgs-destroy-message ?m) (retract ?h))
"""),
    writes("copies of what was read", forever('(open "x" f "w") (printout f ?s "(b " ?i ")") (close f) (load-facts "x")', '(bind ?s (format nil "(a %99999d)" 1))')),
    Row("lines without a folder", ["run", "scenario.yaml", "--quiet", "--out", "none", "--disk", "1MB", "--steps", "1000000"], 4,
        {"rules/rules.clp": act('(while TRUE (printout t "again and again" crlf))')}),
]

# --- takes too many steps


def lasts(name, rules):
    return attack("steps of " + name, rules, 4, command=["--steps", "5000000"])


def on_list(actions, doublings=14):
    return act(f"(bind ?l (create$ 1 2 3)) (loop-for-count {doublings} (bind ?l (create$ ?l ?l))) (bind ?k (create$ ?l 4)) " + actions)


def on_text(actions):
    return act('(bind ?s "abcdefgh") (loop-for-count 14 (bind ?s (str-cat ?s ?s))) (bind ?t (str-cat ?s "i")) ' + actions)


FIELDS = " ".join(map(str, range(200)))
ROWS["steps"] = [
    lasts("a join", NUMBERS + "(defrule stranger (x ?a) (x ?b&:(< ?b ?a)) (x ?c&:(< (+ ?a ?b ?c) 0)) =>)\n"),
    lasts("a join in an action", "(defrule stranger (x ?a) (x ?b&:(< ?b ?a)) (x ?c&:(< (+ ?a ?b ?c) 0)) =>)\n(defrule fill => (loop-for-count (?i 1 1000) (assert (x ?i))))\n"),
    lasts("a join of a rule that is built", NUMBERS + act('(build "(defrule late (x ?a) (x ?b&:(< ?b ?a)) (x ?c&:(< (+ ?a ?b ?c) 0)) =>)")')),
    lasts("a negated join", NUMBERS + "(defrule stranger (x ?a) (x ?b&:(< ?b ?a)) (not (x ?c&:(< (+ ?a ?b ?c) 0))) (y) =>)\n"),
    lasts("a join of objects", "(defclass A (is-a USER) (slot x))\n" + act("(loop-for-count (?i 1 1000) (make-instance of A (x ?i)))") +
          "(defrule other (object (is-a A) (x ?a)) (object (is-a A) (x ?b&:(< ?b ?a))) (object (is-a A) (x ?c&:(< (+ ?a ?b ?c) 0))) =>)\n"),
    lasts("the fields of a fact", f"(deffacts d (x {FIELDS}))\n(defrule stranger (x $? ?a $? ?b $? ?c $? ?d&:(< ?d ?a) $? ?e $?) =>)\n"),
    lasts("the fields of an object", f"(defclass A (is-a USER) (multislot m))\n(definstances d (a of A (m {FIELDS})))\n(defrule stranger (object (is-a A) (m $? ?a $? ?b $? ?c $? ?d&:(< ?d ?a) $? ?e $?)) =>)\n"),
    lasts("a retract", NUMBERS + "(deffacts blocker (y))\n(defrule stranger (x ?a) (x ?b) (not (and (y) (x ?c&:(< (+ ?a ?b ?c) 5)))) (z) =>)\n(defrule go (declare (salience -1)) ?y <- (y) => (retract ?y))\n"),
    lasts("firings", "(deffacts d (go))\n(defrule stranger ?f <- (go) => (retract ?f) (loop-for-count 100000 (bind ?x (+ 1 1))) (assert (go)))\n"),
    lasts("callbacks", """(deffunction /x-service-callback (?service ?request ?response) (loop-for-count 5000 (bind ?x (+ 1 1))))
(defrule start => (ros-msgs-create-service "/x" "std_srvs/srv/Trigger") (ros-msgs-create-client "/x" "std_srvs/srv/Trigger"))
(defrule stranger (ros-msgs-client (service "/x")) => (loop-for-count 2000 (bind ?q (ros-msgs-create-request "std_srvs/srv/Trigger")) (ros-msgs-async-send-request ?q "/x") (ros-msgs-destroy-message ?q)))
"""),
    lasts("methods", "(defmethod f ((?x INTEGER)) (loop-for-count 1000 (f (float ?x))))\n(defmethod f ((?x FLOAT)) (+ ?x (* ?x 2)))\n" + act("(loop-for-count (?i 1 10000) (f ?i))")),
    lasts("a slow comparison", "(deffunction slow (?a ?b) (loop-for-count 1000 (bind ?x (+ 1 1))) (> ?a ?b))\n" + on_list("(sort slow ?l)")),
    lasts("sorts", on_list("(while TRUE (sort > ?l))")),
    lasts("a search for fields", on_list("(while TRUE (member$ (create$ ?k) ?l))")),
    lasts("a comparison of sets", on_list("(while TRUE (subsetp (create$ 1 2 3) ?l) (subsetp ?l (create$ 5 ?l)))")),
    lasts("lists that are equal", on_list("(bind ?m (create$ ?l)) (while TRUE (eq ?l ?m))")),
    lasts("a replacement of fields", on_list("(while TRUE (replace-member$ ?l 5 ?k))")),
    lasts("a list of arguments", on_list("(while TRUE (max (expand$ ?l)))", 10)),
    lasts("lists that are passed on", "(deffunction f ($?x) (length$ ?x))\n" + on_list("(while TRUE (f ?l))")),
    lasts("lists that are bound", on_list("(while TRUE (bind ?m ?l))")),
    lasts("lists of lists", on_list("(progn$ (?a ?l) (progn$ (?b ?l) (bind ?x (+ ?a ?b))))")),
    *[lasts(kind, on_text(f"(while TRUE {call})"))
      for kind, call in (("str-index", "(str-index ?t ?s)"), ("str-compare", "(str-compare ?s ?t)"), ("str-length", "(str-length ?s)"), ("upcase", "(upcase ?s)"),
                         ("sub-string", "(sub-string 1 2 ?s)"), ("str-replace", '(str-replace ?s "abc" "x")'), ("str-cat", "(str-cat ?s ?t)"), ("sym-cat", "(sym-cat ?s x)"),
                         ("explode", "(explode$ ?s)"), ("string-to-field", "(string-to-field ?s)"), ("eval", "(eval ?s)"))],
    lasts("a text that grows", act('(bind ?s "") (while TRUE (bind ?s (str-cat ?s "a")))')),
    lasts("format", act('(while TRUE (format nil "%99999d" 1))')),
    lasts("build", act('(while TRUE (build "(defrule other (a) =>)"))')),
    lasts("evaluations", act('(while TRUE (eval "(+ 1 2)"))')),
    lasts("a file that is loaded", act('(open "x" f "w") (loop-for-count (?i 1 100) (printout f "(deffunction f" ?i " () 1)" crlf)) (close f) (while TRUE (load* "x"))')),
    lasts("facts that are loaded", act('(open "x" f "w") (loop-for-count (?i 1 100) (printout f "(x " ?i ")" crlf)) (close f) (while TRUE (load-facts "x"))')),
    lasts("lines that are read", act('(open "x" f "w") (format f "%999999d%n" 1) (close f) (while TRUE (open "x" f "r") (readline f) (close f))')),
    lasts("an agenda that is sorted", "(defrule other (declare (salience -1)) (x ?) =>)\n" + act("(loop-for-count (?i 1 5000) (assert (x ?i))) (while TRUE (set-strategy breadth) (set-strategy depth))")),
    lasts("a query", NUMBERS + act("(do-for-all-facts ((?a x) (?b x) (?c x)) (eq ?a ?b ?c) (bind ?z 1))")),
    lasts("support by one condition", "(deffacts d (a))\n(defrule stranger (logical (a)) => (loop-for-count (?i 1 5000) (assert (x ?i))) (do-for-all-facts ((?f x)) TRUE (retract ?f)))\n"),
    Row("steps at the limit", [*RUN, "--steps", "0"], 0, {"rules/rules.clp": act("(loop-for-count 1000000 (bind ?x (+ 1 1)))")}),
    Row("steps of many ticks", [*RUN, "--steps", "500000"], 0, {"rules/rules.clp": "(defrule stranger (time ?) => (loop-for-count 50000 (bind ?x (+ 1 1))))\n"}),
]

# --- the machine's clock, chance and terminal

ROWS["machine"] = [
    attack("files that are left open", act('(loop-for-count (?i 1 1000) (open (str-cat "x" ?i) (sym-cat f ?i) "w"))'), 4),
    attack("files that are closed", act('(loop-for-count (?i 1 1000) (open "x" f "w") (close f))'), 0),
    *[prints(f"{kind}", act(f'(printout t "found " {call} crlf)'))
      for kind, call in (("time", "(time)"), ("local-time", "(local-time)"), ("gm-time", "(gm-time)"), ("timer", "(timer (loop-for-count 1000 (bind ?x 1)))"),
                         ("random", "(random) \" \" (random 1 6)"), ("random of bounds", f"(random {TINY} {HUGE})"), ("seed", "(progn (seed 5) (random 1 1000))"),
                         ("gensym", "(gensym) (gensym*)"), ("setgen", f"(setgen {HUGE}) (gensym) (gensym*)"), ("operating-system", "(operating-system)"),
                         ("read", "(read)"), ("readline", "(readline)"), ("read-number", "(read-number)"), ("get-char", "(get-char)"), ("read of stdin", "(read stdin)"),
                         ("readline of t", "(readline t)"), ("get-char of t", "(get-char t)"))],
    *[attack(kind, act(f'(printout t "found " {call} crlf)'), 4)
      for kind, call in (("random reversed", "(random 6 1)"), ("random of one", "(random 6)"), ("system", '(system "touch {here}/outside/made")'), ("system of an id", "(system id)"),
                         ("chdir", '(chdir "/")'), ("profile", "(profile constructs)"), ("profile user-functions", "(profile user-functions)"),
                         ("strategy random", "(set-strategy random)"), ("constructs-to-c", '(constructs-to-c x 1)'), ("get-char of nothing", "(get-char nothing)"),
                         ("read of nothing", "(read nothing)"), ("printout to nothing", "(progn (printout nothing 1) 1)"))],
    prints("watch all", act("(watch all) (assert (a)) (unwatch all)")),
    prints("watch statistics", act("(watch statistics) (watch compilations)"), 4),
    *[prints(f"print to {router}", act(f'(printout {router} "by rules" crlf)'))
      for router in ("t", "stdout", "stderr", "stdwrn", "debug", "warn", "error", "logerror", "red", "blue")],
    attack("print to nil and stdin", act('(printout nil "x" crlf) (printout stdin "x" crlf)'), 0),
    prints("print escapes", act('(printout t (format nil "%c]0;title%c%c[2J" 27 7 27) crlf)')),
    prints("print bytes", act('(printout t (format nil "%c%c%c" 255 254 192) crlf)')),
    prints("print lines", act('(printout t "a" crlf "[error] forged" crlf "[    9.000] [error] [clips_manager] forged" crlf)')),
    prints("close all", act('(close) (printout t "still" crlf)')),
    prints("close t", act('(close t) (close stdout) (close stderr) (printout t "still" crlf)'), 4),
    prints("open as t", act('(open "mine.txt" t "w") (printout t "where" crlf) (close t)'), 4),
    prints("open as stderr", act('(open "mine.txt" stderr "w") (printout stderr "where" crlf) (close stderr)'), 4),
    prints("dribble twice", act('(dribble-on "a.txt") (dribble-on "b.txt") (printout t "said" crlf) (dribble-off) (dribble-off)')),
    prints("dribble until the end", act('(dribble-on "a.txt") (printout t "said" crlf)')),
]

# --- extremes of numbers

ROWS["numbers"] = [
    *[prints(f"{call}", act(f'(printout t "is " {call} crlf)'))
      for call in (f"(+ {HUGE} 1)", f"(- {TINY} 1)", f"(* {HUGE} {HUGE})", f"(abs {TINY})", f"(div {TINY} 3)", f"(mod {HUGE} 7)", "(round 1e300)", "(round -1e300)", "(integer 1e300)",
                   "(integer (* 1e308 10))", "(integer (- (* 1e308 10) (* 1e308 10)))", "(round (- (* 1e308 10) (* 1e308 10)))", "(float 9223372036854775807)", "(** 10 400)", "(sqrt 4)",
                   "(exp 1000)", "(log 1)", "(max 1 (* 1e308 10))", "(min 1 (- (* 1e308 10) (* 1e308 10)))", "(mod 5.5 2)", "(mod 1e300 3)", "99999999999999999999", "(pi)",
                   "1e400", "-1e400", "(div 7 2.5)", "(mod 5 (- (* 1e308 10) (* 1e308 10)))")],
    *[attack(f"{call}", act(f'(printout t "is " {call} crlf)'), 4)
      for call in (f"(div {TINY} -1)", f"(mod {TINY} -1)", "(div 1 0)", "(mod 1 0)", "(mod 1.5 0)", "(/ 1 0)", "(/ 1 0.0)", "(sqrt -1)", "(log 0)", "(log -1)", "(log10 0)", "(acos 2)", "(asin -2)",
                   "(** -1 0.5)", "(div 1 0.4)", "(acosh 0)", "(atanh 1)", "(tan (/ (pi) 2))", "(atan2 0 0)", "(** 0 0)", "(** 0 -1)")],
    *[attack(f"loop-for-count {kind}", act(f'(loop-for-count (?i {bounds}) (bind ?x ?i))'), code)
      for kind, bounds, code in (("at the end", f"{HUGE - 1} {HUGE}", 4), ("reversed", f"{HUGE} {TINY}", 0), ("of all", f"{TINY} {HUGE}", 4))],
    *[attack(f"salience {value}", f"(defrule stranger (declare (salience {value})) => (printout t fired crlf))\n", 3) for value in ("10001", "-10001", "1.5", "high", "(/ 1 0)")],
]

# --- objects, modules and the agenda

A = "(defclass A (is-a USER) (slot x) (multislot m))\n"
ROWS["objects"] = [
    *[attack(kind, A + act(actions), code)
      for kind, code, actions in (("instance deleted in its handler", 4, '(build "(defmessage-handler A f () (send ?self delete) ?self:x)") (send (make-instance a of A (x 1)) f)'),
                                  ("instance deleted in its loop", 4, "(make-instance a of A) (do-for-all-instances ((?i A)) TRUE (send ?i delete) (printout t ?i:x crlf))"),
                                  ("instance deleted before it is used", 4, "(bind ?a (make-instance a of A)) (send ?a delete) (send ?a get-x)"),
                                  ("instance of a class without an end", 4, "(make-instance a of A) (undefclass A)"), ("class redefined", 4, '(make-instance a of A) (build "(defclass A (is-a USER) (slot y))")'),
                                  ("class redefined without instances", 0, '(build "(defclass A (is-a USER) (slot y))")'), ("circular class", 4, '(build "(defclass B (is-a A))") (build "(defclass A (is-a B))")'),
                                  ("class of itself", 4, '(build "(defclass C (is-a C))")'), ("abstract class", 3, "(make-instance a of USER)"), ("class of a number", 3, "(make-instance a of INTEGER)"),
                                  ("instance made in its slot", 4, "(make-instance a of A (x (make-instance a of A)))"), ("unmake in a query", 4, "(make-instance a of A) (do-for-instance ((?i A)) (unmake-instance *) (printout t ?i:x crlf))"),
                                  ("slot of a deleted one", 4, "(bind ?a (instance-address (make-instance a of A))) (unmake-instance ?a) (printout t (slot-existp A x) (instance-name ?a) crlf)"),
                                  ("slot that is not there", 4, "(send (make-instance a of A) get-y)"), ("handler undefined in itself", 4, '(build "(defmessage-handler A g () (undefmessage-handler A g))") (send (make-instance a of A) g)'),
                                  ("modified in its handler", 0, '(build "(defmessage-handler A put-x after (?v) (if (< ?v 5) then (dynamic-put x (+ ?v 1))))") (send (make-instance a of A) put-x 1)'),
                                  ("names of instances", 4, '(send [nothing] print)'), ("instance in a fact", 0, "(assert (z (make-instance a of A))) (unmake-instance *)"),
                                  ("direct slots", 0, "(printout t (class-slots A inherit) (slot-facets A x) crlf)"), ("restored from a text", 0, '(open "i" f "w") (printout f "([a] of A (x 1))" crlf) (close f) (restore-instances "i")'),
                                  ("restored of a wrong class", 4, '(open "i" f "w") (printout f "([a] of ZZ (x 1))" crlf) (close f) (printout t (load-instances "i") crlf)'))],
    *[attack(kind, rules, code)
      for kind, code, rules in (("focus on nothing", 4, act("(focus NOWHERE)")), ("focus forever", 5, "(defmodule MAIN (export ?ALL))\n(defmodule M (import MAIN ?ALL))\n(defrule M::stranger => (while TRUE (focus MAIN) (focus M)))\n(defrule MAIN::go => (focus M))\n"),
                                ("focus by turns", 4, "(defmodule MAIN (export ?ALL))\n(deftemplate a)\n(deftemplate b)\n(deffacts d (a))\n(defmodule M (import MAIN ?ALL))\n(defrule M::m ?f <- (b) => (retract ?f) (assert (a)) (focus MAIN))\n(defrule MAIN::stranger ?f <- (a) => (retract ?f) (assert (b)) (focus M))\n"),
                                ("module again", 4, act('(build "(defmodule MAIN (export ?NONE))") (build "(defmodule M)") (build "(defmodule M (import ZZ ?ALL))")')),
                                ("auto-focus", 4, "(defmodule MAIN (export ?ALL))\n(deftemplate a (slot x))\n(defmodule M (import MAIN ?ALL))\n(defrule M::m (declare (auto-focus TRUE)) ?f <- (a (x ?x)) => (retract ?f) (assert (a (x (+ ?x 1)))))\n(defrule MAIN::stranger => (assert (a (x 1))))\n"),
                                ("a fact retracted twice", 0, "(deffacts d (a))\n(defrule stranger ?f <- (a) => (retract ?f) (retract ?f))\n"),
                                ("a fact used after its end", 4, "(deftemplate t (slot x))\n(deffacts d (t (x 1)))\n(defrule stranger ?f <- (t) => (retract ?f) (modify ?f (x 2)))\n"),
                                ("a fact of no index", 4, act("(retract 99999)")), ("a fact of a huge index", 4, act(f"(retract {HUGE})")),
                                *[(f"{kind} of a fact of a huge index", 4, "(deftemplate t (slot x))\n" + act(call))
                                  for kind, call in (("modify", f"(modify {HUGE} (x 1))"), ("duplicate", f"(duplicate {HUGE} (x 1))"), ("relation", f"(fact-relation {HUGE})"), ("dependents", f"(dependents {HUGE})"))],
                                ("error in a slot of a long name", 4, f"(deftemplate t (slot {'s' * 5000}))\n(defrule stranger (t ({'s' * 5000} ?x&:(> (/ 1 ?x) 1))) =>)\n" + act(f"(assert (t ({'s' * 5000} 0)))").replace("stranger", "asserts")), ("a fact of a negative index", 4, act("(retract -1)")),
                                ("fact address of nothing", 3, act("(fact-slot-value <Fact-99> x)")), ("duplicate of nothing", 4, act("(duplicate 42 (x 1))")),
                                ("retract in a query", 0, "(deffacts d (a 1) (a 2) (a 3))\n" + act("(do-for-all-facts ((?f a)) TRUE (retract *))")),
                                ("modify in a query", 0, "(deftemplate t (slot x))\n(deffacts d (t (x 1)) (t (x 2)))\n" + act("(do-for-all-facts ((?f t)) TRUE (modify ?f (x (+ ?f:x 10))))")),
                                ("plugin's template redefined", 0, act('(build "(deftemplate ros-msgs-message (slot topic))")')), ("plugin's template undefined", 0, act("(undeftemplate ros-msgs-message)")),
                                ("plugin's rule undefined", 0, act("(undefrule time-retract)")), ("plugin's function redefined", 3, "(deffunction now () 5)\n"), ("CLIPS function redefined", 3, "(deffunction printout () 5)\n"),
                                ("method on a CLIPS function", 0, "(defmethod + ((?a STRING) (?b STRING)) (str-cat ?a ?b))\n" + act('(printout t (+ "a" "b") crlf)')),
                                ("method on a plugin's function", 0, "(defmethod now ((?a STRING)) 1)\n" + act("(printout t (now) crlf)")),
                                ("time facts of its own", 0, "(deffacts d (time 99999999.0))\n"), ("message facts of its own", 3, '(deffacts d (ros-msgs-message (topic "/x") (msg-ptr <Pointer-C-0x1>)))\n'),
                                ("finalize of its own", 0, act("(assert (executive-finalize))")), ("rule of hidden name", 3, '(defrule |a b| => (printout t here crlf))\n'),
                                ("rule of a long name", 0, f"(defrule {'r' * 20000} => (printout t here crlf))\n"), ("rule of bytes", 4, "(defrule r\u00e4 => (/ 1 0))\n"))],
]

# --- what CLIPS lets rules change and look at

T = "(deftemplate t (slot x) (multislot m))\n"
ROWS["engine"] = [
    attack("duplicates of one fact", act("(set-fact-duplication TRUE) (while TRUE (assert (a)))"), 5, command=["--memory", "20MB"]),
    attack("duplicates in a rule", "(defrule set (declare (salience 5)) => (set-fact-duplication TRUE) (assert (a)))\n(defrule stranger (a) => (assert (a)))\n", 5),
    *[prints(f"{call}", T + "(deffacts d (t (x 1)) (a b))\n" + "(defclass A (is-a USER) (slot x))\n" + act(f"(make-instance i of A) {call}"), code)
      for call, code in (("(ppdefrule stranger)", 0), ("(matches stranger)", 0), ("(agenda)", 0), ("(list-deftemplates *)", 0), ("(instances *)", 0), ("(options)", 0), ("(conserve-mem on)", 0),
                         ("(set-sequence-operator-recognition TRUE)", 0), ("(set-class-defaults-mode conservation)", 0), ("(set-dynamic-constraint-checking TRUE)", 0), ("(get-function-restrictions printout)", 0),
                         ("(dependencies 1)", 0), ("(describe-class USER)", 0), ("(browse-classes)", 0), ("(facts 1 99999999)", 0), ("(undefinstances *)", 0), ("(set-reset-globals maybe)", 0))],
    prints("addresses that are printed", T + act('(bind ?f (assert (t (x 1)))) (bind ?m (ros-msgs-create-message "std_msgs/msg/String")) (printout t ?f " " ?m " " (fact-index ?f) crlf)')),
    *[attack(f"{call} in a condition", T + f"(deffacts d (go))\n(defrule stranger (go) (test {call}) =>)\n", code)
      for call, code in (("(assert (b))", 3), ("(retract 1)", 3), ("(halt)", 0), ("(exit)", 0), ("(reset)", 3), ("(clear)", 3), ('(open "x" f "w")', 0), ('(load* "x")', 3), ('(build "(defrule x =>)")', 3), ("(undefrule *)", 3), ("(run)", 3),
                         ('(eval "(while TRUE)")', 4), ("(return)", 3), ("(focus MAIN)", 0))],
]

# --- names and texts that are not what they seem

ROWS["names"] = [
    *[prints(f"write to {name!r}", act(f'(open {text} f "w") (printout f "by rules" crlf) (printout t "closed " (close f) crlf)'), code)
      for name, text, code in (("nothing", '""', 4), ("a point", '"."', 4), ("two points", '".."', 4), ("the root", '"/"', 4), ("a folder", '"a/"', 4), ("a line", '"a\nb"', 0), ("bytes", '(format nil "%c%c" 255 47)', 4),
                               ("256 letters", f'"{"n" * 256}"', 4), ("backslashes", '"..\\\\..\\\\x"', 0), ("a scheme", '"file:///etc/x"', 0), ("a device of Windows", '"NUL"', 0), ("escapes", '(format nil "%c[2J" 27)', 0),
                               ("200 folders", '"' + "d/" * 200 + 'x"', 0), ("a tilde", '"~root/x"', 0), ("a variable", '"$HOME/x"', 0), ("a star", '"*"', 0))],
    prints("a file that is a folder too", act('(open "a" f "w") (close f) (open "a/b" g "w") (printout g "x") (close g)'), 4),
    prints("a folder that is a file too", act('(open "a/b" f "w") (close f) (open "a" g "w") (printout g "x") (close g)'), 4),
    prints("a file renamed to itself", act('(open "a" f "w") (printout f "x") (close f) (printout t (rename "a" "a") (rename "a" "b") (rename "a" "b") (remove "b") (remove "b") crlf)')),
    prints("one file twice", act('(open "a" f "w") (open "a" g "w") (printout f "1") (printout g "2") (close) (open "a" h "r") (printout t (readline h) crlf)')),
    prints("a fact that prints as two", act('(assert (a (sym-cat "b) (c")))  (save-facts "x") (printout t (load-facts "x") crlf) (facts)')),
    prints("a text that prints as an end", act('(assert (a (format nil "%c) (c %c" 34 34))) (save-facts "x") (printout t (load-facts "x") crlf) (facts)')),
    prints("symbols like variables", act('(assert (a (sym-cat "?x") (sym-cat "$?y") (sym-cat "=") (sym-cat "&~") (sym-cat "; no")))  (facts)')),
    prints("a rule that is built with another name", act('(build "(defrule MAIN::stranger2 => (printout t again crlf))") (build "(defrule |stranger| => (printout t bars crlf))")'), 4),
    prints("letters of other scripts", act('(printout t "ж " (upcase "жß") (str-length "жß") (sub-string 1 1 "ж") "." (str-index "ß" "жß") crlf)')),
    prints("the texts of the log", act('(printout t "[    9.000] [error] [main] forged" crlf) (printout error "run: /etc/passwd" crlf)')),
]

# --- services of the nodes, called by rules


def asks(name, service, kind, sets, code=0):
    """Rules that call a service with what `sets` does to ?q, and print that it answered."""
    package, type_ = kind.split("/")
    return prints(name, f"""(defrule start => (ros-msgs-create-client "{service}" "{package}/srv/{type_}"))
(defrule call (ros-msgs-client (service ?s)) => (bind ?q (ros-msgs-create-request "{package}/srv/{type_}")) {sets} (printout t "sent: " (ros-msgs-async-send-request ?q ?s) crlf)
  (ros-msgs-destroy-message ?q))
(defrule answered (ros-msgs-response (msg-ptr ?r)) => (printout t "answered" crlf) (ros-msgs-destroy-message ?r))
""", code)


def given(name, kind, value, doublings=0):
    return f"""(bind ?p (ros-msgs-create-message "rcl_interfaces/msg/Parameter")) (bind ?v (ros-msgs-get-field ?p "value")) (ros-msgs-set-field ?p "name" {name})
  (ros-msgs-set-field ?v "type" {dict(bool=1, integer=2, double=3, string=4, string_array=9)[kind]}) (ros-msgs-set-field ?v "{kind}_value" {value}) (ros-msgs-set-field ?p "value" ?v)
  (bind ?l (create$ ?p)) (loop-for-count {doublings} (bind ?l (create$ ?l ?l))) (ros-msgs-set-field ?q "parameters" ?l)"""


SET, EXECUTIVE = (MANAGER + "set_parameters", "rcl_interfaces/SetParameters"), MANAGER + "executive/"
ROWS["services"] = [
    *[asks(f"parameter {name}", *SET, given(*what))
      for name, what in (("with a file", ('"files.load"', "string_array", '(create$ "{here}/outside/secret.clp")')), ("environments", ('"environments"', "string_array", '(create$ "evil")')),
                         ("rate of a double", ('"executive.refresh_rate"', "double", "1e300")), ("rate below 0", ('"executive.refresh_rate"', "integer", "-5")), ("of another type", ('"executive.assert_time"', "string", '"maybe"')),
                         ("nothing", ('""', "bool", "TRUE")), ("of points", ('"a..b"', "bool", "TRUE")), ("heartbeat below 0", ('"bond_heartbeat_period"', "double", "-1.0")), ("long", ('(format nil "%99999d" 1)', "integer", "1")),
                         ("4096 times", ('"x"', "bool", "TRUE", 12)))],
    asks("parameter of another planner", "/pddl_manager/set_parameters", "rcl_interfaces/SetParameters", given('"command"', "string", '"touch {here}/outside/made {plan}"')),
    asks("2048 parameters", MANAGER + "get_parameters", "rcl_interfaces/GetParameters", '(bind ?l (create$ "x" "")) (loop-for-count 10 (bind ?l (create$ ?l ?l))) (ros-msgs-set-field ?q "names" ?l)'),
    asks("depth below 0", MANAGER + "list_parameters", "rcl_interfaces/ListParameters", f'(ros-msgs-set-field ?q "depth" {TINY})'),
    *[asks(f"{service} {name}", EXECUTIVE + service, "cx_msgs/ClipsCommand", f'(ros-msgs-set-field ?q "env_name" "{env}") (ros-msgs-set-field ?q "command" {command})', code)
      for service, name, env, command, code in (
          ("eval", "without end", "main", '"(while TRUE)"', 0), ("eval", "clear", "main", '"(clear)"', 0), ("eval", "in no environment", "nobody", '"(facts)"', 0), ("eval", "load", "", '"(load* {here}/outside/secret.clp)"', 0),
          ("eval", "deep", "main", f'"{"(" * 2000}"', 0), ("eval", "nothing", "main", '""', 0), ("build", "without end", "main", '"(defrule stranger2 => (while TRUE))"', 4), ("build", "a number", "main", '"5"', 0))],
    attack("eval that asks for more", """(defrule start => (ros-msgs-create-client "/clips_manager/executive/eval" "cx_msgs/srv/ClipsCommand"))
(deffunction ask () (bind ?q (ros-msgs-create-request "cx_msgs/srv/ClipsCommand")) (ros-msgs-set-field ?q "command" "(progn (ask) (ask))") (ros-msgs-async-send-request ?q "/clips_manager/executive/eval")
  (ros-msgs-destroy-message ?q))
(defrule call (ros-msgs-client) => (ask))
(defrule answered ?a <- (ros-msgs-response (msg-ptr ?r)) => (ros-msgs-destroy-message ?r) (retract ?a))
""", 4, command=["--set", "max_firings_per_tick=500"]),
    prints("a log line for each log line", """(defrule start => (ros-msgs-create-subscription "/clips_manager/clips_log" "cx_msgs/msg/Log") (ros-msgs-create-client "/clips_manager/set_topic_logging" "cx_msgs/srv/SetTopicLogging"))
(defrule switch (ros-msgs-client (service ?s)) => (bind ?q (ros-msgs-create-request "cx_msgs/srv/SetTopicLogging")) (ros-msgs-set-field ?q "env_name" "main") (ros-msgs-set-field ?q "enabled" TRUE) (ros-msgs-async-send-request ?q ?s))
(defrule begin (time ?t&:(> ?t 0.5)) (not (begun)) => (assert (begun)) (printout t begin crlf))
(defrule said ?m <- (ros-msgs-message (msg-ptr ?p)) => (retract ?m) (ros-msgs-destroy-message ?p) (printout t "again " (now) crlf))
"""),
]

LIBRARY = """(defrule start => (open "evil.so" f "w") (printout f "no library" crlf) (close f)
  (ros-param-get-value "stolen.plugin" "evil::Plugin") (ros-msgs-create-client "/clips_manager/load_plugin" "cx_msgs/srv/LoadClipsPlugin"))
(defrule call (ros-msgs-client (service ?s))
  => (bind ?q (ros-msgs-create-request "cx_msgs/srv/LoadClipsPlugin")) (ros-msgs-set-field ?q "env_name" "main") (ros-msgs-set-field ?q "plugin_name" "stolen")
  (ros-msgs-async-send-request ?q ?s) (ros-msgs-destroy-message ?q))
"""


def library(name, path, config=CONFIG):
    """Rules have a native library of their package opened."""
    return Row(name, RUN, 3, {"rules/rules.clp": LIBRARY, "agent.yaml": config, "rules/evil.so": "no library", "rules/cxlab_plugins.yaml": f"library: {path}\nplugins:\n  - class: evil::Plugin\n"})


NAMED = CONFIG.replace("    executive:", '    other: {plugin: "evil::Plugin"}\n    executive:')
HOME = {"home/agent.yaml": CONFIG, "home/.ssh/key": SECRET, "home/rules.clp": act('(open "{here}/home/.ssh/key" f "r")')}
ROWS["packages"] = [
    library("library of the package", "evil.so"),
    library("library of the package, absolute", "{here}/rules/evil.so"),
    library("library that rules wrote", "{here}/out/written/evil.so", NAMED),
    library("link to a library that rules wrote", "link.so", NAMED),
    Row("configuration at home", ["env", "home/agent.yaml", "--out", "out"], 3, HOME, never=[SECRET]),
    Row("configuration in params at home", ["env", "home/params/agent.yaml", "--out", "out"], 3, {"home/params/agent.yaml": CONFIG, **HOME}, never=[SECRET]),
    *[Row(f"package {folder}", RUN, 3, {"scenario.yaml": SCENARIO.replace("rules: rules", f"rules: rules, h: {folder}")})
      for folder in ("/", "{here}/home", "home/..", "/home")],
    *[attack(f"hidden {name}", act(f'(open "{{here}}/rules/{path}" f "r") (printout t (readline f) crlf)'), 4)
      for name, path in (("file", ".key"), ("folder", ".ssh/key"), ("folder upwards", "a/../.ssh/key"))],
]
for row in ROWS["packages"]:
    row.files.setdefault("home/readme.txt", "mine")
    row.files.update({"rules/.key": SECRET, "rules/.ssh/key": SECRET})
    if "link" in row.name:
        row.leaves = ("out", "rules")
        row.files["rules/link.so"] = lambda path: os.symlink("../out/written/evil.so", path)

PROTOBUF = {
    "agent.yaml": CONFIG.replace('"tf",', '"protobuf",') + '    protobuf: {plugin: "cx::ProtobufPlugin", pkg_share_dirs: ["rules"], proto_paths: ["types"]}\n',
    "rules/types/m.proto": 'syntax = "proto2"; message M { enum CompType { COMP_ID = 1; MSG_TYPE = 2; } optional string s = 1; repeated M m = 2; }',
}


def protobuf(name, rules, code):
    return Row("protobuf: " + name, [*RUN, "--memory", "20MB"], code, {"rules/rules.clp": rules, **PROTOBUF}, never=[SECRET])


ROWS["protobuf"] = [
    protobuf("messages", forever("(pb-create M)"), 5),
    protobuf("texts in messages", forever("(pb-set-field (pb-create M) s ?s)", '(bind ?s (format nil "%99999d" 1))'), 5),
    protobuf("lists in messages", forever("(pb-add-list ?m m ?m)", '(bind ?m (pb-create M))'), 5),
    protobuf("copies of messages", forever("(pb-field-list ?m m)", '(bind ?m (pb-create M)) (loop-for-count 10 (pb-add-list ?m m (pb-create M)))'), 5),
    protobuf("messages that wait", """(defrule stranger => (bind ?p (pb-peer-create-local "h" 5 6)) (pb-peer-create-local "h" 7 5) (bind ?m (pb-create M))
  (while TRUE (pb-broadcast ?p ?m)))
""", 5),
    protobuf("messages that wait in a stream", """(defrule start => (pb-server-enable 5) (pb-connect "h" 5))
(defrule stranger (protobuf-client-connected ?id) => (bind ?m (pb-create M)) (while TRUE (pb-send ?id ?m)))
""", 5),
    protobuf("peers without end", forever('(pb-peer-create "h" 5)'), 4),
    protobuf("servers and clients without end", forever('(pb-server-enable ?i) (pb-server-disable) (pb-connect "h" ?i)'), 4),
    protobuf("connections that come and go", forever('(pb-disconnect (pb-connect "h" 5))'), 5),
    protobuf("it answers itself", """(defrule stranger => (bind ?p (pb-peer-create-local "h" 5 6)) (pb-peer-create-local "h" 6 5) (pb-broadcast ?p (pb-create M)))
(defrule answer (protobuf-msg (ptr ?p) (client-id ?id)) => (pb-send ?id ?p))
""", 0),
]

LONG = ["environments", "explode", "rules", "action clients", "services", "clients", "subscriptions", "publishers", "templates", "classes"]
LONG = {"memory of " + name for name in LONG} | {
    "handlers that branch", "recursion that branches", "switch", "while with a body", "progn$", "foreach", "if", "loops in loops", "loop-for-count at the end",
    "loop-for-count of all", "reset", "set-reset-globals", "do-for-all-facts that asserts", "finalize that loops", "callback that loops", "default that loops",
    "return value that loops", "predicate that loops"}
for row in sum(ROWS.values(), []):
    row.long = row.name in LONG
