"""cxlab facts, agenda, globals, firings, rules and why: questions about a moment of a recorded run."""

import collections
import json
import os
import random
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from lab import CXLAB, SOURCE, stopped_run

GAME = SOURCE / "scenarios/rcll/game.yaml"

AGENT = """(deftemplate job (slot id) (slot state (default OPEN)) (slot worker (default NONE)))
(defglobal ?*limit* = 2)
(deffacts jobs (job (id 2)) (job (id 1)) (free a))
(defrule begin
  (time ?now&:(>= ?now 1))
  ?j <- (job (id ?id) (state OPEN))
  ?f <- (free ?who)
  =>
  (retract ?f)
  (modify ?j (state BUSY) (worker ?who))
  (assert (work ?id ?who (+ ?now 1))))
(defrule end
  (time ?now)
  ?w <- (work ?id ?who ?until&:(>= ?now ?until))
  ?j <- (job (id ?id) (state BUSY))
  =>
  (retract ?w)
  (modify ?j (state DONE))
  (bind ?*limit* (- ?*limit* 1))
  (assert (free ?who)))
(defrule never (job (id ?id) (state LOST)) => (assert (lost ?id)))
(defrule robbed (declare (salience -1)) (time ?now&:(>= ?now 1)) (free ?who) (job (state OPEN)) => (assert (idle ?who)))
"""


def values(record):
    """The slots of a fact's record, as --json has them."""
    return {name: value for name, value in record["data"]["slots"].items()}


