"""Wrong inputs: files and command lines with the exit code and the text that they must get.
tests/app/wrong_inputs.py plays the rows; tests/support/rows.py has their form."""

import os
import pathlib
import re
import subprocess
import tempfile

from lab import CONFIG, CXLAB, GAME, SCENARIO, SOURCE
from rows import Row

STORIES = """common:
  rules: rules.clp
stories:
  - story: one
    expect: [{fact: (a), within_s: 1}]
"""
SUITE = """scenarios: [scenario.yaml]
seeds: [1]
strategies: {s: []}
"""
DOMAIN = """(define (domain d)
  (:requirements :strips :typing)
  (:types place)
  (:predicates (at ?p - place) (road ?a ?b - place))
  (:action go
    :parameters (?a ?b - place)
    :precondition (and (at ?a) (road ?a ?b))
    :effect (and (not (at ?a)) (at ?b))))
"""
PROBLEM = """(define (problem p)
  (:domain d)
  (:objects a b - place)
  (:init (at a) (road a b))
  (:goal (at b)))
"""
PLAN = "0.000: (go a b) [0.001]\n"
FIXED = {
    "agent.yaml": CONFIG,
    "scenario.yaml": SCENARIO,
    "game.yaml": GAME,
    "turtles.yaml": "schema: 1\nworld: {kind: turtlesim}\nduration_s: 1\n",
    "rules/rules.clp": "(deftemplate pose (slot x))\n(deffacts start (go))\n",
    "rules.clp": "(defrule make => (assert (a)))\n",
    "one.story.yaml": STORIES,
    "suite.yaml": SUITE,
    "d.pddl": DOMAIN,
    "p.pddl": PROBLEM,
    "a.plan": PLAN,
    "empty/keep": "",
    "used/mine.txt": "mine",
    "garbage": bytes(range(256)) * 8,
    "nothing": "",
}
RUN = ["run", "scenario.yaml", "--quiet", "--out", "out"]
ENV = ["env", "agent.yaml", "--package", "rules=rules", "--until", "1", "--quiet", "--out", "out"]


def wrong(name, command, code, files=None, **more):
    return Row(name, list(command), code, dict(files or {}), **more)


ROWS = {}

# --- command lines