class Lab(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="cxlab-questions-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def cxlab(self, *arguments, expect=0):
        done = subprocess.run([CXLAB, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder, timeout=120)
        self.assertEqual(done.returncode, expect, f"cxlab {arguments}\n{done.stdout[-2000:]}\n{done.stderr}")
        return done

    def answer(self, *arguments):
        return json.loads(self.cxlab(*arguments, "--json").stdout)["environments"][0]

    def agent(self, rules=AGENT, until=6, out="run", name="main", expect=0, more=()):
        package = self.folder / "mine"
        (package / "params").mkdir(parents=True, exist_ok=True)
        names = name.split('", "')
        (package / "params/mine.yaml").write_text(f"""
clips_manager:
  ros__parameters:
    environments: ["{name}"]
{"".join(f'    {one}: {{plugins: ["executive", "files"]}}' + chr(10) for one in names)}
    executive: {{plugin: "cx::ExecutivePlugin", refresh_rate: 2}}
    files: {{plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["mine"], load: ["mine.clp"]}}
""")
        (package / "mine.clp").write_text(rules)
        run = self.folder / out
        self.cxlab("env", package / "params/mine.yaml", "--until", until, "--quiet", "--out", run, "--journal", "full",
                   *more, expect=expect)
        return run


class Questions(Lab):
    def test_facts_at_a_time_with_who_made_and_changed_them(self):
        run = self.agent()
        states = lambda at: [f["slots"]["state"] for f in self.answer("facts", run, "job", "--at", at)["facts"]]
        self.assertEqual(states(0.5), ["OPEN", "OPEN"])
        self.assertEqual(states(1), ["OPEN", "BUSY"])
        # The worker is free again at 2 s, and begins at once.
        self.assertEqual(states(2), ["BUSY", "DONE"])
        self.assertEqual(states(6), ["DONE", "DONE"])
        first = self.answer("facts", run, "(job (id 1))")["facts"][0]
        self.assertEqual([(c["t_s"], c["what"], c["by"].get("name")) for c in first["changes"]],
                         [(0.0, "assert", None), (1.0, "modify", "begin"), (2.0, "modify", "end")])
        self.assertEqual(first["changes"][0]["by"]["kind"], "start")
        text = self.cxlab("facts", run, "(job (id 1))", "--at", 1).stdout
        self.assertRegex(text, r"after the tick at 1.000 s:\nf-\d+ +\(job \(id 1\) \(state BUSY\) \(worker a\)\)\n"
                               r" +asserted at 0.000 s by the start of the environment; changed once at 1.000 s by rule begin\n")
        self.assertRegex(self.cxlab("facts", run, "(job (id 1))", "--changes").stdout,
                         r"1.000 s  changed   by rule begin: state = BUSY \(was OPEN\), worker = a \(was NONE\)\n")
        index = self.answer("facts", run, "(job (id 2))")["facts"][0]["fact"]
        self.assertEqual(self.answer("facts", run, index)["facts"][0]["slots"]["id"], 2)

    def test_facts_of_a_stretch_are_those_that_were_there(self):
        run = self.agent()
        work = lambda *more: [(f["slots"]["implied"][0], f["present"]) for f in self.answer("facts", run, "work", *more)["facts"]]
        self.assertEqual(work("--from", 0, "--to", 0.5), [])
        self.assertEqual(work("--from", 0, "--to", 1), [(1, True)])
        self.assertEqual(work("--from", 1.5, "--to", 1.9), [(1, True)])
        self.assertEqual(work("--from", 2.1, "--to", 6), [(2, False)])
        self.assertEqual(work("--from", 0), [(1, False), (2, False)])
        self.assertEqual(work("--to", "0:06"), [(1, False), (2, False)])
        self.assertEqual(work("--from", 3.1), [])

    def test_firings_have_times_and_values(self):
        run = self.agent()
        begin = self.answer("firings", run, "begin")["firings"]
        self.assertEqual([(f["t_s"], f["values"]["id"], f["values"]["who"]) for f in begin], [(1.0, "1", "a"), (2.0, "2", "a")])
        self.assertEqual(begin[0]["facts"][1:], ["(job (id 1) (state OPEN) (worker NONE))", "(free a)"])
        self.assertEqual(len(self.answer("firings", run, "MAIN::begin", "--from", 1.5)["firings"]), 1)
        self.assertEqual(self.answer("firings", run, "never")["firings"], [])
        self.assertIn("2.000 s  end  ?now = 2.0 ?id = 1 ?who = a ?until = 2.0\n", self.cxlab("firings", run, "end").stdout)

    def test_globals_and_the_agenda(self):
        run = self.agent("(defmodule MAIN (export ?ALL))\n" + AGENT + "(defmodule SIDE (import MAIN ?ALL))\n(defrule SIDE::wait (declare (salience 5)) (job (id ?id)) => )\n")
        self.assertEqual([self.answer("globals", run, "--at", at)["globals"]["limit"] for at in (1, 2, 6)], [2, 1, 0])
        self.assertIn("?*limit* = 0\n", self.cxlab("globals", run).stdout)
        agenda = self.answer("agenda", run)["agenda"]
        self.assertEqual([(a["module"], a["rule"], a["salience"], len(a["facts"])) for a in agenda], 2 * [("SIDE", "wait", 5, 1)])
        self.assertRegex(self.cxlab("agenda", run).stdout, r"\n     5  SIDE::wait: f-\d+\n     5  SIDE::wait: f-\d+\n$")

    def test_rules_that_fired_waited_in_vain_or_never_matched(self):
        run = self.agent()
        rules = {r["rule"]: r for r in self.answer("rules", run)["rules"]}
        self.assertEqual([rules[r]["fired"] for r in ("begin", "end", "never", "robbed")], [2, 2, 0, 0])
        # At 1 s both jobs wait for the worker, at 2 s one of them.
        self.assertEqual((rules["begin"]["activated"], rules["robbed"]["activated"]), (2 + 1, 2 + 1))
        self.assertEqual(rules["end"]["last_s"], 3.0)
        self.assertEqual(rules["never"]["unmet"]["condition"], 1)
        self.assertIn("state is DONE, not LOST", rules["never"]["unmet"]["because"])
        text = self.cxlab("rules", run).stdout
        self.assertRegex(text, r"on the agenda, but never fired:\n  robbed \(mine/mine.clp:22\): 3 times\n")
        self.assertRegex(text, r"never on the agenda, with what they lack now:\n  never \(mine/mine.clp:21\)\n    condition 1: ")

    def test_why_follows_a_fact_to_the_start(self):
        run = self.agent()
        steps = self.answer("why", run, "(job (id 2))")["steps"]
        self.assertEqual((steps[0]["kind"], steps[0]["text"]), ("modify", "(job (id 2) (state DONE) (worker a))"))
        rules = [s["text"] for s in steps if s["kind"] == "fire"]
        self.assertEqual(rules[:2], ["end", "begin"])
        self.assertEqual(steps[1]["values"], {"now": "3.0", "id": "2", "who": "a", "until": "3.0"})
        text = self.cxlab("why", run, "(job (id 2))").stdout
        self.assertRegex(text, r"└─ rule end \(mine/mine.clp:12\) at 3.000 s  \?now = 3.0 \?id = 2 \?who = a \?until = 3.0\n")
        self.assertRegex(text, r"├─ \(work 2 a 3.0\)  asserted at 2.000 s\n.*└─ rule begin \(mine/mine.clp:4\) at 2.000 s")
        # A rule that stands above is not followed again, and each fact says who made it.
        self.assertRegex(text, r"\(free a\)  asserted at 2.000 s by rule end\n")
        whole = self.cxlab("why", run, "(job (id 2))", "--whole").stdout
        self.assertGreater(whole.count("\n"), text.count("\n"))
        self.assertIn("(free a)  asserted at 0.000 s, by the start of the environment", whole)
        # Each firing once, with its place; a fact names the firing that made it.
        rows = {int(n): (t, rule, rest) for n, t, rule, rest in
                re.findall(r"^ +(\d+)  ([0-9.]+) s  ([a-z-]+)(.*(?:\n {9}.*)*)", whole, re.M)}
        fired = [(f"{s['t_s']:.3f}", s["text"]) for s in sorted(steps, key=lambda s: -s["n"]) if s["kind"] == "fire"]
        self.assertEqual([row[:2] for row in rows.values()], fired)
        self.assertEqual(list(rows), list(range(1, len(fired) + 1)))
        self.assertEqual(rows[1][2], " (mine/mine.clp:12)  ?now = 3.0 ?id = 2 ?who = a ?until = 3.0\n         from time; work 2; job 2")
        self.assertIn("(job (id 2) (state DONE) (worker a))  changed at 3.000 s, by 1\n", whole)

    def test_the_whole_of_a_long_story_is_one_that_a_person_can_read(self):
        run = self.agent("""(deftemplate job (slot id) (slot state (default OPEN)))
(deffacts start (count 0) (job (id 1)))
(defrule count (time ?now) ?c <- (count ?n&:(< ?n ?now)) => (retract ?c) (assert (count (+ ?n 0.5))))
(defrule done (count 10.0) ?j <- (job (state OPEN)) => (modify ?j (state DONE)))
""", until=12)
        steps = self.answer("why", run, "(job)")["steps"]
        whole = self.cxlab("why", run, "(job)", "--whole").stdout
        counted = [s for s in steps if s["text"] == "count"]
        self.assertEqual(len(counted), 20)
        self.assertIn("    2  10.000 s  count (mine/mine.clp:3) 19 times since 1.000 s, each time after the time before\n         from time; count 3\n", whole)
        self.assertRegex(whole, r"\n    3  0.500 s  count  \?now = 0.5 .*\n         from time; count\n")
        self.assertRegex(whole, r"20 facts of time, by the executive or a plugin, the first \(time [0-9.]+\) at")
        self.assertIn("(job (id 1) (state OPEN))  asserted at 0.000 s, by the start of the environment", whole)
        self.assertLess(whole.count("\n"), 20)

    def test_why_of_a_retracted_fact_and_of_a_firing(self):
        run = self.agent()
        gone = self.answer("why", run, "(work 1 a 2.0)")["steps"][0]
        self.assertEqual((gone["kind"], gone["t_s"]), ("retract", 2.0))
        self.assertEqual(self.answer("why", run, "begin", "--at", 1.5)["steps"][0]["values"]["id"], "1")
        self.assertIn("has not fired up to then", self.cxlab("why", run, "end", "--at", 1.5, expect=1).stderr)
        picture = self.cxlab("why", run, "(job (id 2))", "--svg").stdout
        self.assertTrue(picture.startswith("<svg ") and picture.endswith("</svg>\n"))
        self.assertIn("rule end (mine/mine.clp:12) at 3.000 s", picture)

    def test_what_does_not_exist_is_named_with_the_nearest(self):
        run = self.agent()
        for arguments, said in ((["facts", run, "jop"], "there is no template 'jop', did you mean 'job'"),
                                (["facts", run, "(job (stat OPEN))"], "has no slot 'stat', did you mean 'state'"),
                                (["facts", run, "f-99"], "there is no fact f-99"),
                                (["facts", run, "fre"], "there is no template 'fre', did you mean 'free'"),
                                (["facts", run, '(job (state "DONE"))'], 'state holds DONE, which is not "DONE" to CLIPS'),
                                (["facts", run, "(job"], "error:"),
                                (["firings", run, "bigin"], "there is no rule 'bigin', did you mean 'begin'"),
                                (["why", run, "bigin"], "there is neither a rule nor a template 'bigin', did you mean 'begin'"),
                                (["agenda", run, "--env", "mian"], "has no environment 'mian'; it has main; did you mean 'main'?"),
                                (["facts", self.folder / "nowhere"], "there is no folder of a run")):
            self.assertIn(said, self.cxlab(*arguments, expect=3).stderr)
        for arguments, said in ((["facts", run, "--at", 7], "--at: the run ends at 6 s"),
                                (["firings", run, "--to", "0:07"], "--to: the run ends at 6 s"),
                                (["firings", run, "--from", 3, "--to", 2], "--from is after --to"),
                                (["firings", run, "--from", 7], "--from: the run ends at 6.000 s"),
                                (["facts", run, "--at", 1, "--to", 2], "--at excludes --to"),
                                (["facts", run, "--at", "1:60"], "--at: found '1:60'"),
                                (["why", run], "what is required")):
            self.assertIn(said, self.cxlab(*arguments, expect=2).stderr)

    def test_answers_are_the_same_each_time(self):
        run = self.agent()
        for question in (["facts", run, "--changes"], ["firings", run], ["rules", run], ["why", run, "(job (id 2))", "--whole"]):
            self.assertEqual(self.cxlab(*question).stdout, self.cxlab(*question).stdout)


class LinesOfAProgram(Lab):
    """cxlab ask: a line of JSON each way."""

    def lines(self, run, *questions, expect=0):
        text = "".join((q if isinstance(q, str) else json.dumps(q)) + "\n" for q in questions)
        done = subprocess.run([CXLAB, "ask", run], input=text, capture_output=True, text=True, cwd=self.folder, timeout=120)
        self.assertEqual(done.returncode, expect, done.stderr)
        return [json.loads(line) for line in done.stdout.splitlines()]

    def test_each_line_has_its_answer_at_any_time(self):
        run = self.agent()
        times = (2, 1, 6, 0.5, 1)
        said = self.lines(run, *({"ask": "facts", "what": "job", "t": t} for t in times), {"ask": "facts", "what": "job"})
        for t, one in zip((*times, 1), said, strict=True):
            self.assertEqual(one["place"]["t"], t)
            self.assertEqual(one["answer"]["facts"], self.answer("facts", run, "job", "--at", t)["facts"])

    def test_a_question_that_is_wrong_does_not_end_the_others(self):
        said = self.lines(self.agent(), "no JSON", "", '{"ask": "facst"}', {"ask": "why", "what": "begn"}, {"ask": "envs", "t": 7},
                          {"ask": "agenda", "env": "mian"}, {"ask": "envs"})
        self.assertEqual([one.get("status") for one in said], [400, 400, 400, 400, 400, 400, None])
        for one, part in zip(said, ("expected", "expected", "there is no question 'facst'", "begn", "ends at 6 s", "it has main; did you mean 'main'?"), strict=False):
            self.assertIn(part, one["error"])
        self.assertEqual(said[-1]["answer"]["environments"][0]["environment"], "main")

    def test_a_folder_that_is_no_run(self):
        self.assertEqual(self.lines(self.folder, {"ask": "envs"}, expect=3), [])


class WhyNot(Lab):
    """why-not goes on to the rules that could bring about what is missing."""

    def makers(self, run, rule, *more):
        return json.loads(self.cxlab("why-not", run, rule, "--json", *more).stdout)["explanations"][0].get("makers")

    def test_rules_that_can_make_the_missing_fact(self):
        run = self.agent()
        found = self.makers(run, "end", "--at", 0.5)
        self.assertEqual((found["pattern"], found["forbids"]), ("(work ?id ?who ?until&:(>= ?now ?until))", False))
        self.assertEqual([(r["rule"], r["how"], r["fired"], r["place"]) for r in found["rules"]], [("begin", "asserts", 0, "mine/mine.clp:4")])
        self.assertRegex(found["rules"][0]["lacks"], r"^condition 1: .*0.5")
        self.assertNotIn("last_made", found)
        later = self.makers(run, "end")
        self.assertEqual((later["rules"][0]["fired"], later["rules"][0]["last_s"]), (2, 2.0))
        self.assertEqual((later["last_made"]["fact"], later["last_made"]["t_s"], later["last_made"]["by"]), ("(work 2 a 3.0)", 2.0, "rule begin"))
        self.assertEqual((later["then"]["what"], later["then"]["t_s"], later["then"]["by"]), ("retract", 3.0, "rule end"))
        self.assertRegex(self.cxlab("why-not", run, "end").stdout,
                         r"  the last fact that matched \(work .*\):\n    \(work 2 a 3.0\)\n    was asserted at 2.000 s by rule begin, and retracted at 3.000 s by rule end\n"
                         r"  rules that can make such a fact:\n    begin \(mine/mine.clp:4\) asserts it; fired 2 times, the last time at 2.000 s\n")

    def test_a_nearest_fact_that_fails_in_a_test_is_not_said_to_have_matched(self):
        run = self.agent("(deftemplate lamp (slot watts))\n(deffacts lamps (lamp (watts 3)))\n(defrule bright (lamp (watts ?w&:(> ?w 5))) => )")
        said = self.cxlab("why-not", run, "bright").stdout
        self.assertIn("watts is 3, not ?w&:(> ?w 5)", said)
        self.assertIn("the nearest fact was asserted at 0.000 s by the start of the environment", said)
        self.assertIn("no fact has matched", said)

    def test_a_fact_that_fails_in_a_test_has_not_matched_either(self):
        boxes = "(deftemplate box (slot n) (slot weight))\n(deffacts boxes (wanted 1) (box (n 1) (weight 3)) (box (n 2) (weight {})))\n"
        rule = "(deffunction heavy (?w) (> ?w 5))\n(defrule lift (wanted ?n) (box (n ?n) (weight ?w&:(heavy ?w))) => )"
        said = self.cxlab("why-not", self.agent(boxes.format(4) + rule), "lift").stdout
        self.assertIn("no fact has matched (box (n ?n) (weight ?w&:(heavy ?w))) so far", said)
        said = self.cxlab("why-not", self.agent(boxes.format(6) + rule, out="heavier"), "lift").stdout
        self.assertRegex(said, r"the last fact that matched [^:]*:\(heavy \?w\)\)\)[,:]\s+\(box \(n 2\) \(weight 6\)\)")

    def test_a_value_that_no_rule_sets(self):
        run = self.agent()
        found = self.makers(run, "never")
        self.assertEqual(found["rules"], [])
        # begin and end set the state to other values. Both jobs are equally near, so the answer names the one asserted last.
        self.assertEqual((found["nearest_changed"]["by"], found["nearest_changed"]["t_s"]), ("rule end", 2.0))
        self.assertIn("no fact has matched (job (id ?id) (state LOST)) so far\n  no rule makes such a fact\n", self.cxlab("why-not", run, "never").stdout)

    def test_a_rule_that_changes_no_slot_that_is_lacking_is_not_named(self):
        run = self.agent("(deftemplate lamp (slot state (default OFF)) (slot age (default 0)))\n(deffacts lamps (lamp))\n"
                         "(defrule grow ?l <- (lamp (age 0)) => (modify ?l (age 1)))\n"
                         "(defrule switch (never) ?l <- (lamp) => (modify ?l (age 2) (state ON)))\n(defrule use (lamp (state ON) (age ?)) => )")
        self.assertEqual([r["rule"] for r in self.makers(run, "use")["rules"]], ["switch"])

    def test_a_retracted_fact_is_shown_as_it_was_last(self):
        run = self.agent("(deftemplate lamp (slot id) (slot state (default OFF)))\n(defrule make (not (made)) => (assert (made) (lamp (id 1))))\n"
                         "(defrule switch ?l <- (lamp (state OFF)) => (modify ?l (state ON)))\n(defrule break ?l <- (lamp (state ON)) => (retract ?l))")
        self.assertRegex(self.cxlab("why-not", run, "(lamp (id 1))").stdout,
                         r"that matched \(lamp \(id 1\)\):\n    \(lamp \(id 1\) \(state ON\)\)\n    was asserted at .* by rule make, and retracted at .* by rule break\n")
        self.assertRegex(self.cxlab("why", run, "(lamp (id 1))").stdout,
                         r"\(lamp \(id 1\) \(state ON\)\)  asserted at 0.000 s by rule make, retracted at 0.000 s\n")

    def test_a_slot_that_a_rule_sets_to_what_only_the_run_knows(self):
        run = self.agent(AGENT + "(defrule waits (job (state ?s&GONE)) => )\n(defrule may (never) (job (state ?s)) ?j <- (job (id 1)) => (modify ?j (state ?s)))\n")
        self.assertEqual([r["rule"] for r in self.makers(run, "waits")["rules"]], ["may"])

    def test_rules_that_can_take_away_what_forbids(self):
        run = self.agent(AGENT + "(deffunction drop (?f) (retract ?f))\n(defrule free-again (not (job (id 2) (state DONE))) (time ?) => )\n"
                                 "(defrule clean (never) ?j <- (job (id 2)) => (retract ?j))\n")
        found = self.makers(run, "free-again")
        self.assertEqual((found["forbids"], found["nearest_changed"]["by"], found["nearest_changed"]["t_s"]), (True, "rule end", 3.0))
        self.assertIn(("clean", "retracts"), [(r["rule"], r["how"]) for r in found["rules"]])
        self.assertNotIn("never", [r["rule"] for r in found["rules"]])

    def test_through_a_function(self):
        run = self.agent("(deffunction make (?x) (assert (made ?x)))\n(defrule go (wanted ?x) => (make ?x))\n(defrule use (made ?x) => )")
        self.assertEqual([(r["rule"], r["through"]) for r in self.makers(run, "use")["rules"]], [("go", "make")])


class TimeTravel(Lab):
    """cxlab attach on a run that is over."""

    def travel(self, run, *commands, expect=0):
        return self.cxlab("attach", run, *(word for c in commands for word in ("-c", c)), expect=expect).stdout.splitlines()

    def test_back_and_forth_gives_the_same_moments(self):
        run = self.agent()
        there = self.travel(run, "where", "at 1", "facts job", "until end", "facts job", "at 1", "facts job", "until 5:00", "where")
        self.assertEqual(there[0], "at the end of the run, 6.000 s")
        self.assertEqual(there[1], "at: main at 1.000 s, at the beginning of a tick")
        self.assertEqual(there[2:4], there[8:10] if there[7].startswith("at: main at 1.000 s") else there[-1])
        self.assertRegex(there[4], r"^end: main at 2.000 s, before rule end fires for f-\d+ f-\d+ f-\d+$")
        self.assertIn("(job (id 1) (state BUSY) (worker a))", " ".join(there[5:7]))
        self.assertEqual(there[-1], "at the end of the run, 6.000 s")

    def test_back_is_the_inverse_of_step(self):
        run = self.agent()
        for begin in ("at 2", "at 3.5", "until begin"):
            at = ["at 0", begin] if begin.startswith("until") else [begin]
            there = self.travel(run, *at, "step", "step", "where", "back", "where", "step", "where", "back 2", "step 2", "where")
            places = [line for line in there if line.startswith("main at ")]
            self.assertEqual(places[0], places[2])
            self.assertEqual(places[0], places[3])
            self.assertNotEqual(places[0], places[1])

    def test_to_go_back_often_is_to_go_back_far(self):
        """Where one is comes from what was recorded; `agenda` plays the rules up to there, and `where` says the same."""
        run = self.agent()
        steps = self.travel(run, "back", "back", "back", "back", "back-until begin", "back", "at 1", "back")
        self.assertEqual(len(set(steps)), 8)
        for n in range(1, 5):
            far = self.travel(run, f"back {n}", "where", "agenda", "where", "globals")
            near = self.travel(run, *["back"] * n, "where", "agenda", "where", "globals")
            self.assertEqual(far[0], steps[n - 1])
            self.assertEqual(near[:n], steps[:n])
            self.assertEqual(near[n:], far[1:])
            self.assertEqual("at: " + far[1], far[0])
            self.assertEqual([line for line in far if line.startswith("main at ")], [far[1]] * 2)
        last = self.travel(run, *["back"] * 4, "back-until begin", "back", "at 1", "back", "agenda", "where", "step", "where")
        self.assertEqual(last[:8], steps)
        self.assertIn(steps[-1].removeprefix("at: "), last[8:])
        played = self.travel(run, *[word for _ in range(4) for word in ("back", "agenda")], "where")
        self.assertEqual(played[-1], steps[3].removeprefix("at: "))

    def test_back_until_finds_who_did_it_last(self):
        run = self.agent()
        there = self.travel(run, "back-until (job (id 1) (state DONE))", "facts (job (id 1))", "step", "facts (job (id 1))",
                            "back-until begin", "why-not end")
        self.assertIn("at 2.000 s, before rule end ", there[0])
        self.assertIn("BUSY", there[1])
        self.assertIn("DONE", there[3])
        self.assertIn("at 1.000 s, before rule begin ", there[4])
        self.assertIn("begin did not fire before", self.cxlab("attach", run, "-c", "back-until begin", "-c", "back-until begin",
                                                              "-c", "back-until begin", expect=1).stderr)

    def test_what_is_evaluated_changes_nothing(self):
        run = self.agent()
        there = self.travel(run, "at 1", "facts job", "(modify 1 (state LOST))", "(bind ?*limit* 9)", "globals", "facts job", "step",
                            "where", "(+ 1 ?*limit*)", "until 2", "where")
        self.assertEqual(there[1:3], [line for line in there if line.startswith("f-")][-2:])
        self.assertIn("?*limit* = 2", there)
        self.assertIn("3", there)
        self.assertIn("main at 2.000 s, at the beginning of a tick", there)
        self.assertEqual(self.cxlab("replay", run).returncode, 0)

    def test_questions_on_the_way(self):
        run = self.agent()
        there = self.travel(run, "at 2.5", "firings", "changes (job (id 1))", "why (job (id 1))")
        self.assertTrue(any(re.match(r" +1.000 s  begin  .*\?id = 1", line) for line in there))
        self.assertFalse(any("3.000 s" in line and "begin" in line for line in there))
        self.assertTrue(any(line.startswith("└─ rule end") for line in there))

    def test_wrong_commands_say_what_is_wrong(self):
        run = self.agent()
        for command, said in (("at x", "found 'x', expected a time"), ("at 7", "the run ends at 6 s"), ("back 0", "expected a number from 1"),
                              ("back 999", "no rule fired before that often"), ("back-until bigin", "did you mean 'begin'"),
                              ("back-until (jop)", "there is no template 'jop'"), ("back-until (free z)", "was not made before"),
                              ("continue", "this is the end of the run"), ("step", "this is the end of the run")):
            self.assertIn(said, self.cxlab("attach", run, "-c", command, expect=1).stderr, command)


class TwoRuns(Lab):
    def test_the_same_runs_have_no_difference(self):
        a, b = self.agent(), self.agent(out="other")
        self.assertEqual(self.cxlab("diff", a, b).stdout, "all that rules did up to 6.000 s is the same\n")
        self.assertEqual(self.cxlab("rules", a, "--against", b).stdout, "up to 6.000 s, in both runs:\nthe same rules fired in both runs\n")

    def test_what_comes_after_the_end_of_the_shorter_run_is_no_difference(self):
        a, longer = self.agent(until=1.5), self.agent(out="longer")
        for runs in ((a, "--against", longer), (longer, "--against", a)):
            found = json.loads(self.cxlab("rules", *runs, "--json").stdout)
            self.assertEqual((found["at_s"], found["environments"][0]["only_in_a"], found["environments"][0]["only_in_b"]), (1.5, [], []))

    def test_runs_without_an_environment_in_common_cannot_be_compared(self):
        a, b = self.agent(), self.agent(out="other", name="second")
        self.assertIn("no environment in common", self.cxlab("diff", a, b, expect=3).stderr)
        self.assertIn("a has main, b has second", self.cxlab("rules", a, "--against", b, expect=3).stderr)
        both = self.agent(out="both", name='main", "second')
        found = json.loads(self.cxlab("diff", a, both, "--json", expect=1).stdout)
        self.assertEqual((found["only_in_a"], found["only_in_b"], found["first"]), ([], ["second"], None))
        self.assertIn("environment second is only in b\n", self.cxlab("diff", a, both, expect=1).stdout)

    def test_diff_names_the_changed_rule_or_its_first_consequence(self):
        a = self.agent()
        changes = [("begin", ">= ?now 1)", ">= ?now 1.5)", 1.0, "condition 1"), ("end", "(state DONE))", "(state GONE))", 2.0, ""),
                   ("end", ">= ?now ?until", "> ?now ?until", 2.0, "condition 2"), ("begin", "(free ?who)\n", "(free ?who&~a)\n", 1.0, "condition 3"),
                   ("begin", "(+ ?now 1)", "(+ ?now 2)", 1.0, ""),
                   ("begin", "(retract ?f)", "", 1.0, "")]
        for i, (rule, old, new, at, said) in enumerate(changes):
            self.assertIn(old, AGENT)
            b = self.agent(AGENT.replace(old, new, 1), out=f"changed{i}")
            found = json.loads(self.cxlab("diff", a, b, "--json", expect=1).stdout)
            self.assertEqual([(c["kind"], c["name"]) for c in found["constructs"]], [("defrule", rule)], rule)
            first = found["first"]
            self.assertEqual((first["environment"], first["t_s"]), ("main", at), rule)
            self.assertNotEqual((first["a"]["what"], first["a"].get("remark")), (first["b"]["what"], first["b"].get("remark")))
            names = json.dumps([first["a"], first["b"]])
            self.assertIn(rule, names)
            self.assertIn(said, names)
            self.assertNotIn("there is no rule", names)  # a fact is no rule

    def test_diff_pairs_facts_of_one_rule(self):
        """In b the rule says why before it chooses: its choice is what differs, not the reason."""
        rules = """(deftemplate choice (slot order))
(deffunction choose () (bind ?best 0) (if (> ?best 0) then (retract (assert (reason ?best)))) (assert (choice (order ?best))))
(defrule choose (time ?now&:(>= ?now 1)) (not (choice)) => (choose))
"""
        a, b = self.agent(rules), self.agent(rules.replace("?best 0) (if", "?best 4) (if"), out="other")
        found = json.loads(self.cxlab("diff", a, b, "--json", expect=1).stdout)["first"]
        self.assertEqual(found["t_s"], 1.0)
        self.assertIn("(choice (order 0))", found["a"]["what"])
        self.assertIn("(choice (order 4))", found["b"]["what"])

    def test_a_rule_that_no_longer_fires_lacks_something_for_the_values_with_which_it_fired(self):
        for i, facts in enumerate(("(job 1 2) (job 2 90) (job 3 1)", "(job 3 1) (job 2 90) (job 1 2)")):
            rules = f"""(deffacts jobs {facts})
(defrule take (job ?id ?end) (time ?now&:(>= ?now 4)&:(< ?now ?end)) (not (taken ?id)) => (assert (taken ?id)))
"""
            a = self.agent(rules, out=f"a{i}")
            b = self.agent(rules.replace("(< ?now ?end)", "(< (+ ?now 99) ?end)"), out=f"b{i}")
            found = json.loads(self.cxlab("diff", a, b, "--json", expect=1).stdout)["first"]
            self.assertIn("?id = 2 ?end = 90", found["a"]["what"])
            self.assertRegex(found["b"]["remark"], r"rule take did not fire: condition 2 does not hold: .*\?end = 90")

    def test_a_change_that_changes_nothing_is_named_and_no_difference(self):
        a, b = self.agent(), self.agent(AGENT.replace("(lost ?id)", "(gone ?id)"), out="other")
        found = json.loads(self.cxlab("diff", a, b, "--json").stdout)
        self.assertEqual((found["same"], [c["name"] for c in found["constructs"]]), (True, ["never"]))

    def test_what_came_of_it(self):
        a, b = self.agent(), self.agent(AGENT.replace("(declare (salience -1))", "(declare (salience 1))"), out="robbed")
        found = self.cxlab("diff", a, b, expect=1).stdout
        self.assertRegex(found, r"^defrule robbed is written differently: mine/mine.clp:22 \(a\), mine/mine.clp:22 \(b\)\n"
                                r"the same before 1.000 s; what differs first, in main:\na: rule begin .*\n")
        self.assertIn("\nb: rule robbed", found)
        # What each did, then what led to it.
        order = [found.index(part) for part in ("\na: rule begin", "\nb: rule robbed", "\nwhat led to it in a:\nrule begin", "\nwhat led to it in b:\nrule robbed")]
        self.assertEqual(order, sorted(order))
        self.assertNotIn("─", found[:order[2]])
        self.assertEqual(self.answer("rules", a, "--against", b), {
            "environment": "main", "only_in_a": [], "only_in_b": [{"rule": "robbed", "fired": 3, "exists_in_other": True}]})
        longer = self.agent(until=8, out="longer")
        found = json.loads(self.cxlab("diff", a, longer, "--json", expect=1).stdout)
        self.assertEqual((found["first"], found["compared_s"]), (None, 6.0))
        self.assertEqual([(o["a"], o["b"]) for o in found["outcomes"] if o["path"] == "sim_time_s"], [(6.0, 8.0)])
        paths = [o["path"] for o in found["outcomes"]]
        self.assertCountEqual(paths, set(paths), "each has one line")
        self.assertGreater(len(paths), 1)

    def test_wrong_runs(self):
        a = self.agent()
        self.assertIn("there is no folder of a run", self.cxlab("diff", a, "nowhere", expect=3).stderr)
        self.assertIn("required", self.cxlab("diff", a, expect=2).stderr)
        self.assertIn("there is no folder of a run", self.cxlab("rules", a, "--against", "nowhere", expect=3).stderr)
        (self.folder / "run/inputs.bin").write_bytes(b"nothing")
        self.assertIn("inputs.bin: expected an input log", self.cxlab("diff", a, a, expect=3).stderr)
        (self.folder / "run/inputs.bin").unlink()
        self.assertIn("inputs.bin: there is no such file", self.cxlab("facts", a, expect=3).stderr)

    def test_a_run_that_failed_says_so_first(self):
        run = self.agent("(defrule loop (time ?) => (while TRUE do (bind ?x 1)))", expect=4, more=["--steps", 10000])
        for question in (["facts", run], ["why-not", run, "loop"], ["diff", run, run]):
            self.assertRegex(self.cxlab(*question).stderr, r"^note: the run failed at 0\.\d{3} s: .*loop", question)


class WhyNotOfAFact(Lab):
    """Where something has stopped and nobody knows which rule should go on."""

    def ask(self, run, what, *more):
        return self.answer("why-not", run, what, *more)

    def test_rules_that_wait_for_a_fact_and_what_they_lack_with_it(self):
        run = self.agent()
        found = self.ask(run, "(job (id 2))", "--at", 1)
        self.assertEqual(found["text"], "(job (id 2) (state OPEN) (worker NONE))")
        waiting = {r["rule"]: r for r in found["waiting"]}
        # begin has fired at that time, for the other job: it took the only worker.
        self.assertEqual(set(waiting), {"begin", "robbed"})
        self.assertEqual(waiting["begin"]["fired"], 0)
        self.assertIn("(free ?who)", waiting["begin"]["lacks"])
        self.assertEqual([(r["rule"], r["differs"]) for r in found["nearly"]], [("end", "state is OPEN, not BUSY"), ("never", "state is OPEN, not LOST")])
        busy = self.ask(run, "(job (id 1))", "--at", 1)
        self.assertRegex({r["rule"]: r for r in busy["waiting"]}["end"]["lacks"], "^condition 2: .*until")

    def test_a_firing_counts_for_the_fact_as_it_is(self):
        run = self.agent(AGENT + "(defrule look (job (id ?id) (state DONE)) (time ?t&:(>= ?t 4)) => )\n")
        users = {r["rule"]: r for r in self.ask(run, "(job (id 1))")["waiting"]}
        self.assertGreater(users["look"]["fired"], 1)
        self.assertEqual(users["look"]["last_s"], 6.0)
        self.assertNotIn("end", users)

    def test_rules_that_must_not_have_it(self):
        run = self.agent(AGENT + "(defrule quiet (not (job (id ?id) (state DONE))) (never) => )\n(defrule all (forall (job (id ?id)) (work ?id $?)) => )\n")
        found = self.ask(run, "(job (id 1))")
        self.assertIn(("quiet", "(job (id ?id) (state DONE))"), [(r["rule"], r["condition"]) for r in found["forbidden"]])

    def test_a_missing_fact_goes_on_to_its_makers(self):
        run = self.agent()
        found = self.ask(run, "(job (id 1) (state BUSY))")
        self.assertNotIn("fact", found)
        self.assertEqual(found["nearest"], "(job (id 1) (state DONE) (worker a)): state is DONE, not BUSY")
        self.assertEqual([r["rule"] for r in found["makers"]["rules"]], ["begin"])
        text = self.cxlab("why-not", run, "(work 1 a ?)").stdout
        self.assertIn("no fact matches it now\n", text)
        self.assertIn("was asserted at 1.000 s by rule begin, and retracted at 2.000 s by rule end", text)

    def test_rules_that_change_other_facts_only_come_last(self):
        run = self.agent("""(deftemplate lamp (slot state))
(deftemplate door (slot state))
(deffacts house (lamp (state OFF)) (blinks 0) (key OPEN))
(deffunction becomes (?fact ?state) (modify ?fact (state ?state)))
(defrule blink (time ?) ?b <- (blinks ?n&:(< ?n 9)) ?lamp <- (lamp) => (retract ?b) (becomes ?lamp ?n) (assert (blinks (+ ?n 1))))
(defrule open (time ?now&:(< ?now 1)) (key ?state) (not (door)) => (assert (door (state ?state))))
(defrule lock (lock-it) ?door <- (door) => (becomes ?door LOCKED))
""")
        makers = self.ask(run, "(door (state LOCKED))")["makers"]["rules"]
        self.assertEqual([(r["rule"], r["fired"]) for r in makers], [("open", 1), ("lock", 0), ("blink", 9)])

    def test_by_index_in_a_terminal_and_wrong_ones(self):
        run = self.agent()
        index = self.answer("facts", run, "(job (id 2))")["facts"][0]["fact"]
        self.assertEqual(self.ask(run, index)["fact"], index)
        there = self.cxlab("attach", run, "-c", "at 1.5", "-c", "why-not (job (id 1))").stdout
        self.assertRegex(there, r"end \(mine/mine.clp:12\) has not fired for it(?: since then)?\n +lacks condition 1: \(time")
        for what, code, said in (("(jop)", 3, "did you mean 'job'"), ("f-999", 3, "there is no fact f-999"), ("(job (id 1)", 3, "error:")):
            self.assertIn(said, self.cxlab("why-not", run, what, expect=code).stderr)
        self.assertIn("--where asks about a rule", self.cxlab("why-not", run, "(job)", "--where", "id=1", expect=2).stderr)


class Layout(unittest.TestCase):
    """Lines of a real game for people, at 100 columns."""

    def test_no_line_is_wide(self):
        folder = Path(tempfile.mkdtemp(prefix="cxlab-layout-"))
        self.addCleanup(shutil.rmtree, folder)

        def cxlab(*arguments, expect=0):
            done = subprocess.run([CXLAB, *map(str, arguments)], capture_output=True, text=True, timeout=120)
            self.assertEqual(done.returncode, expect, f"cxlab {arguments}\n{done.stdout[-2000:]}\n{done.stderr}")
            return done.stdout
        a, b = folder / "a", folder / "b"
        for run, seed in ((a, 1), (b, 2)):
            cxlab("run", GAME, "--tier", "timed", "--until", 320, "--seed", seed, "--quiet", "--out", run)
        for expect, *question in (
                (0, "why-not", a, "order-begin"), (0, "why-not", a, "product-put", "--at", 200), (0, "why-not", a, "(product (order 2))", "--at", 60),
                (0, "why-not", a, "(delivered ? SUCCEEDED)"), (0, "rules", a), (1, "diff", a, b), (0, "why", a, "order-begin"), (0, "why", a, "(order (id 2))"),
                (0, "why", a, "(product)", "--whole"), (0, "why", a, "order-begin", "--whole")):
            with self.subTest(question):
                text = cxlab(*question, expect=expect)
                self.assertGreater(text.count("\n"), 5)
                for line in text.splitlines():
                    # Below many causes there are at least 40 columns.
                    depth = len(line) - len(line.lstrip(" │├└─"))
                    self.assertLessEqual(len(line), max(100, depth + 3 + 40), line)
        self.assertLess(cxlab("why", a, "(product)", "--whole").count("\n"), 1500)

    def test_where_is_repeated(self):
        folder = Path(tempfile.mkdtemp(prefix="cxlab-layout-"))
        self.addCleanup(shutil.rmtree, folder)
        subprocess.run([CXLAB, "run", GAME, "--tier", "timed", "--until", "60", "--quiet", "--out", folder / "a"], capture_output=True, timeout=60, check=True)
        asked = subprocess.run([CXLAB, "why-not", folder / "a", "product-put", "--where", "id=5", "--where", "?next=x"], capture_output=True, text=True, timeout=60)
        self.assertRegex(asked.stdout, r"^after the tick at 60.000 s, the last one; --at T asks about another time:\nproduct-put \(rcll_agent/clips/products.clp:\d+\) in agent, where \?id = 5 and \?next = x\n")


class WhileItIsPlayed(Lab):
    def test_questions_on_the_folder_of_a_run_that_is_still_being_played(self):
        out = self.folder / "game"
        game = stopped_run(self, GAME, "--tier", "timed", "--until", "60", out=out)
        # The log reaches its file in pieces: what is there is answered.
        self.cxlab("attach", out, "-c", "until 30", "-c", "where")
        found = json.loads(self.cxlab("facts", out, "machine", "--json").stdout)
        self.assertLessEqual(found["at_s"], 30)
        self.assertGreater(found["at_s"], 5)
        self.assertTrue(found["environments"][0]["facts"])
        for question in ("facts", "agenda", "scene", "orders"):
            with self.subTest(question):
                asked = self.cxlab(question, out).stdout.splitlines()[0]
                self.assertIn("of the run is cut off (it is still being played, or was killed):", asked)
                self.assertTrue(json.loads(self.cxlab(question, out, "--json").stdout)["cut_off"])
                self.assertNotIn("cut off", self.cxlab(question, out, "--at", 1).stdout)
        for question in (("why-not", out, "order-begin"), ("profile", out)):
            self.assertIn("still being played", self.cxlab(*question).stdout.splitlines()[0])
        for question, *words in (("facts", "machine", "--at"), ("agenda", "--at"), ("rules", "--at"), ("firings", "--to"), ("why", "(machine)", "--at"), ("why-not", "order-begin", "--at"),
                                 ("profile", "--at"), ("scene", "--at"), ("orders", "--at"), ("export", "--csv", "--to")):
            with self.subTest(question):
                late = self.cxlab(question, out, *words, 1e6, expect=2).stderr
                said = re.search(words[-1] + r": the run ends at ([\d.]+) s, where the log of the run is cut off \(it is still being played, or was killed\)", late)
                self.assertTrue(said, late)
                self.assertGreaterEqual(float(said[1]), found["at_s"])
                self.cxlab(question, out, *words, said[1])
        self.cxlab("attach", out, "-c", "continue")
        self.assertEqual(game.wait(), 0)
        self.assertEqual(json.loads(self.cxlab("facts", out, "machine", "--json").stdout)["at_s"], 60)

    def test_a_live_run_and_its_record_give_the_same_answers(self):
        out = self.folder / "game"
        chance = random.Random(35)
        times = sorted({chance.randrange(1, 590) / 10 for _ in range(25)})
        questions = [c for t in times for c in (f"until {t}", "where", "facts", "agenda", "globals", "firings robot-take-job", "why refbox-game-state")]
        game = stopped_run(self, GAME, "--tier", "timed", "--until", "60", out=out)
        ask = lambda commands: self.cxlab("attach", out, "--quiet", *(word for c in commands for word in ("-c", c))).stdout
        live = ask(questions + ["continue"])
        self.assertEqual(game.wait(), 0)
        recorded = ask([c.replace("until", "at") for c in questions])
        answers = lambda text: [line for line in text.splitlines() if not re.match(r"at: |[0-9.]+ s: |the run has ended|at the end", line)]
        self.assertGreater(len(answers(live)), 3000)
        self.assertEqual(answers(live), answers(recorded))

    def test_the_scene_is_the_same_live_recorded_and_by_itself(self):
        out = self.folder / "game"
        game = stopped_run(self, GAME, "--tier", "timed", "--until", "60", out=out)

        def rows(text):
            """Place and the other columns by name."""
            return {row[1]: (tuple(map(float, row[2:6])), row[0], row[6:]) for row in map(str.split, text.splitlines())
                    if len(row) > 6 and row[0] in ("robot", "machine", "piece")}

        def attached(*commands):
            return self.cxlab("attach", out, "--quiet", *(word for c in commands for word in ("-c", c))).stdout

        times = (10, 31.3, 47.7)
        live = {t: attached(f"until {t}", "scene") for t in times}
        attached("continue")
        self.assertEqual(game.wait(), 0)
        for t in times:
            recorded, alone = attached(f"at {t}", "scene"), self.cxlab("scene", out, "--at", t).stdout
            self.assertEqual(recorded.split("\n", 1)[1].replace("scene KIND", "cxlab scene RUN KIND"), alone)
            self.assertIn(f"at 0:{t:04.1f}:\nkind ", live[t])
            self.assertEqual(rows(live[t]).keys(), rows(alone).keys())
            self.assertGreater(len(rows(alone)), 10)
            for name, (place, kind, _) in rows(alone).items():
                self.assertEqual(kind, rows(live[t])[name][1])
                for a, b in zip(place[:3], rows(live[t])[name][0]):
                    self.assertAlmostEqual(a, b, delta=0.05)
        # Back and forth; one of them alone; wrong ones.
        there = attached("at 31.3", "scene robot", "at 10", "scene robot2", "at 31.3", "scene robot").split("at: ")
        self.assertEqual(there[1], there[3])
        self.assertEqual(list(rows(there[2])), ["robot2"])
        wrong = self.cxlab("attach", out, "-c", "scene robots", expect=1).stderr
        self.assertIn("called 'robots' at 1:00.0, did you mean 'robot", wrong)
        self.assertIn("there is no scene.bin", self.cxlab("attach", self.agent(), "-c", "scene", expect=1).stderr)


class AgainstTheJournal(Lab):
    """Answers of the replay against what the game itself wrote."""

    @classmethod
    def setUpClass(cls):
        cls.game = Path(tempfile.mkdtemp(prefix="cxlab-questions-"))
        cls.addClassCleanup(shutil.rmtree, cls.game)
        cls.run_folder = cls.game / "run"
        subprocess.run([CXLAB, "run", GAME, "--tier", "timed", "--until", "240", "--quiet", "--journal", "full", "--out", cls.run_folder],
                       check=True, timeout=300)
        records = map(json.loads, (cls.run_folder / "journal.jsonl").read_text().splitlines())
        cls.records = [r for r in records if r["stream"] == "env/agent"]

    def facts_at(self, nanoseconds):
        facts = {}
        for record in self.records:
            if record["t"] > nanoseconds:
                break
            data = record["data"]
            if record["kind"] in ("assert", "decision"):
                facts[data["fact"]] = (data["template"], dict(data["slots"]))
            elif record["kind"] == "modify":
                facts[data["fact"]][1].update(data["slots"])
            elif record["kind"] == "retract":
                del facts[data["fact"]]
        return facts

    @staticmethod
    def comparable(template, slots):
        def plain(value):
            if isinstance(value, dict):  # a handle, a fact
                return "address"
            if isinstance(value, str) and value.startswith("<"):
                return "address"
            return [plain(v) for v in value] if isinstance(value, list) else value
        return template, json.dumps({name: plain(value) for name, value in slots.items()}, sort_keys=True)

    def test_facts_at_random_moments(self):
        chance = random.Random(11)
        for at in [0] + [chance.randrange(0, 2400) / 10 for _ in range(7)]:
            expected = collections.Counter(self.comparable(*f) for f in self.facts_at(round(at * 1e9)).values())
            found = collections.Counter(self.comparable(f["template"], f["slots"])
                                        for f in self.answer("facts", self.run_folder, "--at", at)["facts"])
            self.assertEqual(found - expected, collections.Counter(), at)
            self.assertEqual(expected - found, collections.Counter(), at)

    def test_firings_are_those_of_the_journal(self):
        found = [(f["n"], f["t_s"], f["rule"]) for f in self.answer("firings", self.run_folder)["firings"]]
        # Without those of the shutdown, after the last tick.
        expected = [(r["n"], r["t"] / 1e9, r["data"]["rule"]) for r in self.records if r["kind"] == "fire"]
        while expected[-1][2].startswith("finalize-"):
            expected.pop()
        self.assertEqual(found, expected)

    def test_why_of_random_facts_has_all_causes_up_to_the_outside(self):
        by_n = {record["n"]: record for record in self.records}
        chance = random.Random(12)
        asserted = [r for r in self.records if r["kind"] == "assert" and r["cause"] and r["t"] > 0]
        for record in chance.sample(asserted, 8):
            steps = self.answer("why", self.run_folder, self.pattern_of(record), "--at", record["t"] / 1e9)["steps"]
            known = {step["n"] for step in steps}
            for step in steps:
                causes = by_n[step["n"]]["cause"]
                own = sorted({int(c.split(":")[1]) for c in causes if c.startswith("env/agent:")}, reverse=True)
                self.assertEqual([steps[i]["n"] for i in step["because"]], own)
                self.assertEqual([c for c in causes if not c.startswith("env/agent:")], [step["outside"]] if "outside" in step else [])
                self.assertTrue(set(own) <= known)

    @staticmethod
    def pattern_of(record):
        slots = record["data"]["slots"]
        if "implied" in slots:
            return f"({record['data']['template']} $?)"
        return f"({record['data']['template']})"


if __name__ == "__main__":
    unittest.main()