SEEDS = ("-1", "1.5", "x", "", "18446744073709551616", "0x10", "1e3", "nan")
SECONDS = ("-1", "x", "", "nan", "inf", "1e400", "1,5", "-0.001")
ROWS["options"] = [
    wrong("nothing at all", [], 2),
    wrong("empty command", [""], 2),
    wrong("command in capitals", ["RUN"], 2),
    *[wrong(f"misspelt command {word}", [word], 2) for word in ("rnu", "vaildate", "replya", "whi", "whynot", "fact", "dif", "bnech", "dokter")],
    *[wrong(f"{command} without arguments", [command], 2)
      for command in ("run", "env", "bench", "replay", "rerun", "facts", "agenda", "globals", "firings", "rules", "why", "why-not", "diff", "check", "plan", "validate", "render", "list", "new", "completion")],
    *[wrong(f"{' '.join(command)} with one too many", [*command, "more"], 2)
      for command in (["run", "scenario.yaml"], ["replay", "used"], ["rerun", "used"], ["facts", "used", "a"], ["agenda", "used"], ["why", "used", "a"], ["why-not", "used", "a"], ["diff", "used", "used"], ["plan", "d.pddl", "p.pddl"], ["validate", "d.pddl", "p.pddl", "a.plan"],
                      ["bench", "suite.yaml"], ["list", "skills"], ["doc", "now"], ["doctor"], ["new", "agent", "x"], ["completion", "bash"], ["man"])],
    *[wrong(f"{command} with an unknown option", [command, *rest, "--frobnicate"], 2)
      for command, rest in (("run", ["scenario.yaml"]), ("env", ["agent.yaml"]), ("test", []), ("bench", ["suite.yaml"]), ("replay", ["used"]), ("rerun", ["used"]), ("firings", ["used"]), ("rules", ["used"]), ("why-not", ["used", "a"]), ("diff", ["used", "used"]), ("check", ["rules.clp"]),
                            ("plan", ["d.pddl", "p.pddl"]), ("validate", ["d.pddl", "p.pddl", "a.plan"]), ("render", ["used"]), ("list", ["skills"]), ("doc", []), ("doctor", []), ("man", []))],
    *[wrong(f"misspelt option {option}", [command, *rest, option], 2)
      for command, rest, option in (("run", ["scenario.yaml"], "--sed"), ("run", ["scenario.yaml"], "--jason"), ("env", ["agent.yaml"], "--stimulus"),
                                           ("env", ["agent.yaml"], "--keepgoing"), ("bench", ["suite.yaml"], "--jsn"), ("test", [], "--junti"), ("replay", ["used"], "--rule"),
                                           ("facts", ["used"], "--form"), ("rules", ["used"], "--agianst"), ("why", ["used", "a"], "--hole"), ("why-not", ["used", "a"], "--wher"), ("check", ["rules.clp"], "--grahp"), ("plan", ["d.pddl", "p.pddl"], "--anytme"), ("validate", ["d.pddl", "p.pddl", "a.plan"], "--epsillon"),
                                           ("render", ["used"], "--camra"))],
    *[wrong(f"run --seed '{value}'", [*RUN, "--seed", value], 2) for value in SEEDS],
    *[wrong(f"run --until '{value}'", [*RUN, "--until", value], 2) for value in SECONDS],
    *[wrong(f"run --memory '{value}'", [*RUN, "--memory", value], 2) for value in ("-1", "x", "", "3XB", "1.5GB", "999999999999GB", "10", "999kB", "GB", "nan")],
    *[wrong(f"run --tier '{value}'", [*RUN, "--tier", value], 2) for value in ("phsics", "", "Timed", "both")],
    *[wrong(f"run --journal '{value}'", [*RUN, "--journal", value], 2) for value in ("ful", "", "all")],
    *[wrong(f"run --set '{value}'", [*RUN, "--set", value], code)
      for value, code in (("", 2), ("seed", 2), ("=3", 3), ("sed=3", 3), ("seed=x", 3), ("agents[9].config=x", 3), ("agents[-1].config=x", 3), ("agents[x].config=y", 3), ("agents=3", 3), ("seed.x=3", 3),
                          ("world=[1", 3), ("duration_s=-1", 3), ("tick_s=0", 3), (".=3", 3), ("a..b=3", 3), ("agents[0]=x", 3), ("schema=2", 3), ("on_rule_error=stpo", 3), ("seed={a: b}", 3))],
    *[wrong(f"run --snapshot '{value}'", ["run", "game.yaml", "--quiet", "--out", "out", "--snapshot", value], 2) for value in ("every:0", "every:", "every:-1", "every:x", "evry:1", "", "1,,2", "x", "-1", "nan", "99999", "every:nan")],
    *[wrong(f"run --snapshot and --video in an empty world {option}", [*RUN, option, value], 5) for option, value in (("--snapshot", "1"), ("--video", "film.mp4"))],
    *[wrong(f"run --out '{value}'", ["run", "scenario.yaml", "--quiet", "--out", value], code) for value, code in (("used", 2), ("nothing", 2), ("nothing/run", 5), ("/proc/none", 5), ("/dev/null", 2), ("", 2))],
    *[wrong(f"run of '{value}'", ["run", value, "--quiet", "--out", "out"], 3 if value else 2) for value in ("missing.yaml", "", "used", "garbage", "nothing", "rcll/gam", "agent.yaml", "rules/rules.clp", "/dev/null", "one.story.yaml", "suite.yaml", "/proc/self/mem", "agent.yaml/x")],
    *[wrong(f"option given twice {option}", [*RUN, option, value, option, value], 2) for option, value in (("--seed", "1"), ("--until", "1"), ("--memory", "1GB"), ("--tier", "timed"))],
    *[wrong(f"option without a value {option}", [*RUN, option], 2) for option in ("--seed", "--until", "--memory", "--tier", "--set", "--snapshot", "--journal", "--prefix")],
    wrong("flag with a value", [*RUN, "--quiet=maybe"], 2),
    wrong("run --prefix of nothing", [*RUN, "--prefix", "missing"], 3),
    # env
    *[wrong(f"env --package '{value}'", ["env", "agent.yaml", "--out", "none", "--quiet", "--package", value], code) for value, code in (("rules", 2), ("", 2), ("=x", 2), ("rules=", 2), ("rules=missing", 3), ("rules=agent.yaml", 3), ("a/b=rules", 3))],
    *[wrong(f"env --with '{value}'", [*ENV, "--with", value], 2) for value in ("turtlesm", "", "rcl", "none", "moon")],
    *[wrong(f"env --param '{value}'", [*ENV, "--param", value], code)
      for value, code in (("x", 2), ("", 2), ("=1", 2), ("clips_manager=1", 2), ("clips_manager.executive.refresh_rate=fast", 3), ("clips_manager.executive.refresh_rate=0", 3), ("clips_manger.x=1", 2), ("clips_manager.environments=5", 3),
                          ("clips_manager.main.watch=[fcts]", 3), ("clips_manager.executive.refresh_rate=-5", 3), ("clips_manager.executive.assert_time=maybe", 3))],
    *[wrong(f"env --remap '{value}'", [*ENV, "--remap", value], 2) for value in ("a", "", "a:=", ":=b", "a=b", "a b:=c", "a:=b//c", "a:=/b/", "a:=1b", "a:=b{x}")],
    *[wrong(f"env --namespace '{value}'", [*ENV, "--namespace", value], 2) for value in ("a b", "1a", "//", "a//b", "ä", "a/")],
    *[wrong(f"env --stimuli '{value}'", [*ENV, "--stimuli", value], 3 if value else 2) for value in ("missing.yaml", "garbage", "used", "agent.yaml", "rules/rules.clp", "")],
    *[wrong(f"env --transition '{value}'", [*ENV, "--transition", value], 2) for value in ("x", "", "5", "5:", "5:actvate", ":activate", "-1:activate", "x:activate", "nan:activate", "5:activate@", "5:activate@nobody", "5:activate@clips_manger", "0.5:deactivate@/ns/clips_manager", "5:activate@a b")],
    wrong("env --transition of a node that has no life", [*ENV, "--with", "turtlesim", "--transition", "0.5:deactivate@turtlesim"], 2),
    wrong("env --transition of the name before a remap", [*ENV, "--remap", "__node:=boss", "--transition", "0.5:deactivate@clips_manager"], 2),
    *[wrong(f"env --max-firings '{value}'", [*ENV, "--max-firings", value], 2) for value in ("-1", "x", "1.5", "", "99999999999999999999")],
    *[wrong(f"env of '{value}'", ["env", value, "--quiet"], 3 if value else 2) for value in ("missing.yaml", "", "used", "garbage", "rules/rules.clp", "d.pddl", "scenario.yaml", "one.story.yaml")],
    wrong("env of two, one missing", ["env", "agent.yaml", "missing.yaml", "--quiet", "--package", "rules=rules"], 3),
    # test
    *[wrong(f"test of '{value}'", ["test", value], 3 if value else 2) for value in ("missing", "", "missing.story.yaml", "garbage", "rules.clp", "agent.yaml")],
    wrong("test of a folder with a pipe", ["test", "pipes"], 3, files={"pipes/a.story.yaml": os.mkfifo}),
    wrong("test of a folder with a link to nothing", ["test", "links"], 3, files={"links/a.story.yaml": lambda path: path.symlink_to("gone")}),
    *[wrong(f"{command[0]} with rules that are {what}", command, 3, files={"rules/rules.clp": make})
      for command in (RUN, ENV) for what, make in (("a pipe", os.mkfifo), ("a folder", os.mkdir), ("a device", lambda path: path.symlink_to("/dev/zero")), ("a link to nothing", lambda path: path.symlink_to("gone")))],
    wrong("test of an empty folder", ["test", "empty"], 3),
    *[wrong(f"test -j '{value}'", ["test", "-j", value], 2) for value in ("0", "-1", "x", "", "257", "1.5", "1e1", "99999999999999999999")],
    *[wrong(f"test {option} to nowhere", ["test", option, "/proc/none/file"], 5) for option in ("--junit", "--coverage")],
    *[wrong(f"test --package '{value}'", ["test", "--package", value], code) for value, code in (("x", 2), ("x=missing", 3))],
    # bench
    *[wrong(f"bench of '{value}'", ["bench", value, "--out", "out"], 3 if value else 2) for value in ("missing.yaml", "", "used", "garbage", "scenario.yaml", "nothing")],
    *[wrong(f"bench -j '{value}'", ["bench", "suite.yaml", "-j", value], 2) for value in ("0", "x", "", "-3", "1000")],
    *[wrong(f"bench --out {value}", ["bench", "suite.yaml", "--out", value], code) for value, code in (("nothing", 5), ("/proc/none", 5))],
    # check
    *[wrong(f"check of '{value}'", ["check", value], 3 if value else 2)
      for value in ("missing.clp", "missing.yaml", "", "used", "nothing", "garbage", "rcll/gam", "/dev/null", "/proc/self/mem", "agent.yaml/x", "d.pddl", "one.story.yaml", "suite.yaml")],
    wrong("check of rules and a missing file", ["check", "rules.clp", "missing.clp"], 3),
    *[wrong(f"check of a file that is {what}", ["check", "a.clp"], 3, files={"a.clp": make}) for what, make in (
        ("binary", bytes(range(256)) * 8), ("a pipe", os.mkfifo), ("a folder", os.mkdir), ("a device", lambda path: path.symlink_to("/dev/zero")), ("a link to nothing", lambda path: path.symlink_to("gone")),
        ("open", "(defrule a (b) =>\n"), ("closed too often", "(defrule a (b) => ))\n"), ("a text that is open", '(defrule a (b) => (printout t "c))\n'))],
    *[wrong(f"check --graph '{value}'", ["check", "rules.clp", "--graph", value], code) for value, code in (("", 2), ("rules.png", 2), ("rules", 2), ("/proc/none/rules.svg", 5), ("/proc/none.dot", 5))],
    *[wrong(f"check --param '{value}'", ["check", "agent.yaml", "--package", "rules=rules", "--param", value], code) for value, code in (("x", 2), ("", 2), ("clips_manger.x=1", 2), ("clips_manager.environments=5", 3))],
    wrong("check --param of a scenario", ["check", "scenario.yaml", "--param", "clips_manager.x=1"], 2),
    *[wrong(f"check --package '{value}'", ["check", "agent.yaml", "--package", value], code) for value, code in (("x", 2), ("rules=missing", 3))],
    wrong("check of a configuration without its package", ["check", "agent.yaml"], 3),
    # recorded runs
    *[wrong(f"{command} of '{value}'", [command, value, *rest], 3 if value else 2)
      for command, rest in (("replay", []), ("rerun", ["--quiet", "--out", "out"]), ("why-not", ["a"]), ("render", ["--out", "x.png"])) for value in ("missing", "", "empty", "used", "garbage")],
    *[wrong(f"render to '{out}'", ["render", "turtles.yaml", "--at", "0", "--out", out], 2) for out in ("x.jpg", "x.PNG.bmp", "x.svg", "a/b.jpeg")],
    wrong("render to no PNG", ["render", "turtles.yaml", "--at", "0", "--out", "/proc/none/x.png"], 5),
    *[wrong(f"render --size '{value}'", ["render", "turtles.yaml", "--at", "0", "--out", "x.png", "--size", value], 2) for value in ("big", "", "0x0", "-1x5", "640", "640x", "x480", "1e3x5", "100000x100000", "640x480x3")],
    *[wrong(f"render --at '{value}'", ["render", "turtles.yaml", "--out", "x.png", "--at", value], 2) for value in ("-1", "x", "", "nan", "1e400")],
    *[wrong(f"run --video-speed '{value}'", [*RUN, "--video", "x.mp4", "--video-speed", value], 2) for value in ("0", "x", "-1", "1e9", "nan", "")],
    *[wrong(f"run --video-size '{value}'", [*RUN, "--video", "x.mp4", "--video-size", value], 2) for value in ("big", "0x0", "640", "640x480x3")],
    *[wrong(f"run {option} without --video", [*RUN, option, value], 2) for option, value in (("--video-camera", "top"), ("--video-size", "640x480"), ("--video-speed", "5"))],
    *[wrong(f"render {option} without --video", ["render", "turtles.yaml", "--at", "0", "--out", "x.png", option, "1"], 2) for option in ("--from", "--to", "--speed")],
    wrong("render to a picture and a film", ["render", "turtles.yaml", "--at", "0", "--out", "x.png", "--video", "x.mp4"], 2),
    wrong("render a film from after its end", ["render", "turtles.yaml", "--video", "x.mp4", "--from", "1", "--to", "0.5"], 2),
    wrong("render a film to after the end", ["render", "turtles.yaml", "--video", "x.mp4", "--to", "50"], 2),
    wrong("render a film at a time", ["render", "turtles.yaml", "--video", "x.mp4", "--at", "0.5"], 2),
    wrong("render nothing", ["render", "turtles.yaml", "--at", "0"], 2),
    wrong("render after the end", ["render", "turtles.yaml", "--out", "x.png", "--at", "50"], 2),
    wrong("render without --at", ["render", "turtles.yaml", "--out", "x.png"], 2),
    wrong("render of a camera that is not there", ["render", "turtles.yaml", "--out", "x.png", "--at", "0", "--camera", "canvs"], 3),
    wrong("render of an empty world", ["render", "scenario.yaml", "--out", "x.png", "--at", "0"], 3),
    # plan, validate
    *[wrong(f"plan --patience '{value}'", ["plan", "d.pddl", "p.pddl", "--patience", value], 2) for value in ("-1", "x", "0", "1.5")],
    *[wrong(f"plan --budget '{value}'", ["plan", "d.pddl", "p.pddl", "--budget", value], 2) for value in ("-1", "x", "", "1.5", "0", "1e6", "0x10", "9223372036854775808", "99999999999999999999")],
    *[wrong(f"plan --timeout '{value}'", ["plan", "d.pddl", "p.pddl", "--timeout", value], 2) for value in ("-1", "x", "", "nan", "inf")],
    *[wrong(f"plan {option} to nowhere", ["plan", "d.pddl", "p.pddl", option, "/proc/none/file"], 5) for option in ("--out", "--svg")],
    *[wrong(f"plan of {' '.join(files)}", ["plan", *files], 31) for files in (("missing", "p.pddl"), ("d.pddl", "missing"), ("p.pddl", "d.pddl"), ("d.pddl", "d.pddl"), ("garbage", "p.pddl"), ("nothing", "p.pddl"), ("d.pddl", "nothing"), ("used", "p.pddl"))],
    *[wrong(f"validate {option} '{value}'", ["validate", "d.pddl", "p.pddl", "a.plan", option, value], 2) for option in ("--epsilon", "--tolerance", "--robust-limit") for value in ("-1", "x", "", "nan")],
    *[wrong(f"validate of {' '.join(files)}", ["validate", *files], code) for files, code in ((("missing", "p.pddl", "a.plan"), 31), (("d.pddl", "p.pddl", "missing"), 31), (("d.pddl", "p.pddl", "garbage"), 31), (("d.pddl", "p.pddl", "nothing"), 1), (("d.pddl", "p.pddl", "used"), 31), (("d.pddl", "p.pddl", "d.pddl"), 31))],
    # list, doc, new, help
    *[wrong(f"list '{value}'", ["list", value], 2) for value in ("skils", "", "world", "function", "everything")],
    *[wrong(f"doc '{value}'", ["doc", value], 3 if value else 2) for value in ("ros-msgs-create-mesage", "", "std_msgs/msg/Strin", "std_msgs/msg", "cx::FileLoadPlugn", "nothing", "a/b/c/d")],
    wrong("doc in two forms", ["doc", "--json", "--markdown"], 2),
    *[wrong(f"new {' '.join(words)}", ["new", *words], code) for words, code in ((["agnt", "x"], 2), (["agent"], 2), (["agent", ""], 2), (["agent", "used"], 2), (["agent", "a b"], 2), (["agent", "9lives"], 2), (["plugin", "ä"], 2), (["agent", "nothing"], 2), (["agent", "/proc/x"], 5))],
    *[wrong(f"help {word}", ["help", word], 2) for word in ("rnu", "")],
    wrong("completion of fish", ["completion", "fish"], 2),
]

# --- scenarios


def scenario(name, text, code=3):
    return wrong(name, RUN, code, files={"scenario.yaml": text})


KEYS = {  # key of a scenario: values that it cannot have
    "schema": ("2", "x", "[]", "1.5"), "seed": ("-1", "x", "1.5", "{}"), "duration_s": ("-1", "x", ".nan", ".inf", "[1]", "1e30"), "tick_s": ("0", "-1", "x", ".nan", "1e-12", "1e12", "1e9"),
    "physics_step_s": ("0", "-1", "x"), "epoch": ("x", "[]", ".inf"), "max_firings_per_tick": ("-1", "x", "1.5"), "on_rule_error": ("stopp", "1", "[]"), "trust_rules": ("maybe", "2", "[]"),
    "tier": ("fast", "[]"), "agents": ("x", "{}", "[x]", "[{}]", "[{config: }]", "[{config: [a]}]"), "servers": ("x", "[nonsense]", "[{nod: turtlesim}]", "[{node: turtlsim}]", "[3]", *(f"[{{node: league_client, {key}}}]" for key in ("team: BOTH", "robots: 4", "first_robot: 0", "cipher: des", "port_shift: 70000", "namespace: a b"))), "packages": ("x", "[a]", "{rules: nowhere}", "{rules: }"),
    "stimuli": ("x", "[x]", "[{}]"), "faults": ("x", "[{}]", "[{kind: skil_fails}]", "[{kind: machine_breaks, at: 1}]"), "planner": ("x", "{latency: {a: -1}}", "{budget: -1}", "{latncy: {}}", "{budget: 0}", "{patience: 0}", "{patience: x}", "{planning_time: gratis}", "{charge: false}"),
    "expect": ("x", "[{}]", "[{path: status}]", "[{path: sttus, equals: completed}]", "[{path: ticks, min: x}]"), "world": ("x", "{kind: moon}", "{kind: turtlesm}", "[rcll]"),
}
ROWS["scenarios"] = [
    *[scenario(f"{key}: {value}", re.sub(rf"(?m)^{key}:.*\n(?:[ -].*\n)*", "", SCENARIO) + f"{key}: {value}\n") for key, values in KEYS.items() for value in values],
    *[scenario(f"without {key}", re.sub(rf"(?m)^{key}:.*\n(?:[ -].*\n)*", "", SCENARIO)) for key in ("schema",)],
    *[scenario(f"misspelt {key}", SCENARIO + f"{word}: 1\n") for key, word in
      (("seed", "sed"), ("trust_rules", "trust-rules"), ("max_firings_per_tick", "max_firings"), ("stimuli", "stimulus"), ("expect", "expects"), ("world", "wrld"), ("faults", "fault"), ("servers", "server"), ("planner", "planer"), ("epoch", "epoc"))],
    *[scenario(f"world {key}: {value}", f"schema: 1\ntier: timed\nworld: {{kind: rcll, {key}: {value}}}\n")
      for key, values in {"team": ("GREEN", "[]", "cyan"), "robots": ("4", "-1", "x", "1.5"), "rules": ("leage", "1"), "production_s": ("-1", "x", ".inf"), "setup_s": ("-1", "x"), "exploration": ("maybe",), "down": ("x",), "complexities": ("C9", "[C9]", "{}"),
                          "shelf_refill_s": ("-1",), "repair_s": ("-1",), "pauses": ("x", "[{}]", "[{at: 1}]", "[{for: 1}]", "[{at: -1, for: 5}]", "[{at: 1500, for: 5}]", "[{at: 300, for: 0}]", "[{at: 300, for: -60}]", "[{at: 300, for: 60}, {at: 300, for: 1}]", "[{at: 300, until: 360}]", "[{at: .nan, for: 1}]", "[{at: 1, for: .inf}]"), "refbox": ("x", "{port: 1}", "{cipher: des}", "{port_shift: 70000}", "{key_cyan: [a]}"), "foresight": ("x",), "transforms": ("x",), "layout": ("x", "[{machine: C-BS}]", "[{machine: C-BS, zone: C_Z99}]", "[{machine: X-BS, zone: C_Z23}]", "[{machine: C-BS, zone: C_Z23, rotation: 7}]"),
                          "orders": ("x", "[{complexity: C5}]", "[{complexity: C0, base_color: BASE_PINK, cap_color: CAP_GREY}]", "[{complexity: C1, base_color: BASE_RED, ring_colors: [], cap_color: CAP_GREY}]"), "robotss": ("1",),
                          "game": ("gone.yaml", "garbage", "scenario.yaml", "rules", "[]", "/dev/zero")}.items() for value in values],
    *[wrong(f"game {text}", RUN, 3, files={"scenario.yaml": "schema: 1\ntier: timed\nworld: {kind: rcll, game: g.yaml}\n", "g.yaml": text})
      for text in ("x", "[]", "orders: x", "orders: [{complexity: C1}]", "order: []", "orders: [{gate: 1}]", "ring_prices: {RING_BLUE: 1}", "ring_prices: {RING_RED: 1}", "ring_prices: 1", "overtime: []", "overtime: {complexity: C4}",
                   "down: {}", "down: [{machine: RS1}]", "down: [{machine: C-RS1, begin_s: 1, end_s: 2}]", "down: [{machine: RS1, begin_s: 2, end_s: 1}]", "layout: []", "layout: [{machine: C-BS, zone: C_Z99}]", "orders: [", "a: &a [*a]", "orders: [{complexity: C0, base_color: BASE_RED, ring_colors: [RING_BLUE], cap_color: CAP_GREY}]", "orders: [{complexity: C0, base_color: BASE_RED, ring_colors: [], cap_color: CAP_GREY, quantity: 0}]",
                   "orders: [{complexity: C0, base_color: BASE_RED, ring_colors: [], cap_color: CAP_GREY, delivery_gate: 4}]", "orders: [{complexity: C0, base_color: BASE_RED, ring_colors: [], cap_color: CAP_GREY, delivery_begin: 9, delivery_end: 3}]",
                   "layout: [{machine: C-BS, zone: C_Z23, rotation: 90}, {machine: C-BS, zone: C_Z24, rotation: 90}]", "layout: [{machine: C-BS, zone: C_Z23, rotation: 90}, {machine: C-DS, zone: C_Z23, rotation: 90}]", "schema: 1", "ring_prices: {RING_BLUE: -1, RING_GREEN: 0, RING_ORANGE: 1, RING_YELLOW: 2}")],
    *[scenario(f"timed {key}", f"schema: 1\ntier: timed\nworld: {{kind: rcll}}\ntimed: {{{key}}}\n") for key in ("pick_mean_s: -1", "drive_failure: 2", "drive_failure: -0.1", "pick_men_s: 1", "place_sigma_s: x")],
    *[scenario(f"fault {text}", f"schema: 1\ntier: timed\nworld: {{kind: rcll}}\nfaults: [{text}]\n")
      for text in ("{kind: skill_fails, at: -1}", "{kind: skill_fails, probability: 2}", "{kind: skill_fails, robot: robot9, at: 1}", "{kind: skill_fails, skill: pik, at: 1}", "{kind: skill_fails, at: 1, error: x}", "{kind: skill_fails, at: 1, error: 0}", "{kind: skill_stalls, at: 1}", "{kind: piece_dropped}",
                   "{kind: machine_breaks, at: 1, machine: C-XS}", "{kind: machine_down, at: 1, machine: C-BS}", "{kind: machine_down, at: 1, mean_s: 2, machine: C-BS, seconds: 3}", "{kind: piece_dropped, mean_s: 0}", "{kind: skill_fails, probability: 0.1, from: 9, until: 3}", "{kind: skill_fails, probability: 0.1, times: -1}")],
    wrong("package of a name that is no UTF-8", RUN, 0, files={"scenario.yaml": SCENARIO.encode().replace(b"{rules: rules}", b"{rules: rules, \xe4\xff: rules}")}),
    *[scenario(f"agent {text}", f"schema: 1\nduration_s: 1\nagents: [{text}]\n")
      for text in ("{config: missing.yaml}", "{config: rules}", "{config: garbage}", "{config: agent.yaml, namespace: a b}", "{config: agent.yaml, remap: {a: b c}}", "{config: agent.yaml, remap: x}", "{config: agent.yaml, packages: {rules: missing}}",
                   "{config: agent.yaml, params: x}", "{config: agent.yaml, params: {x: 1}}", "{config: agent.yaml, params: {clips_manger.executive.refresh_rate: 10}}", "{config: agent.yaml, packages: {rules: rules}, params: {clips_manager.executive.refresh_rate: x}}", "{config: agent.yaml, activate: 5}", "{config: agent.yaml, confg: x}")],
    *[scenario(kind, text)
      for kind, text in (("tab", "schema: 1\n\tseed: 1\n"), ("two documents", SCENARIO + "---\nschema: 1\n"), ("documents without end", ",z{]{{{ b:"), ("key twice", SCENARIO + "duration_s: 3\n"), ("cycle of aliases", "schema: 1\nworld: &a {kind: *a}\n"),
                         ("many aliases", "schema: 1\na0: &a0 [1,1,1,1,1,1,1,1,1]\n" + "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 12))), ("deep", "schema: 1\nworld: " + "[" * 5000),
                         ("unknown alias", "schema: *nothing\n"), ("bytes", "schema: 1\nseed: \u0000\n"), ("list", "- schema: 1\n"), ("open quote", 'schema: "1\n'), ("merge", "schema: 1\n<<: {seed: x}\n"),
                         ("tick that is no multiple of the step", "schema: 1\nworld: {kind: rcll}\ntick_s: 0.02\nphysics_step_s: 0.015\n"), ("byte order mark and nothing", "\ufeff"))],
]

# --- configurations of the CLIPS-Executive


def config(name, text, code, command=RUN):
    return wrong(name, command, code, files={"agent.yaml": text})


ROWS["configurations"] = [
    *[config(f"{name}", CONFIG.replace(find, put, 1), code)
      for name, code, find, put in (("class misspelt", 3, "cx::RosMsgsPlugin", "cx::RosMsgPlugin"), ("class empty", 3, "cx::RosMsgsPlugin", ""), ("class of another kind", 3, '{plugin: "cx::RosMsgsPlugin"}', "5"), ("plugin without a class", 3, 'ros_msgs: {plugin: "cx::RosMsgsPlugin"}', "ros_msgs: {}"),
                                    ("plugin without parameters", 3, '    ros_msgs: {plugin: "cx::RosMsgsPlugin"}\n', ""), ("plugins no list", 3, '["executive", "ros_msgs", "files"]', "executive"),
                                    ("plugins of numbers", 3, '["executive", "ros_msgs", "files"]', "[1, 2]"), ("environments no list", 3, '["main"]', "main"), ("environments of numbers", 3, '["main"]', "[1]"), ("environment twice", 3, '["main"]', '["main", "main"]'),
                                    ("environment without a name", 3, '["main"]', '[""]'), ("rate 0", 3, "refresh_rate: 10", "refresh_rate: 0"), ("rate negative", 3, "refresh_rate: 10", "refresh_rate: -3"), ("rate a text", 3, "refresh_rate: 10", "refresh_rate: fast"),
                                    ("rate huge", 3, "refresh_rate: 10", "refresh_rate: 99999999999999999999"), ("rate of a list", 3, "refresh_rate: 10", "refresh_rate: [1]"), ("rate nan", 3, "refresh_rate: 10", "refresh_rate: .nan"), ("load no list", 3, '["rules.clp"]', "rules.clp"),
                                    ("load of a missing file", 3, '["rules.clp"]', '["ruls.clp"]'), ("load of a folder", 3, '["rules.clp"]', '["."]'), ("load of the parent", 3, '["rules.clp"]', '["../rules.clp"]'), ("share folder unknown", 3, '["rules"]', '["ruls"]'),
                                    ("share folder empty", 3, '["rules"]', '[""]'), ("watch unknown", 3, 'main: {plugins:', 'main: {watch: ["fcts"], plugins:'), ("assert_time a text", 3, "refresh_rate: 10", "assert_time: maybe"), ("publish_on_refresh a text", 3, "refresh_rate: 10", "publish_on_refresh: 5"))],
    *[config(f"strict {name}", CONFIG.replace(find, put, 1), 3, command=[*RUN, "--strict-cx"])
      for name, find, put in (("rate misspelt", "refresh_rate", "refresh_rat"), ("load misspelt", "load:", "laod:"), ("environment key", "main: {plugins:", "main: {wach: [], plugins:"), ("environments misspelt", "environments:", "environment:"))],
    *[config(kind, text, 3)
      for kind, text in (("no parameters", "/**:\n  ros__params:\n    environments: [main]\n"), ("another node", "other_manager:\n  ros__parameters:\n    environments: [main]\n"), ("scalar", "hello\n"), ("list", "- a\n"), ("open bracket", "/**:\n  ros__parameters: [\n"),
                         ("tab", "/**:\n\tros__parameters:\n"), ("deep", "/**: " + "[" * 5000), ("cycle of aliases", "/**: &a\n  ros__parameters: *a\n"), ("two documents", CONFIG + "---\n" + CONFIG.replace('"main"', '"other"', 1)), ("documents without end", ",z{]{{{ b:"))],
    config("nothing", "", 3),
]

# --- libraries of plugins

OWN = """/**:
  ros__parameters:
    environments: ["main"]
    main: {plugins: ["mine"]}
    mine: {plugin: "own::X"}
"""


def library(source):
    """A shared library made from C++."""
    return lambda path: subprocess.run(["c++", "-shared", "-fPIC", "-x", "c++", "-", "-o", path], input=source, text=True, check=True)


def own(name, code, content=None, manifest='{library: libx.so, plugins: [{class: "own::X"}]}\n', **more):
    files = {"agent.yaml": OWN, "share/own/cxlab_plugins.yaml": manifest, **({} if content is None else {"share/own/libx.so": content}), **more}
    return wrong(f"library {name}", ["env", "agent.yaml", "--package", "own=share/own", "--until", "1", "--quiet", "--out", "out"], code, files=files)


ENTRY = 'extern "C" const void* cxlab_plugin_exports() { %s }\n'
ROWS["plugin libraries"] = [
    own("missing", 5), own("that is a folder", 5, **{"share/own/libx.so/file": ""}), own("empty", 5, ""), own("that is a text", 5, "not a library\n" * 100), own("of garbage", 5, b"\x7fELF" + bytes(range(256)) * 8),
    own("without the entry", 3, library("int f() { return 1; }")), own("of another version", 3, library('const char* exports[] = {"0.0.1", "own::X", nullptr};\n' + ENTRY % "return exports;")),
    own("with a symbol missing", 5, library("void missing();\n" + ENTRY % "missing(); return nullptr;")), own("whose entry returns nothing", 3, library(ENTRY % "return nullptr;")),
    own("whose entry throws", 4, library("#include <stdexcept>\n" + ENTRY % 'throw std::runtime_error("no luck");')),
    own("that throws at load", 4, library('#include <stdexcept>\nstruct T { T() { throw std::runtime_error("no luck"); } } t;\n' + ENTRY % "return nullptr;")),
    own("that throws at load, twice", 4, library("struct T { T() { throw 5; } } t;\n" + ENTRY % "return nullptr;"), **{"agent.yaml": OWN.replace('["main"]', '["main", "other"]').replace("    mine:", '    other: {plugins: ["mine"]}\n    mine:')}),
    own("of a manifest without classes", 3, "", "{library: libx.so}\n"), own("of a manifest with a key misspelt", 3, "", '{libary: libx.so, plugins: [{class: "own::X"}]}\n'), own("of a manifest for another class", 3, "", '{library: libx.so, plugins: [{class: "own::Y"}]}\n'),
]

# --- what happens from outside


def stimulus(text):
    return wrong(f"stimulus {text}", [*ENV, "--stimuli", "s.yaml"], 3, files={"s.yaml": f"- {{at: 0, publish: /x, type: std_msgs/msg/String, data: {{data: a}}}}\n- {text}\n"})


ROWS["stimuli"] = [stimulus(text) for text in (
    "{at: 1}", "{publish: /x, type: std_msgs/msg/String}", "{at: x, publish: /x, type: std_msgs/msg/String}", "{at: -1, publish: /x, type: std_msgs/msg/String}", "{at: .nan, publish: /x, type: std_msgs/msg/String}", "{at: 1, publsh: /x, type: std_msgs/msg/String}",
    "{at: 1, publish: /x}", "{at: 1, publish: /x, type: std_msgs/msg/Strin}", "{at: 1, publish: /x, type: String}", "{at: 1, publish: /x, type: nowhere/msg/X}", "{at: 1, publish: a b, type: std_msgs/msg/String}", "{at: 1, publish: '', type: std_msgs/msg/String}",
    "{at: 1, publish: /x, type: std_msgs/msg/String, data: {dat: a}}", "{at: 1, publish: /x, type: std_msgs/msg/String, data: [a]}", "{at: 1, publish: /x, type: std_msgs/msg/String, data: {data: [a]}}", "{at: 1, publish: /x, type: std_msgs/msg/UInt8, data: {data: 300}}",
    "{at: 1, publish: /x, type: std_msgs/msg/UInt8, data: {data: -1}}", "{at: 1, publish: /x, type: std_msgs/msg/Bool, data: {data: maybe}}", "{at: 1, publish: /x, type: std_msgs/msg/Float64, data: {data: x}}", "{at: 1, publish: /x, type: geometry_msgs/msg/Pose, data: {position: {w: 1}}}",
    "{at: 1, publish: /x, type: geometry_msgs/msg/PoseWithCovariance, data: {covariance: [1, 2]}}", "{at: 1, publish: /x, type: std_srvs/srv/Trigger}", "{at: 1, call: /x, type: std_msgs/msg/String}", "{at: 1, call: /x, type: std_srvs/srv/SetBool, request: {dat: true}}",
    "{at: 1, call: /x, type: std_srvs/srv/SetBool, data: {data: true}}", "{at: 1, serve: /x, type: std_srvs/srv/SetBool, response: {sucess: true}}", "{at: 1, send_goal: /x, type: cxlab_skills/action/Pik}", "{at: 1, send_goal: /x, type: cxlab_skills/action/Pick, goal: {targt: a}}",
    "{at: 1, cancel_goal: }", "{at: 1, set_param: x, value: 1}", "{at: 1, set_param: clips_manager.x}", "{at: 1, load_plugin: main}", "{at: 1, load_plugin: {env: main}}", "{at: 1, load_plugin: {env: main, plugn: x}}", "{at: 1, unload_plugin: [a]}",
    "{at: 1, destroy_env: {a: b}}", "{at: 1, stop_node: ''}", "{at: 1, stop_node: a b}", "{at: 1, publish: /x, call: /y, type: std_msgs/msg/String}", "x", "[]", "{}", "{at: 1e30, publish: /x, type: std_msgs/msg/String}")]

# --- stories and suites


def story(name, text, code=3):
    return wrong(f"story {name}", ["test", "one.story.yaml"], code, files={"one.story.yaml": text})


STORY = "common: {rules: rules.clp}\nstories:\n  - story: one\n"
ROWS["stories"] = [
    *[story(text, STORY + f"    {text}\n" + ("" if text.startswith("expect") else "    expect: [{fact: (a), within_s: 1}]\n")) for text in (
        "expects: []", "expect: {}", "expect: x", "expect: [x]", "expect: [{}]", "expect: [{fact: (a), within_s: x}]", "expect: [{fact: (a), within_s: -1}]", "expect: [{fact: (a), withn_s: 1}]", "expect: [{fact: '(a', within_s: 1}]", "expect: [{fact: '', within_s: 1}]", "expect: [{fact: '(a) (b)', within_s: 1}]", "expect: [{fires: mak, within_s: 1}]", "expect: [{fires: make, count: -1}]", "expect: [{fires: make, count: x}]", "expect: [{not_fires: mke, within_s: 1}]", "expect: [{goal: /x, fields: {a: 1}}]",
        "expect: [{published: /x}]", "expect: [{published: /x, type: std_msgs/msg/Strin, within_s: 1}]", "expect: [{published: /x, type: std_msgs/msg/String, fields: {dat: a}, within_s: 1}]", "expect: [{published: /x, type: std_msgs/msg/UInt8, fields: {data: 300}, within_s: 1}]",
        "expect: [{published: /x, type: std_msgs/msg/String, fields: [a], within_s: 1}]", "expect: [{published: /x, type: geometry_msgs/msg/Twist, fields: {linear: {z: 1, xx: 2}}, within_s: 1}]",
        "steps: [{at: 5, publish: /x, type: std_msgs/msg/String, data: {dat: a}}]", "steps: [{at: 5, skill: /x, type: cxlab_skills/action/Pick, result: {sucess: true}}]",
        "expect: [{fact: (a), no_fact: (b)}]", "expect: [{fact: (a), after: 5, within_s: 2}]", "given: (a)",
        "given: ['(a']", "given: [5]", "given: ['(zz (x 1))']", "steps: [{at: 1}]", "steps: [{assert: (a)}]", "steps: [{at: 1, asert: (a)}]", "steps: [{at: 1, assert: '(a'}]", "steps: [{at: 1, retract: '(a'}]", "steps: [{at: x, assert: (a)}]",
        "steps: [{at: 1, publish: /x, type: std_msgs/msg/Strin}]", "skills: [{action: /x}]", "skills: [{action: /x, type: cxlab_skills/action/Pik, outcome: fail}]", "skills: [{action: /x, type: cxlab_skills/action/Pick, outcome: fal}]", "skills: [{action: /x, type: cxlab_skills/action/Pick, outcome: fail, takes_s: -1}]",
        "skills: [{service: /x, type: std_srvs/srv/SetBol, outcome: succeed}]", "serve: x", "seed: x", "seed: -1", "end: -1", "end: x", "environment: man", "config: agent.yaml", "rules: [missing.clp]")],
    *[story(kind, text) for kind, text in (("without rules", "stories:\n  - story: one\n"), ("without a name", "common: {rules: rules.clp}\nstories:\n  - expect: []\n"), ("none", "common: {rules: rules.clp}\nstories: []\n"), ("no list", "common: {rules: rules.clp}\nstories: one\n"),
                                               ("unknown key", "commn: {rules: rules.clp}\nstories: []\n"), ("rules and config", "common: {rules: rules.clp, config: agent.yaml}\nstories:\n  - story: one\n"), ("package missing", "common: {rules: rules.clp, packages: {x: missing}}\nstories:\n  - story: one\n"),
                                               ("twice", STORY + "  - story: one\n"), ("open", "stories: [\n"), ("nothing", ""), ("two documents", STORIES + "---\na: 1\n"), ("documents without end", ",z{]{{{ b:"))],
    story("goal of a field misspelt", STORY + "    skills: [{action: /x, type: cxlab_skills/action/Pick}]\n    expect: [{goal: /x, fields: {targt: a}, within_s: 1}]\n"),
    wrong("story of broken rules", ["test"], 3, files={"rules.clp": "(defrule make => (assert (a)\n"}),
    wrong("story of unknown functions", ["test"], 3, files={"rules.clp": "\n(defrule make => (frobnicate))\n"}),
    wrong("story that fails", ["test"], 1, files={"rules.clp": "(defrule make (b) => (assert (a)))\n"}),
    *[wrong(f"story of control characters, {kind}", ["test"], 0, never=[end], files={"one.story.yaml": STORIES.replace("one", f'"{escape}31mX"')})
      for kind, escape, end in (("ESC", "\\e[", "\x1b"), ("CSI", "\\u009b", "\x9b"), ("RLO", "\\u202e", "\u202e"), ("ZWSP", "\\u200b", "\u200b"), ("BOM", "\\ufeff", "\ufeff"), ("TAG", "\\U000e0041", "\U000e0041"))],
    wrong("story of a name that is no UTF-8, as JSON", ["test", "--json"], 0, files={"one.story.yaml": STORIES.encode().replace(b"one", b"\xe4\xff")}),
    wrong("story of an error", ["test"], 1, files={"rules.clp": "(defrule make => (assert (a)) (/ 1 0))\n"}),
    *[wrong(f"suite {name}", ["bench", "suite.yaml", "--out", "out"], 3, files={"suite.yaml": text}) for name, text in (
        ("without scenarios", "seeds: [1]\nstrategies: {s: []}\n"), ("without seeds", "scenarios: [scenario.yaml]\nstrategies: {s: []}\n"), ("without strategies", "scenarios: [scenario.yaml]\nseeds: [1]\n"), ("no scenarios", SUITE.replace("[scenario.yaml]", "[]")), ("missing scenario", SUITE.replace("scenario.yaml", "missing.yaml")),
        ("scenario twice", SUITE.replace("[scenario.yaml]", "[scenario.yaml, scenario.yaml]")), ("seed twice", SUITE.replace("[1]", "[1, 1]")), ("seed negative", SUITE.replace("[1]", "[-1]")), ("seed a text", SUITE.replace("[1]", "[x]")), ("no seeds", SUITE.replace("[1]", "[]")), ("seeds reversed", SUITE.replace("[1]", '"9..0"')),
        ("seeds negative", SUITE.replace("[1]", '"-1..-1"')), ("seeds without an end", SUITE.replace("[1]", '"1.."')), ("too many seeds", SUITE.replace("[1]", '"0..99999999999"')), ("seeds of words", SUITE.replace("[1]", '"a..b"')), ("tier", SUITE + "tier: fast\n"), ("unknown key", SUITE + "sedes: 1\n"),
        ("override misspelt", SUITE.replace("{s: []}", '{s: ["sed=1"]}')), ("override without a value", SUITE.replace("{s: []}", '{s: ["seed"]}')), ("override no list", SUITE.replace("{s: []}", "{s: 5}")), ("strategies no map", SUITE.replace("{s: []}", "[s]")), ("no strategies", SUITE.replace("{s: []}", "{}")),
        ("strategy without a name", SUITE.replace("{s: []}", "{'': []}")), ("strategy of a path", SUITE.replace("{s: []}", "{'../x': []}")), ("open", "scenarios: [\n"), ("wrong scenario", SUITE.replace("scenario.yaml", "garbage")))],
]

# --- rules

HEAD = "(deftemplate pose (slot x (type INTEGER)) (slot s (allowed-values A B)))\n(deffacts start (go))\n"


def rules(name, text, code=3):
    return wrong(name, [*RUN, "--set", "duration_s=0.1"], code, files={"rules/rules.clp": HEAD + text})


ROWS["rules"] = [
    rules("instance of a slot that is not there", "(defclass A (is-a USER))\n(definstances d (a of A (y 1)))", code=4),
    wrong("rules behind a comment that ends with a carriage return", RUN, 3, files={"rules/rules.clp": b"(defrule a => ) ; fine\r(defrule b => (frob))\r"}),
    rules("fact that cannot be computed", "(deffacts other\n  (x (/ 1 0)))", code=4),
    rules("call that cannot be", "(defrule a (go) => (call f))", code=4),
    *[rules(text.replace("\n", " ")[:100], text) for text in (
    "(defrule a\n  (go)\n  =>", "(defrule a\n  (go))\n  => )", "(defrule\n  => )", "(defrule a\n  (go)\n  (println x))", "(defrule a (go\n", "(defrule a (go))\n)", "defrule a (go) => )", "(defrul a (go) => )", "(defrule a (pose (y 1)) => )", "(defrule a (pse (x 1)) => )",
    "(defrule a (pose (x one)) => )", "(defrule a (pose (s C)) => )", "(defrule a (go) => (frobnicate))", "(defrule a (go) => (prinout t x))", "(defrule a (go) => (assert (pose (z 1))))", "(defrule a (go) => (assert (pose (x a))))", "(defrule a (go) => (assert (pose (s C))))", "(defrule a (go) => (bind x 1))",
    "(defrule a (go) => (bind ?x))\n(defrule b (go) => (printout t ?y))", "(defrule a (go) => (modify ?f (x 1)))", "(defrule a (go) => (retract ?f))", "(defrule a ?f <- (not (go)) => )", "(defrule a (test (> ?x 1)) (pose (x ?x)) => )", "(defrule a (pose (x ?x&:(> ?y 1))) => )", "(defrule a (or (go) (pose (x ?x))) => (printout t ?x))",
    "(defrule a (declare (salience high)) (go) => )", "(defrule a (declare (salence 1)) (go) => )", "(defrule a (declare (salience 20000)) (go) => )", "(defrule a (declare (salience 4294967297)) (go) => )", "(defglobal ?*s* = -4294967297)\n(defrule a (go) => )\n(defrule b\n  (declare (salience ?*s*)) (go) => )", "(defrule a (logical (not (go))) (go) (logical (go)) => )", "(defrule a (go) => (if TRUE (println x)))", "(defrule a (go) => (while))", "(defrule a (go) => (loop-for-count (x 1 2)))",
    "(defrule a (exists) => )", "(defrule a (forall (go)) => )", "(defrule a (and) => )", "(defrule a (go) => (assert))", "(defrule a (go) => (+ 1))", "(defrule a (go) => (+ 1 a))", "(defrule a (go) => (str-cat))", "(defrule a (go) => (nth$ a 1))", "(defrule a (go) => (do-for-all-facts ((?f pse)) TRUE))",
    '(defrule a (go) => (println "open))', "(defrule a (go) => (println ?*none*))", "(defrule a (go) => (ros-msgs-create-message))", "(defrule a (go) => (ros-msgs-crate-message a))", "(defrule a (go) => (now 5))", "(defrule NOWHERE::a (go) => )", "(defrule a (go) => (focus))",
    "(deftemplate)", "(deftemplate t (slt x))", "(deftemplate t (slot x) (slot x))", "(deftemplate t (slot x (type INTGER)))", "(deftemplate t (slot x (default a) (type INTEGER)))", "(deftemplate t (slot x (range 5 1)))", "(deftemplate t (slot x (allowed-values)))", "(deftemplate t (multislot x (cardinality 3 1)))", "(deftemplate t (slot x (cardinality 1 2)))",
    "(deftemplate pose (slot other))\n(defrule a (pose (x 1)) => )", "(deftemplate t x)", "(deffacts f (pose (z 1)))", "(deffacts f (pose (x a)))", "(deffacts f (pse (x 1)))", "(deffacts f go)", "(deffacts)", "(deffacts f (pose (x ?x)))", "(defglobal x = 1)", "(defglobal ?*x* 1)", "(defglobal ?*x* = (frobnicate))", "(defglobal ?*x* = )", "(defglobal NOWHERE ?*x* = 1)",
    "(deffunction)", "(deffunction f)", "(deffunction f (x))", "(deffunction f (?x ?x))", "(deffunction f ($?x ?y))", "(deffunction f (?x) (frobnicate ?x))", "(deffunction f (?x) ?y)", "(deffunction printout (?x))", "(deffunction f (?x) (+ ?x))", "(deffunction f (?x) ?x)\n(defrule a (go) => (f))", "(deffunction f (?x) ?x)\n(defrule a (go) => (f 1 2))",
    "(defmodule)", "(defmodule M (import NOWHERE ?ALL))", "(defmodule M (exprt ?ALL))", "(defmodule M)\n(defmodule M (export ?ALL))", "(defmodule M)\n(defrule M::a (pose (x 1)) => (frobnicate))", "(defclass)", "(defclass A)", "(defclass A (is-a NOTHING))", "(defclass A (is-a USER) (slot x) (slot x))", "(defclass A (is-a USER) (slot x (create-accessor maybe)))",
    "(defclass A (is-a A))", "(defmessage-handler NOTHING f ())", "(defclass A (is-a USER))\n(defmessage-handler A f () (frobnicate))", "(defclass A (is-a USER))\n(defmessage-handler A f sideways ())", "(definstances d (a of NOTHING))", "(defmethod f ((?x NOTHING)) 1)", "(defmethod f (?x ?x) 1)",
    "(defmethod f ((?x INTEGER INTEGER)) 1)", "(println 5)", "5", "\\", "(defrule a (go) => ))", ")", "(", '"', "(defrule a (go) =>\n  (bind ?x (create$ a b)\n  (println ?x))\n(defrule b (go) => )", "; fine\n(defrule a (pose (x ?x) (x ?y)) => )", "(defrule time-retract => (frobnicate))", "(defrule a (go) =>\n  (printout t \"a;b\" (frobnicate) crlf))",
    "(defrule a (object (is-a NOTHING)) => )", "(defrule a (go ?x&~) => )", "(defrule a (go |) => )", "(defrule a (pose (x 1 2)) => )", "(defrule a (pose (x $?x)) => )", "(defrule a (pose x) => )", "(defrule a (go) (go => )", "(defrule a => (return 1 2))", "(defrule a (go) => (switch))", "(defrule a (go) => (case 1 then 2))",
    "(defrule a (go) => (assert-string))", "(defrule a (go) => (eval))", "(defrule a ?f <- ?g <- (go) => )", "(defrule a (salience 5) => (duplicate))", "(undefrule)", "(defrule a (test) => )", "(defrule a (test go) => (frob))")]]

# --- PDDL and plans


def plan(name, domain, problem, code=31):
    return wrong(name, ["plan", "d.pddl", "p.pddl"], code, files={"d.pddl": domain, "p.pddl": problem})


ROWS["planning"] = [
    *[wrong(f"plan of a name that is no UTF-8 {option}", ["plan", "d.pddl", "p.pddl", *option.split()], 0, files={"d.pddl": DOMAIN.encode().replace(b"go", b"\xe4\xff"), "out/keep": ""})
      for option in ("--json", "--svg out/plan.svg")],
    wrong("plan behind a byte order mark", ["validate", "d.pddl", "p.pddl", "a.plan"], 0, files={"a.plan": "\ufeff" + PLAN}),
    *[plan(f"domain {name}", DOMAIN.replace(find, put, 1), PROBLEM, code=code) for name, find, put, code in (
        ("cut off", "(not (at ?a)) (at ?b))))", "", 31), ("one parenthesis more", "(at ?b))))", "(at ?b)))))", 31), ("unknown type", "?p - place", "?p - plce", 31), ("type of nothing", "(:types place)", "(:types place - )", 31), ("unknown predicate", "(road ?a ?b))\n    :effect", "(rod ?a ?b))\n    :effect", 31),
        ("predicate with too few", "(road ?a ?b))\n    :effect", "(road ?a))\n    :effect", 31), ("predicate twice", "(road ?a ?b - place)", "(at ?a ?b - place)", 31), ("unknown variable", "(at ?a) (road", "(at ?c) (road", 31), ("variable of another type", "(:types place)", "(:types place thing)", 0), ("requirement unknown", ":strips", ":strps", 34),
        ("requirement unsupported", ":typing", ":typing :preferences", 34), ("section unknown", ":action go", ":actin go", 31), ("section twice", "(:types place)", "(:types place)\n  (:types thing)", 0), ("without a name", "(domain d)", "(domain)", 31), ("action without a name", ":action go", ":action", 31), ("action twice", "  (:action go", "  (:action go :parameters () :effect (and))\n  (:action go", 31),
        ("effect unknown", "(not (at ?a)) (at ?b)", "(forget (at ?a))", 31), ("or in an effect", "(and (not (at ?a)) (at ?b))", "(or (at ?a) (at ?b))", 31), ("precondition of a number", "(road ?a ?b))\n    :effect", "(> 1))\n    :effect", 31), ("function undeclared", "(road ?a ?b))\n    :effect", "(> (fuel) 1))\n    :effect", 31),
        ("parameters no list", ":parameters (?a ?b - place)", ":parameters ?a", 31), ("word after the end", "(at ?b))))", "(at ?b))))\nmore", 31), ("type circle", "(:types place)", "(:types place - thing thing - place)", 31), ("type twice", "(:types place)", "(:types place place)", 0),
        ("type of two supertypes", "(:types place)", "(:types place - site place - area)", 0), ("constant twice", "(:types place)", "(:types place) (:constants c c - place)", 0), ("constant that is an object", "(:types place)", "(:types place) (:constants a - place)", 0),
        ("function twice", "(:types place)", "(:types place) (:functions (n) (n ?a - place))", 31), ("parameter of a predicate twice", "(road ?a ?b - place)", "(road ?a ?b - place) (near ?a ?a - place)", 0),
        ("parameter twice", ":parameters (?a ?b - place)", ":parameters (?a ?b ?a - place)", 31), ("variable of forall twice", "(at ?a) (road", "(forall (?c ?c - place) (at ?a)) (road", 31),
        ("text in quotes", "(domain d)", '(domain "d")', 31), ("number as a name", "(domain d)", "(domain 5)", 31), ("name of other letters", "(domain d)", "(domain dömän)", 31), ("bars", "(domain d)", "(domain |d d|)", 31), ("capitals", "(domain d)", "(DOMAIN D)", 0), ("nothing in it", "(:types place)", "()", 31),
        ("question mark alone", "?p - place", "? - place", 31), ("type that is a variable", "?p - place", "?p - ?place", 31), ("either of nothing", "?p - place", "?p - (either)", 31), ("variable as a predicate", "(at ?a) (road", "(?a ?b) (road", 31), ("not of two", "(not (at ?a))", "(not (at ?a) (at ?b))", 31),
        ("duration below 0", ":requirements :strips", ":requirements :durative-actions :strips", 0), ("derived of itself", "  (:action go", "  (:derived (at ?x - place) (not (at ?x)))\n  (:action go", 31), ("when without an effect", "(not (at ?a)) (at ?b)", "(when (at ?a)) (at ?b)", 31), ("assign in STRIPS", "(not (at ?a))", "(assign (at ?a) 5)", 31),
        ("60 parameters", "(?a ?b - place)", "(" + " ".join(f"?x{i}" for i in range(60)) + " ?a ?b - place)", 0),
        ("action of a predicate's name", "(:action go", "(:action at :effect ())\n  (:action go", 0), ("effect of an action twice", ":effect (and", ":effect () :effect (and", 31))],
    *[plan(f"problem {name}", DOMAIN, PROBLEM.replace(find, put, 1), code=code) for name, find, put, code in (
        ("of another domain", "(:domain d)", "(:domain e)", 31), ("without a domain", "(:domain d)", "", 0), ("unknown object", "(at a) (road", "(at c) (road", 31), ("object twice", "a b - place", "a a b - place", 0), ("object of an unrelated type twice", "a b - place", "a b - place a", 0), ("fact twice", "(at a) (road", "(at a) (at a) (road", 0), ("fact and its negation", "(at a) (road", "(at a) (not (at a)) (road", 31), ("object of an unknown type", "a b - place", "a b - plce", 31), ("fact unknown", "(at a) (road", "(att a) (road", 31), ("fact of too many", "(at a) (road", "(at a b) (road", 31),
        ("number not declared", "(:init", "(:init (= (fuel) 5)", 31), ("fact with a variable", "(at a) (road", "(at ?a) (road", 31), ("without init", "  (:init (at a) (road a b))\n", "", 10), ("without a goal", "  (:goal (at b))", "", 31), ("goal of an unknown object", "(:goal (at b))", "(:goal (at c))", 31), ("goal unknown", "(:goal (at b))", "(:goal (att b))", 31),
        ("goal empty", "(:goal (at b))", "(:goal)", 31), ("unsolvable", "(road a b)", "", 10), ("metric of nothing", "(:goal (at b))", "(:goal (at b)) (:metric minimise)", 31), ("section unknown", "(:init", "(:innit", 31), ("cut off", "(:goal (at b)))", "(:goal (at b))", 31), ("init of a number without a function", "(:init", "(:init 5", 31), ("timed fact in the past", "(:init", "(:init (at -1 (at b))", 31))],
    *[wrong(f"plan {text!r}", ["validate", "d.pddl", "p.pddl", "a.plan"], code, files={"a.plan": text}) for text, code in (
        ("go a b\n", 31), ("(go a b\n", 31), ("0: (go a)\n", 31), ("0: (go a b c)\n", 31), ("0: (gp a b)\n", 31), ("0: (go a z)\n", 31), ("x: (go a b)\n", 31), ("-1: (go a b)\n", 1), ("0: (go a b) [x]\n", 31), ("nan: (go a b)\n", 31), ("inf: (go a b)\n", 31), ("1e400: (go a b)\n", 31),
        ("0: (go b a)\n", 1), ("0: ()\n", 31), ("0: go\n", 31), ("0 (go a b)\n", 31), ("; nothing\n", 1), ("0: (go a b) (go b a)\n", 31))],
]

# --- what YAML can be, beside what people mean

YAML = {  # scenarios by what is odd in them
    "anchors": (0, "schema: &one 1\nseed: *one\nduration_s: *one\n"), "a merge of keys": (3, "schema: 1\nworld: {<<: {kind: none}}\n"), "a key that is an alias": (3, "schema: 1\n? &k seed\n: 1\n*k : 2\n"),
    "a tag of Python": (3, "schema: 1\nseed: !!python/object/apply:os.system [touch made]\n"), "a tag of text": (0, SCENARIO + "seed: !!str 5\n"), "a tag of bytes": (3, "schema: 1\nseed: !!binary aGVsbG8=\n"), "a tag of its own": (3, "schema: 1\nagents: !include agent.yaml\n"),
    "an octal number": (3, "schema: 1\nseed: 0o17\n"), "a number with a zero before it": (0, SCENARIO + "seed: 017\n"), "a hexadecimal number": (3, "schema: 1\nseed: 0x1F\n"), "a number with underlines": (3, "schema: 1\nseed: 1_000\n"), "a time of day": (3, "schema: 1\nduration_s: 1:30\n"),
    "a date": (3, "schema: 1\nepoch: 2026-01-01\n"), "a percentage": (3, "schema: 1\nduration_s: 50%\n"), "a number of Arabic digits": (3, "schema: 1\nseed: ٣\n"), "a number with a comma": (3, "schema: 1\nduration_s: 1,5\n"), "a number and its unit": (3, "schema: 1\nduration_s: 90 s\n"),
    "yes for true": (0, SCENARIO + "trust_rules: no\n"), "a null": (0, SCENARIO + "seed: ~\n"), "an empty value": (0, SCENARIO + "seed:\n"), "a number as a key": (3, "schema: 1\n5: 1\n"), "a list as a key": (3, "schema: 1\n[a, b]: 1\n"), "an empty key": (3, "schema: 1\n'': 1\n"),
    "a block of text": (3, "schema: 1\nduration_s: |\n  5\n  6\n"), "a list in one line too many": (3, "schema: 1\nagents: [{config: agent.yaml}]]\n"), "lines that end in CR LF": (3, SCENARIO.replace("duration_s: 2", "duration_s: x").replace("\n", "\r\n")),
    "lines that end in CR": (3, SCENARIO.replace("duration_s: 2", "duration_s: x").replace("\n", "\r")), "UTF-16": (0, SCENARIO.encode("utf-16")), "a byte of Latin-1": (3, b"schema: 1\nworld: {kind: m\xf6nd}\n"), "a document mark of a version": (3, "%YAML 9.9\n---\nschema: 1\nseed: x\n"),
    "only comments": (3, "# schema: 1\n"), "a key of 100,000 letters": (3, "schema: 1\n" + "k" * 100000 + ": 1\n"), "a number of 100,000 digits": (3, "schema: 1\nseed: " + "9" * 100000 + "\n"), "spaces that do not break": (3, "schema: 1\n seed: 1\n"), "quotes of a word processor": (3, "schema: 1\nworld: {kind: “none”}\n"),
    "the largest seed": (0, SCENARIO + "seed: 18446744073709551615\n"), "a duration that is too long": (3, "schema: 1\nduration_s: 1000000001\n"), "firings beyond 64 bits": (3, SCENARIO + "max_firings_per_tick: 9223372036854775808\n"),
}
ROWS["yaml"] = [scenario(name, text, code) if isinstance(text, str) else wrong(name, RUN, code, files={"scenario.yaml": text}) for name, (code, text) in YAML.items()]

# --- what is no file, for each option and key that names one

SPECIAL = {"a pipe": os.mkfifo, "a folder": os.mkdir, "a device": lambda path: path.symlink_to("/dev/zero"), "links in a circle": lambda path: path.symlink_to(path.name)}
READ = {"run": (3, ["run", "it", "--quiet", "--out", "out"]), "env": (3, ["env", "it", "--quiet", "--out", "out"]), "stimuli": (3, [*ENV, "--stimuli", "it"]), "suite": (3, ["bench", "it", "--out", "out"]), "domain": (31, ["plan", "it", "p.pddl"]), "problem": (31, ["plan", "d.pddl", "it"]),
        "plan": (31, ["validate", "d.pddl", "p.pddl", "it"]), "game": (3, ["run", "game.yaml", "--set", "world.game=it", "--quiet", "--out", "out"]), "configuration": (3, [*RUN, "--set", "agents[0].config=it"]), "scenario of a suite": (3, ["bench", "of.yaml", "--out", "out"])}
WRITTEN = {"run --out": (2, [*RUN[:-1], "it"]), "plan --out": (5, ["plan", "d.pddl", "p.pddl", "--out", "it"]), "plan --svg": (5, ["plan", "d.pddl", "p.pddl", "--svg", "it"]), "test --junit": (5, ["test", "--junit", "it"]), "test --coverage": (5, ["test", "--coverage", "it"]),
           "render --out": (5, ["render", "turtles.yaml", "--at", "0", "--out", "it.png"]), "bench --out": (5, ["bench", "suite.yaml", "--out", "it"])}
ROWS["special files"] = [
    *[wrong(f"{name} of {kind}", command, code, files={"it": make, "of.yaml": SUITE.replace("scenario.yaml", "it")})
      for name, (code, command) in READ.items() for kind, make in SPECIAL.items()],
    *[wrong(f"{name} to {kind}", command, code, files={("it.png" if name.startswith("render") else "it"): SPECIAL[kind]})
      for name, (code, command) in WRITTEN.items() for kind in ("a pipe", "a folder", "links in a circle") if kind == "a pipe" or not name.startswith(("run", "bench"))],
    *[wrong(f"{name} to links in a circle", command, 5, files={"it": SPECIAL["links in a circle"]}) for name, (_, command) in WRITTEN.items() if name.startswith(("run", "bench"))],
    wrong("prefix that is a file", [*RUN, "--prefix", "nothing"], 3), wrong("package that is links in a circle", [*ENV, "--package", "more=it"], 3, files={"it": SPECIAL["links in a circle"]}),
]

# --- values of messages

VALUES = {"int64: 9223372036854775808": "std_msgs/msg/Int64", "uint64: 18446744073709551616": "std_msgs/msg/UInt64", "int32: 1.5": "std_msgs/msg/Int32", "int16: 0x10000": "std_msgs/msg/Int16", "byte: 256": "std_msgs/msg/Byte", "char: -1": "std_msgs/msg/Char", "float32: 1e300": "std_msgs/msg/Float32",
          "float64: 1e400": "std_msgs/msg/Float64", "bool: 2": "std_msgs/msg/Bool", "bool: 'truth'": "std_msgs/msg/Bool", "string: [a]": "std_msgs/msg/String", "string: {a: b}": "std_msgs/msg/String", "int32: ''": "std_msgs/msg/Int32", "int32: ~": "std_msgs/msg/Int32"}
ROWS["values"] = [
    *[wrong(f"value {name}", [*ENV, "--stimuli", "s.yaml"], 3, files={"s.yaml": f"- {{at: 0, publish: /x, type: {kind}, data: {{data: {name.split(': ', 1)[1]}}}}}\n"}) for name, kind in VALUES.items()],
    *[wrong(f"value {data}", [*ENV, "--stimuli", "s.yaml"], 3, files={"s.yaml": f"- {{at: 0, publish: /x, type: {kind}, data: {data}}}\n"})
      for kind, data in (("std_msgs/msg/Header", "{stamp: {nanosec: 4294967296}}"), ("std_msgs/msg/Header", "{stamp: 5}"), ("unique_identifier_msgs/msg/UUID", "{uuid: [1, 2, 3]}"), ("unique_identifier_msgs/msg/UUID", "{uuid: text}"),
                         ("std_msgs/msg/UInt8MultiArray", "{data: [1, 256]}"), ("std_msgs/msg/UInt8MultiArray", "{data: 5}"), ("geometry_msgs/msg/PoseArray", "{poses: [{position: {x: a}}]}"), ("geometry_msgs/msg/PoseArray", "{poses: {x: 1}}"),
                         ("geometry_msgs/msg/Pose", "{position: [1, 2, 3]}"), ("geometry_msgs/msg/Pose", "{position.x: 1}"))],
]

# --- definitions of interfaces


def definition(name, kind, text):
    command = ["doc", f"own/{kind}/X", "--package", "own=own"]
    return wrong(f"{kind} {name}", command, 3, files={f"own/{kind}/X.{kind}": text})


ROWS["definitions"] = [
    wrong("interface with a byte order mark", ["doc", "own/msg/X", "--package", "own=own"], 0, never=["ufeff", "\ufeff"], files={"own/msg/X.msg": b"\xef\xbb\xbfint32 a\n"}),
    wrong("interface of lines that end in CR LF, and its control characters", ["doc", "own/msg/X", "--package", "own=own"], 0, never=["\r", "\x1b"], files={"own/msg/X.msg": b"int32 a\r\nstring B=\"\x1b[31m\"\r\n"}),
    *[definition(repr(text), "msg", text) for text in ("int32\n", "int23 a\n", "int32 a\nint32 a\n", "int32 A\n", "int32 1a\n", "int32 a__b\n", "int32[ a\n", "int32[-1] a\n", "int32[x] a\n", "int32[<=] a\n", "string<= a\n", "string<=x a\n", "int32 a 5 6\n", "int8 a 300\n", "uint8 a -1\n", "bool a maybe\n", "int8 A=300\n", "int32 A=\n",
                                                            "int32 A=x\n", "string A=\"open\n", "own/Y a\n", "own/X a\n", "nowhere/Y a\n", "Strin a\n", "int32[99999999999] a\n", "int32[3] a [1, 2]\n", "float32 a x\n", "int32 a_\n", "int32 a-b\n", "---\n", "int32 a\n---\nint32 b\n", "string[<=2] a [\"a\", \"b\", \"c\"]\n", "int32 A=1\nint32 A=2\n", "std_msgs/msg/Strin a\n", "\u0000\n")],
    *[definition(repr(text), "srv", text) for text in ("int32 a\n", "int32 a\n---\nint32 b\n---\nint32 c\n", "int32 a\n--\nint32 b\n", "int32 a\n---\nint23 b\n", "---\nint32 b\nint32 b\n", "")],
    *[definition(repr(text), "action", text) for text in ("int32 a\n", "int32 a\n---\nint32 b\n", "---\n---\n---\n", "---\nint23 a\n---\n", "int32 a\n---\n---\nint32 a\nint32 a\n")],
]

# --- folders of runs that were damaged


def recorded(folder):
    """A run whose rules decide by what a stimulus says. The files it was played from are missing: none lies beside the run."""
    there = pathlib.Path(folder)
    here = there / "gone"
    (here / "rules").mkdir(parents=True)
    (here / "rules/rules.clp").write_text("(defrule start => (ros-msgs-create-subscription \"/x\" \"std_msgs/msg/String\"))\n(defrule said (ros-msgs-message) => (assert (said)))\n"
                                          "(defrule never (never) => (println never))\n")
    (here / "agent.yaml").write_text(CONFIG)
    (here / "scenario.yaml").write_text(SCENARIO + "stimuli: [{at: 0.5, publish: /x, type: std_msgs/msg/String, data: {data: a}}]\n")
    subprocess.run([CXLAB, "run", "scenario.yaml", "--quiet", "--out", "../run"], cwd=here, check=True, stdout=subprocess.DEVNULL)
    return {str(path.relative_to(there)): path.read_bytes() for path in (there / "run").rglob("*") if path.is_file()}


ASKS = {"replay": ["replay", "run"], "rerun": ["rerun", "run", "--quiet", "--out", "out"], "why-not": ["why-not", "run", "never"], "facts": ["facts", "run"], "diff": ["diff", "run", "run"]}


def chunks_of(log):
    """Where the chunks of an input log begin: each has its length, a checksum of 8 bytes, and that many bytes."""
    places = [8]
    while (after := places[-1] + 12 + int.from_bytes(log[places[-1]:places[-1] + 4], "little")) < len(log):
        places.append(after)
    return places


def damaged(run):
    """Each file of the run cut, emptied, missing, of another version or full of garbage, and each command asked about it."""
    copy = next(name for name, content in run.items() if name.startswith("run/files/") and b"(said)" in content)
    manifest, log = run["run/manifest.json"], run["run/inputs.bin"]
    kinds = {
        "manifest.json": [("cut", manifest[:200]), ("empty", b""), ("missing", None), ("garbage", bytes(range(256))), ("no map", b"[]"), ("without keys", b"{}"), ("deep", b"[" * 100000),
                          ("not UTF-8", manifest.replace(b"scenario", b"sc\xff\xfenario", 1))],
        "inputs.bin": [("cut", log[:len(log) - 7]), ("cut between chunks", log[:chunks_of(log)[-1]]), ("cut behind the start", log[:chunks_of(log)[1]]), ("cut early", log[:20]), ("empty", b""), ("missing", None), ("garbage", bytes(range(256)) * 4), ("other version", log[:7] + bytes([log[7] ^ 0x55]) + log[8:]), ("a bit changed", log[:len(log) // 2] + bytes([log[len(log) // 2] ^ 4]) + log[len(log) // 2 + 1:]),
                       ("twice", log + log), ("huge length", log[:12] + b"\xff" * 8 + log[20:])],
        "journal.jsonl": [("missing", None), ("garbage", b"{]\n"), ("cut", run["run/journal.jsonl"][:100])],
        "result.json": [("cut", run["run/result.json"][:50]), ("empty", b""), ("missing", None), ("garbage", bytes(range(256))), ("no map", b"3"), ("without keys", b"{}"), ("other hash", re.sub(rb'("journal_hash": *")....', rb"\g<1>0000", run["run/result.json"]))],
        "files/index.jsonl": [("cut", run["run/files/index.jsonl"][:40]), ("empty", b""), ("missing", None), ("garbage", b"{]\n"), ("of a path", run["run/files/index.jsonl"].replace(b'"hash":"', b'"hash":"../../', 1).replace(b'"hash": "', b'"hash": "../../', 1))],
        copy[4:]: [("changed", b"(defrule other => )"), ("missing", None), ("empty", b"")],
    }
    rows = []
    for name, damages in kinds.items():
        for kind, content in damages:
            files = {k: v for k, v in run.items() if k != "run/" + name}
            if content is not None:
                files["run/" + name] = content
            for command, words in ASKS.items():
                label = "copy" if name == copy[4:] else name
                unread = name == "journal.jsonl" or kind == "other hash" or (name == "inputs.bin" and command == "rerun")
                # A killed run is cut off as well: questions are answered from what is whole.
                whole = name == "inputs.bin" and command in ("why-not", "facts", "diff") and kind in ("cut", "cut between chunks", "a bit changed", "twice")
                rows.append(Row(f"{command} {label} {kind}", words, 0 if unread or whole else 3, files))
    return rows


def asked(run):
    """Wrong questions about a whole run."""
    late = ["--at", "2.5"]
    return [Row("why-not after the end", ["why-not", "run", "never", *late], 2, run), Row("render after the end of a run", ["render", "run", "--out", "x.png", *late], 2, run),
            Row("rerun into a folder that is used", ["rerun", "run", "--quiet", "--out", "used"], 2, run),
            Row("rerun into a folder that is used, by force", ["rerun", "run", "--quiet", "--out", "used", "--force"], 0, run, leaves=("used",), kept={"used/mine.txt": "mine"}),
            *[Row(f"rerun --at '{value}'", ["rerun", "run", "--quiet", "--out", "out", "--at", value], 2, run) for value in ("-1", "x", "", "nan", "0:60", "0:1", "2.5", "1e400")],
            *[Row(f"rerun --at 1 {option} '{value}'", ["rerun", "run", "--quiet", "--out", "out", "--at", "1", option, value], code, run)
              for option, value, code in (("--then", "", 2), ("--then", "missing.clp", 3), ("--then", "garbage", 3), ("--then", "nothing", 3), ("--then", "empty", 3), ("--set", "x", 2), ("--set", "=1", 2),
                                          ("--set", "seed=2", 2), ("--set", "?*x*=", 2), ("--set", "?*x*=)", 2), ("--set", "?x=1", 2), ("--set", "nobody.x=1", 2), ("--set", "clips_manager.=1", 2),
                                          ("--set", "clips_manager.nothing=1", 3), ("--set", "clips_manager.environments=1", 3), ("--set", "?*nothing*=1", 3),
                                          ("--assert", "", 2), ("--assert", "go", 2), ("--assert", "()", 2), ("--assert", "(go", 2), ("--assert", "(gone)", 3), ("--assert", "(pose (y 1))", 3), ("--assert", "(said ?x)", 3),
                                          ("--env", "main", 2), ("--until", "0.5", 2))],
            *[Row(f"rerun {option} without --at", ["rerun", "run", "--quiet", "--out", "out", option, value], 2, run)
              for option, value in (("--then", "rules.clp"), ("--set", "?*x*=1"), ("--assert", "(go)"), ("--env", "main"), ("--until", "1"))]]


def with_library(folder):
    """A run with a plugin whose library makes a file when it is opened."""
    here = pathlib.Path(folder)
    (here / "agent.yaml").write_text(OWN)
    (here / "own").mkdir()
    (here / "own/cxlab_plugins.yaml").write_text('{library: libx.so, plugins: [{class: "own::X"}]}\n')
    library('#include <cstdio>\nstruct T { T() { std::fopen("made-by-library", "w"); } } t;\n')(here / "own/libx.so")
    subprocess.run([CXLAB, "env", "agent.yaml", "--package", "own=own", "--until", "1", "--quiet", "--out", "run"], cwd=here, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    assert (here / "made-by-library").exists()
    return {str(path.relative_to(here)): path.read_bytes() for path in (here / "run").rglob("*") if path.is_file()}


with tempfile.TemporaryDirectory(prefix="cxlab-row-") as made, tempfile.TemporaryDirectory(prefix="cxlab-row-") as native:
    whole = recorded(made)
    ROWS["whole runs"] = asked(whole)
    ROWS["damaged runs"] = damaged(whole)
    run = with_library(native)
    ROWS["native runs"] = [Row(f"{command} of a stranger's library", words, 2, run) for command, words in {**ASKS, "coverage": ["coverage", "run"]}.items()]
    manifest = whole["run/manifest.json"].replace(b'"overrides": []', b'''"overrides": ["servers=[{node: pddl_manager, command: 'touch made {plan}'}]"]''')
    assert manifest != whole["run/manifest.json"]
    ROWS["native runs"].append(Row("rerun of a stranger's planner", ASKS["rerun"], 2, {**whole, "run/manifest.json": manifest}))
    ROWS["native runs"].append(Row("replay of a trusted library", [*ASKS["replay"], "--trust-programs"], 0, run, leaves=("out", "made-by-library"), kept={"made-by-library": ""}))


