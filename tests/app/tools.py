"""cxlab env, replay, rerun, why-not and render, as a user calls them."""

import json
import os
import random
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from lab import CONFIG, FEW_PICTURES
from pages import RunPage

CXLAB = os.environ["CXLAB"]
SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])
GAME = SOURCE / "scenarios/rcll/game.yaml"
HELLO = SOURCE / "docs/examples/hello"

LOOKER = """
(defrule look
  "Whatever rules can see from outside."
  (time ?t&:(< ?t 1))
  =>
  (bind ?packages (ament-index-get-packages-with-prefixes))
  (open "notes.txt" notes "w")
  (printout notes "draw " (random 1 1000) crlf)
  (close notes)
  (open "notes.txt" notes "r")
  (assert (seen (readline notes) (length$ ?packages) (random 1 1000)))
  (close notes)
  (load* "no-such-file.clp"))
"""


class Tools(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="cxlab-tools-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def cxlab(self, *arguments, expect=0):
        done = subprocess.run([CXLAB, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder, timeout=60, env=os.environ | FEW_PICTURES)
        if expect is not None:
            self.assertEqual(done.returncode, expect, f"cxlab {arguments}\n{done.stdout}\n{done.stderr}")
        return done

    def answer(self, *arguments, expect=0):
        return json.loads(self.cxlab(*arguments, "--json", expect=expect).stdout)

    def timed_game(self, until=200, *more):
        run = self.folder / "game"
        self.cxlab("run", GAME, "--tier", "timed", "--until", until, "--quiet", "--out", run, *more)
        return run

    def physics_game(self, until):
        run = self.folder / "physics"
        self.cxlab("run", GAME, "--until", until, "--quiet", "--out", run)
        return run

    def package(self, rules="", name="mine", plugins='"executive", "index", "files"'):
        folder = self.folder / name
        (folder / "params").mkdir(parents=True)
        (folder / "params/mine.yaml").write_text(f"""
clips_manager:
  ros__parameters:
    environments: ["main"]
    main: {{plugins: [{plugins}]}}
    executive: {{plugin: "cx::ExecutivePlugin", refresh_rate: 2}}
    index: {{plugin: "cx::AmentIndexPlugin"}}
    files: {{plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["{name}"], load: ["mine.clp"]}}
""")
        (folder / "mine.clp").write_text(rules)
        return folder / "params/mine.yaml"

    # --- env

    def test_hello_world_ends_when_its_rules_say_so(self):
        done = self.cxlab("env", HELLO / "hello.yaml", "--out", "none")
        self.assertIn("stopped after 3.000 s", done.stdout)
        self.assertIn("hello, world", done.stderr)
        self.assertIn("60 s of simulated time", done.stderr)

    def test_a_configuration_below_params_finds_its_package(self):
        self.cxlab("env", self.package("(defrule go => (printout t there crlf))"), "--until", 1, "--out", "none")

    def test_broken_rules_are_all_reported_and_the_run_goes_on(self):
        config = self.package('(defrule a => (nosuch))\n(defrule b => (nosuch2))\n(defrule c => (printout info "still here" crlf))')
        done = self.cxlab("env", config, "--until", 1, "--out", "none", expect=3)
        self.assertIn("still here", done.stderr)
        for line in ("mine.clp:1:", "mine.clp:2:"):
            self.assertIn(line, done.stderr)

    def test_what_did_not_load_is_reported_once_in_its_order(self):
        config = self.package("(defrule a => (nosuch))\n(defrule b => (nosuch2))\n(defrule open (x)")
        (config.parent.parent / "more.clp").write_text("(defrule c => (nosuch3))\n")
        text = config.read_text().replace('load: ["mine.clp"]', 'load: ["more.clp", "mine.clp"]').replace('"files"', '"files", "nothing"')
        config.write_text(text)
        done = self.cxlab("env", config, "--until", 1, "--out", "none", expect=3)
        places = re.findall(r"^(?:error: |.*\[error\] \[\w+\] )\S*/(\w+\.\w+:\d+): ", done.stderr, re.MULTILINE)
        self.assertEqual(places, ["more.clp:1", "mine.clp:1", "mine.clp:2", "mine.clp:3", "mine.yaml:5"], done.stderr)

    def test_a_loop_may_be_allowed_to_be_longer(self):
        config = self.package("(deffacts n (n 0))\n(defrule grow ?f <- (n ?n&:(< ?n 3000)) => (retract ?f) (assert (n (+ 1 ?n))))")
        self.cxlab("env", config, "--until", 1, "--out", "none", "--max-firings", 1000, expect=4)
        self.cxlab("env", config, "--until", 1, "--out", "none", "--max-firings", 4000)

    def test_two_servers_of_one_name_are_reported_with_both_owners(self):
        config = self.package('(deffacts go (go))\n(deffunction /door-service-callback (?s ?q ?a))\n'
                              '(defrule r (go) => (ros-msgs-create-service "/door" "std_srvs/srv/SetBool"))', plugins='"executive", "ros_msgs", "files"')
        config.write_text(config.read_text() + '    ros_msgs: {plugin: "cx::RosMsgsPlugin"}\n')
        stimuli = self.folder / "stimuli.yaml"
        stimuli.write_text("- {at: 0.5, serve: /door, type: std_srvs/srv/SetBool}\n")
        done = self.cxlab("env", config, "--until", 1, "--out", "none", "--stimuli", stimuli)
        self.assertIn("[warn] [bus] service '/door' has more than one server: /clips_manager (environment main) answers, /stimuli only once that is gone", done.stderr)

    def test_an_error_in_a_rule_does_not_end_env_unless_asked_to(self):
        config = self.package("(defrule a => (printout t (/ 1 0) crlf))")
        self.cxlab("env", config, "--until", 1, "--out", "none")
        self.cxlab("env", config, "--until", 1, "--out", "none", "--stop-on-rule-error", expect=4)

    def test_parameters_stimuli_and_remaps_reach_the_nodes(self):
        stimuli = self.folder / "stimuli.yaml"
        stimuli.write_text("- {at: 0.5, publish: /other, type: std_msgs/msg/String, data: {data: from outside}}\n")
        config = SOURCE / "docs/examples/ros_msgs/example.yaml"
        self.cxlab("env", config, "--package", f"example={config.parent}", "--until", 1, "--stimuli", stimuli, "--remap", "/a:=/b",
                   "--param", "clips_manager.talker.watch=[facts]", "--out", "none")
        self.cxlab("env", config, "--param", "no value", expect=2)
        stimuli.write_text("- {at: 0.5, shout: /other}\n")
        self.assertIn("stimuli.yaml:1:", self.cxlab("env", config, "--stimuli", stimuli, expect=3).stderr)

    def test_managers_and_environments_come_and_go_at_run_time(self):
        example = SOURCE / "docs/examples/manager"
        done = self.cxlab("env", example / "example.yaml", "--package", f"example={example}", "--stimuli", example / "stimuli.yaml",
                          "--until", 4, "--out", self.folder / "run")
        for line in ("a helper came: TRUE", "helping since 2.1", "FIRE    1 help: ", "the boss goes", "/clips_manager/change_state: response {success: true}"):
            self.assertIn(line, done.stderr)
        self.cxlab("replay", self.folder / "run", "--rules")

    def test_a_manager_goes_through_its_life_when_asked_to(self):
        config = self.package('(defrule go => (printout t "here" crlf))\n(defrule end (executive-finalize) => (printout t "gone" crlf))')
        waits = self.cxlab("env", config, "--until", 1, "--out", "none", "--no-activate")
        self.assertNotIn("here", waits.stderr)
        twice = self.cxlab("env", config, "--until", 2, "--out", "none", "--no-activate", "--transition", "0.2:configure", "--transition", "0.4:activate",
                           "--transition", "0.6:deactivate", "--transition", "0.8:activate@/clips_manager")
        self.assertEqual(twice.stderr.count("] here"), 2)
        self.assertEqual(twice.stderr.count("] gone"), 2)
        self.assertNotIn("here", self.cxlab("env", config, "--until", 1, "--out", "none", "--no-activate", "--param", "clips_manager.autostart_node=false").stderr)
        self.assertIn("here", self.cxlab("env", config, "--until", 1, "--out", "none", "--no-activate", "--param", "clips_manager.autostart_node=true").stderr)
        self.cxlab("env", config, "--transition", "soon:activate", expect=2)
        self.cxlab("env", config, "--transition", "1:jump", expect=2)

    def test_an_unknown_parameter_is_an_error_when_asked_to(self):
        config = self.package("(defrule a =>)")
        config.write_text(config.read_text() + "    executive.refesh_rate: 3\n")
        self.cxlab("env", config, "--until", 1, "--out", "none")
        self.assertIn("refresh_rate", self.cxlab("env", config, "--until", 1, "--out", "none", "--strict-cx", expect=3).stderr)

    def test_a_signal_ends_through_deactivation(self):
        config = self.package('(defrule bye (executive-finalize) => (printout info "bye" crlf))')
        # Ticks of 1 s: the wait for the next one must end, too.
        config.write_text(config.read_text().replace("refresh_rate: 2", "refresh_rate: 1"))
        process = subprocess.Popen([CXLAB, "env", str(config), "--realtime", "--out", "none"], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        for line in process.stderr:
            if "Created plugin: files" in line:
                break
        process.send_signal(signal.SIGTERM)
        self.assertIn("bye", process.stderr.read())
        self.assertEqual(process.wait(), 143)
        process.stderr.close()

    def test_a_pause_names_the_request_that_caused_it(self):
        asks = "{{at: {}, call: /set_game_state, type: rcll_interfaces/srv/SetGameState, request: {{state: {}}}}}"
        run = self.timed_game(9, "--journal", "full", "--set", f"stimuli=[{asks.format(5, 'PAUSED')}, {asks.format(8, 'RUNNING')}]")
        records = [json.loads(line) for line in (run / "journal.jsonl").read_text().splitlines()]
        by_name = {f"{record['stream']}:{record['n']}": record for record in records}
        changes = [record for record in records if record["stream"] == "referee" and record["data"]["event"] == "state"]
        self.assertEqual([record["data"]["state"] for record in changes], ["PAUSED", "RUNNING"])
        for change in changes:
            (cause,) = (by_name[cause] for cause in change["cause"])
            self.assertEqual((cause["stream"], cause["data"]["name"]), ("node/stimuli", "/set_game_state"))

    # --- replay

    def test_rules_of_a_timed_game_replay(self):
        answer = self.answer("replay", self.timed_game())
        self.assertTrue(answer["rules"]["same"])
        self.assertEqual(answer["rules"]["agree"], ["env/agent"])
        self.assertNotIn("physics", answer)
        self.cxlab("replay", self.folder / "game", "--physics", expect=3)

    def test_both_halves_of_a_physics_game_replay(self):
        answer = self.answer("replay", self.physics_game(12))
        self.assertTrue(answer["rules"]["same"])
        self.assertTrue(answer["physics"]["same"])

    def test_physics_whose_log_is_cut_off_replay_up_to_there(self):
        run = self.physics_game(4)
        log = (run / "inputs.bin").read_bytes()
        (run / "inputs.bin").write_bytes(log[:-len(log) // 8])
        said = self.cxlab("replay", run, "--physics", expect=3).stdout
        self.assertRegex(said, r"^physics: replayed up to [1-3]\.\d+ s, where the log ends\n$")

    def test_a_run_replays_when_its_files_are_gone_and_it_has_moved(self):
        config = self.package(LOOKER)
        self.cxlab("env", config, "--until", 2, "--quiet", "--out", self.folder / "run")
        shutil.rmtree(config.parent.parent)
        (self.folder / "run").rename(self.folder / "moved")
        self.assertTrue(self.answer("replay", self.folder / "moved")["rules"]["same"])

    def test_two_agents_that_call_different_folders_by_one_name_replay(self):
        for name, word in (("a", "one"), ("b", "two")):
            self.package(f"(defrule say (time ?t) => (assert ({word} ?t (random 1 99))))", name)
            (self.folder / name / "params/mine.yaml").write_text(
                (self.folder / name / "params/mine.yaml").read_text().replace(f'["{name}"]', '["mine"]').replace("main", name))
        scenario = self.folder / "two.yaml"
        scenario.write_text("schema: 1\nduration_s: 3\nagents:\n"
                            "  - {config: a/params/mine.yaml, namespace: /a, packages: {mine: a}}\n"
                            "  - {config: b/params/mine.yaml, namespace: /b, packages: {mine: b}}\n")
        self.cxlab("run", scenario, "--quiet", "--out", self.folder / "run")
        for name in ("a", "b", "two.yaml"):
            (self.folder / name).rename(self.folder / (name + ".gone"))
        answer = self.answer("replay", self.folder / "run")
        self.assertTrue(answer["rules"]["same"], answer)
        self.assertEqual(len(answer["rules"]["agree"]), 2)

    def test_a_run_that_failed_replays(self):
        config = self.package("(defrule a (time ?t&:(> ?t 1)) => (printout t (/ 1 0) crlf))")
        self.cxlab("env", config, "--quiet", "--out", self.folder / "run", "--stop-on-rule-error", expect=4)
        self.assertTrue(self.answer("replay", self.folder / "run")["rules"]["same"])

    def test_a_damaged_log_is_reported_with_its_place(self):
        run = self.timed_game()
        log = bytearray((run / "inputs.bin").read_bytes())
        log[len(log) // 2] ^= 1
        (run / "inputs.bin").write_bytes(log)
        done = self.cxlab("replay", run, expect=3)
        self.assertRegex(done.stderr, r"inputs\.bin: broken at byte \d+")

    def test_another_recorded_hash_is_a_difference(self):
        run = self.timed_game()
        result = json.loads((run / "result.json").read_text())
        result["stream_hashes"]["env/agent"] = "0" * 32
        (run / "result.json").write_text(json.dumps(result))
        self.assertEqual(self.answer("replay", run, expect=1)["rules"]["differ"], ["env/agent"])

    def test_no_run_and_half_a_run_are_bad_input(self):
        self.cxlab("replay", self.folder / "nowhere", expect=3)
        run = self.timed_game(5)
        (run / "manifest.json").write_text("{}")
        self.assertIn("manifest.json", self.cxlab("replay", run, expect=3).stderr)

    # --- rerun

    def test_a_rerun_gives_the_same_hashes(self):
        run = self.timed_game(100, "--seed", 3)
        answer = self.answer("rerun", run, "--quiet", "--out", self.folder / "again")
        self.assertTrue(answer["same"], answer)

    def test_a_checkout_is_moved_together_with_its_runs(self):
        there, here = self.folder / "there", self.folder / "elsewhere/here"
        config = self.package("(defrule a => (assert (one (ament-index-get-package-share-directory \"mine\"))))")
        there.mkdir()
        shutil.copytree(config.parent.parent, there / "mine")
        (there / "game.yaml").write_text(f"""schema: 1
duration_s: 2
packages: {{mine: mine}}
agents:
  - config: {config.relative_to(config.parent.parent.parent)}
    packages: {{mine: mine}}
""")
        shutil.rmtree(config.parent.parent)
        self.cxlab("run", "there/game.yaml", "--quiet", "--out", "there/runs/1")
        manifest = json.loads((there / "runs/1/manifest.json").read_text())
        self.assertEqual((manifest["folder"], manifest["scenario"], manifest["out"]), ("../../..", "there/game.yaml", str(there / "runs/1")))
        self.assertEqual(manifest["agents"][0]["packages"]["mine"], "mine")
        self.assertEqual((manifest["memory"], manifest["disk"], manifest["steps"]), (2000000000, 5000000000, 500000000))
        asked = self.cxlab("facts", there / "runs/1", "one", "--json").stdout

        def works(run, place):
            self.assertEqual(self.cxlab("facts", run, "one", "--json").stdout, asked)
            self.assertEqual(self.answer("replay", run)["rules"]["differ"], [])
            again = self.cxlab("rerun", run, "--out", self.folder / "again", "--force", expect=None)
            self.assertNotIn("are missing", again.stderr)
            self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
            played = json.loads((self.folder / "again/manifest.json").read_text())
            self.assertEqual(os.path.normpath(os.path.join(*(played[key] for key in ("out", "folder", "scenario")))), str(place / "game.yaml"))

        works(there / "runs/1", there)
        shutil.copytree(there / "runs/1", self.folder / "run")  # the checkout stays where it was
        works(self.folder / "run", there)
        here.parent.mkdir()
        there.rename(here)
        works(here / "runs/1", here)
        # The run alone: neither place has the files.
        shutil.move(here / "runs/1", self.folder / "alone")
        shutil.rmtree(here)
        self.assertEqual(self.cxlab("facts", "alone", "one", "--json").stdout, asked)
        self.assertIn("are missing", self.cxlab("rerun", "alone", "--out", self.folder / "last").stderr)
        # A manifest of before names all absolutely.
        old = json.loads((self.folder / "alone/manifest.json").read_text())
        old["folder"], old["agents"][0]["packages"] = str(self.folder), {n: str(there / p) for n, p in old["agents"][0]["packages"].items()}
        for key in ("memory", "disk", "steps"):
            del old[key]
        (self.folder / "alone/manifest.json").write_text(json.dumps(old))
        self.assertEqual(self.cxlab("facts", "alone", "one", "--json").stdout, asked)
        self.assertEqual(self.answer("replay", "alone")["rules"]["differ"], [])

    def test_a_rerun_with_other_rules_says_which_streams_differ(self):
        config = self.package("(defrule a => (assert (one)))")
        self.cxlab("env", config, "--until", 1, "--quiet", "--out", self.folder / "run")
        (config.parent.parent / "mine.clp").write_text("(defrule a => (assert (two)))")
        again = self.answer("rerun", self.folder / "run", "--quiet", "--out", self.folder / "again", expect=1)
        self.assertEqual(again["differ"], ["env/main"])
        self.assertEqual([name.rsplit("/", 1)[1] for name in again["changed_files"]], ["mine.clp"])
        self.assertEqual(again["changed_surroundings"], [])

    def test_where_hashes_differ_the_machine_of_then_is_named(self):
        run = self.timed_game(20)
        for name, change in {"result.json": lambda json: json["stream_hashes"].update({"env/agent": "0"}),
                             "manifest.json": lambda json: json["machine"].update({"C library": "glibc 0.1"})}.items():
            content = json.loads((run / name).read_text())
            change(content)
            (run / name).write_text(json.dumps(content))
        for command in [["rerun", run, "--out", self.folder / "again"], ["replay", run]]:
            printed = self.cxlab(*command, expect=1).stdout
            self.assertRegex(printed, r"\n  not as in the run: C library: glibc 0.1, now glibc [0-9.]+\n")
            self.assertNotIn("digest", printed)

    def test_the_machine_is_known_by_what_its_functions_return(self):
        run = self.timed_game(20)
        known = json.loads((run / "manifest.json").read_text())["machine"]
        self.assertEqual(sorted(known), ["C library", "architecture", "digest of sin, cos, pow"])
        self.assertEqual(known["architecture"], os.uname().machine)
        self.assertRegex(known["digest of sin, cos, pow"], "^[0-9a-f]{32}$")

    # --- why-not

    def test_why_not_names_who_took_an_activation_off_the_agenda(self):
        config = self.package("""
(deffacts jobs (job 1) (job 2) (job 3))
(defrule work (job ?n) (not (closed)) => (assert (done ?n)))
(defrule thief (declare (salience 5)) ?j <- (job 2) => (retract ?j))
(defrule close (declare (salience -1)) (done 3) => (assert (closed)))
(defrule lazy (declare (salience -2)) (job ?n) (not (closed)) => (assert (late ?n)))
(defrule free (declare (salience 9)) (job 1) => )
""")
        run = self.folder / "run"
        self.cxlab("env", config, "--until", 1, "--quiet", "--out", run)
        lazy = self.answer("why-not", run, "lazy")["explanations"][0]
        self.assertEqual(lazy["lost"], {"t_s": 0.0, "facts": ["(job 1)"], "by": "close"})
        self.assertIn("  was on the agenda up to 0.000 s, until rule close took it off, with\n    (job 1)\n",
                      self.cxlab("why-not", run, "lazy").stdout)
        work = self.answer("why-not", run, "work", "--where", "n=2")["explanations"][0]
        self.assertEqual(work["fired"], 2)
        for fired in ["free", "thief", "close"]:
            self.assertNotIn("lost", self.answer("why-not", run, fired)["explanations"][0], fired)

    def test_why_not_says_why_a_rule_was_not_loaded(self):
        config = self.package("(defrule fine => )\n(defrule bad (job (x ?y)) => (prin ?z))")
        run = self.folder / "run"
        self.cxlab("env", config, "--until", 1, "--quiet", "--out", run, expect=3)
        self.assertRegex(self.cxlab("why-not", run, "bad", expect=3).stderr,
                         r"(?m)^error: .*mine.clp:2: rule 'bad' was not loaded: .*Syntax Error")
        self.assertIn("did you mean 'fine'?", self.cxlab("why-not", run, "fin", expect=3).stderr)

    def test_why_not_says_where_the_run_ends_and_which_alternative_it_shows(self):
        config = self.package("(deffacts d (b 1))(defrule either (or (a) (and (b ?x) (c ?x)) (d)) => )")
        run = self.folder / "run"
        self.cxlab("env", config, "--until", 1, "--quiet", "--out", run)
        self.assertIn("--at: the run ends at 1 s", self.cxlab("why-not", run, "either", "--at", 9, expect=2).stderr)
        self.assertIn("after the tick at 1.000 s:\n", self.cxlab("why-not", run, "either", "--at", 1).stdout)
        self.assertIn("none of the 3 alternatives of its or conditions holds; the one that gets furthest:\n  condition 1",
                      self.cxlab("why-not", run, "either").stdout)

    def test_why_not_names_the_condition_the_nearest_fact_and_its_slot(self):
        config = self.package("""
(deftemplate job (slot name) (slot state) (slot size))
(deffacts jobs (job (name far) (state DONE) (size 1)) (job (name near) (state OPEN) (size 2)))
(defrule take (time ?) (job (name ?n) (state OPEN) (size 1)) => (assert (taken ?n)))
(defrule done (job (name far)) => (assert (done)))
(defrule forbidden (not (job (state DONE))) => (assert (never)))
(defrule later (time ?t&:(> ?t 1.2)) => (assert (late)))
""")
        run = self.folder / "run"
        self.cxlab("env", config, "--until", 2, "--quiet", "--out", run)

        def why(rule, *more):
            return self.answer("why-not", run, rule, *more)["explanations"][0]

        take = why("take")
        self.assertEqual((take["verdict"], take["first_unmet"]["condition"], take["fired"]), ("condition", 2, 0))
        self.assertIn("(job (name", take["first_unmet"]["fact"])
        self.assertIn(take["first_unmet"]["slot"], ("state", "size"))
        done = why("done")
        self.assertEqual((done["verdict"], done["fired"], done["last_fired_s"]), ("fired", 1, 0.0))
        self.assertIn("forbids", why("forbidden")["first_unmet"]["because"])
        self.assertEqual(why("later", "--at", 1)["verdict"], "condition")
        self.assertEqual(why("later", "--at", 1)["fired"], 0)
        self.assertGreater(why("later")["fired"], 0)
        self.assertIn("did you mean 'take'", self.cxlab("why-not", run, "tak", expect=3).stderr)
        self.assertIn("condition 2 does not hold", self.cxlab("why-not", run, "take").stdout)

    def test_why_not_of_rules_of_modules_and_for_one_binding(self):
        config = self.package("""
(defmodule MAIN (export ?ALL))
(deftemplate job (slot id) (slot state))
(deffacts jobs (job (id 1) (state OPEN)) (job (id 2) (state DONE)))
(defrule both (time ?) (job (id ?id)) (job (id ?other&~?id) (state ?state)) (test (eq ?state OPEN)) => (assert (done ?id)))
(defmodule A (import MAIN ?ALL))
(defrule A::go (job (id ?id) (state OPEN)) => (assert (a ?id)))
(defmodule B (import MAIN ?ALL))
(defrule B::go (job (id ?id) (state LOST)) => (assert (b ?id)))
(defrule B::first ?f <- (time ?) => (focus A))
""")
        run = self.folder / "run"
        self.cxlab("env", config, "--until", 2, "--quiet", "--out", run)
        found = self.answer("why-not", run, "go")["explanations"]
        self.assertEqual([(e["module"], e["line"], e["verdict"], e["fired"]) for e in found], [("A", 7, "focus", 0), ("B", 9, "condition", 0)])
        self.assertEqual([e["module"] for e in self.answer("why-not", run, "B::go")["explanations"]], ["B"])
        self.assertRegex(self.cxlab("why-not", run, "A::go").stdout, r"its module A is not in focus: the next run looks at\s+MAIN only.*\n  on the agenda of what is in focus:\n    ")
        self.assertIn("did you mean 'A::go'", self.cxlab("why-not", run, "C::go", expect=3).stderr)
        self.assertEqual(self.answer("why-not", run, "both", "--where", "id=2")["explanations"][0]["verdict"], "waiting")
        unmet = self.answer("why-not", run, "both", "--where", "?id=1", "--where", "other=2")["explanations"][0]["first_unmet"]
        self.assertEqual((unmet["condition"], unmet["pattern"], unmet["values"]["state"]), (4, "(test (eq ?state OPEN))", "DONE"))
        self.assertIn("did you mean 'id'", self.cxlab("why-not", run, "both", "--where", "ids=1", expect=3).stderr)
        self.assertIn("expected VARIABLE=VALUE", self.cxlab("why-not", run, "both", "--where", "id", expect=2).stderr)

    def test_why_not_counts_what_fired_below_a_namespace(self):
        config = self.package("(defrule go => (assert (gone)))")
        run = self.folder / "run"
        self.cxlab("env", config, "--until", 1, "--quiet", "--namespace", "/pond", "--out", run)
        self.assertEqual(self.answer("why-not", run, "go")["explanations"][0]["fired"], 1)

    # --- packages

    def test_a_package_may_be_the_folder_of_the_scenario(self):
        (self.folder / "msg").mkdir()
        (self.folder / "msg/Count.msg").write_text("int32 n\n")
        (self.folder / "agent.yaml").write_text(CONFIG)
        (self.folder / "rules.clp").write_text('(defrule go => (ros-msgs-destroy-message (ros-msgs-create-message "rules/msg/Count")))')
        for folder in (".", "./", "../" + self.folder.name):
            (self.folder / "scenario.yaml").write_text(f"schema: 1\nduration_s: 1\npackages: {{rules: {folder}}}\nagents:\n  - config: agent.yaml\n")
            self.cxlab("run", "scenario.yaml", "--quiet", "--out", "run", "--force")
            self.cxlab("replay", "run")

    # --- the page

    def test_a_skill_that_is_still_at_work_has_not_failed(self):
        run = self.timed_game(50)
        page = RunPage(run)
        bars = [bar for lane in page.lanes() for bar in lane["bars"]]
        self.assertIn(", still at work", [bar.get("remark") for bar in bars])
        self.assertNotIn("failed", [bar["kind"] for bar in bars])
        self.assertIn('href="logs&#x2f;agent.log"', page.text)

    def test_the_data_of_the_page_lie_beside_it(self):
        run = self.timed_game(100)
        data = json.loads((run / "report.json").read_text())
        self.assertEqual(data["result"], json.loads((run / "result.json").read_text()))
        self.assertEqual(sum(s["points"] for s in data["scores"]), sum(t["points"] for t in data["result"]["teams"].values()))
        self.assertEqual({s["state"] for s in data["skills"]}, {"succeeded", "running"})
        for what in data["skills"] + data["holds"]:
            self.assertLessEqual(what["begin"], what["end"])
        for hold in data["holds"]:  # a piece is picked at the beginning and placed at the end
            work = {s["skill"] for s in data["skills"] if s["robot"] == hold["robot"] and s["begin"] < hold["begin"] <= s["end"]}
            self.assertIn(work, ({"pick"}, {"transport"}))
        self.assertIn("report.json", data["files"])

    def test_the_page_shows_faults_robots_off_the_field_and_the_orders_of_both_teams(self):
        run = self.folder / "teams"
        faults = "faults=[{kind: robot_maintenance, at: 50, robot: robot4, seconds: 20}, {kind: machine_breaks, at: 60, machine: C-CS1}]"
        self.cxlab("run", SOURCE / "scenarios/rcll/two_teams.yaml", "--tier", "timed", "--until", 200, "--quiet", "--out", run, "--set", faults)
        data, page = json.loads((run / "report.json").read_text()), RunPage(run)
        self.assertEqual([(s["robot"], s["cause"], s["state"], s["begin"], s["end"]) for s in data["off_field"]],
                         [("robot4", "fault", "maintenance", 50.0, 70.0)])
        self.assertEqual([(f["t"], f["kind"], f["at"]) for f in data["faults"]],
                         [(50.0, "robot_maintenance", "robot4"), (60.0, "machine_breaks", "C-CS1")])
        self.assertEqual([task["id"] for task in page.part("Orders")["tasks"]][:4], ["CYAN-1", "MAGENTA-1", "CYAN-2", "MAGENTA-2"])
        self.assertIn("0:50 to 1:10 (fault)", page.text)

    def test_the_page_shows_pauses(self):
        run = self.folder / "paused"
        self.cxlab("run", SOURCE / "scenarios/rcll/game.yaml", "--tier", "timed", "--until", 100, "--quiet", "--out", run, "--set",
                   "world.pauses=[{at: 20, for: 10}, {at: 60, for: 50}]")
        data = json.loads((run / "report.json").read_text())
        self.assertEqual(data["pauses"], [{"begin": 20.0, "end": 30.0}, {"begin": 70.0, "end": 100.0}])
        self.assertEqual([(shade["begin"], shade["end"], shade["text"]) for shade in RunPage(run).run["shades"]], [(20, 30, "paused"), (70, 100, "paused")])

    # --- runs that were killed

    def killed(self, *arguments, log_bytes):
        """A run whose process was killed when the log of its inputs had so many bytes, if it had not ended before."""
        run = self.folder / f"killed-{log_bytes}"
        process = subprocess.Popen([CXLAB, *map(str, arguments), "--quiet", "--out", run], cwd=self.folder, stderr=subprocess.DEVNULL)
        log = run / "inputs.bin"
        while process.poll() is None and not (log.exists() and log.stat().st_size >= log_bytes):
            time.sleep(0.0005)
        process.kill()
        process.wait()
        return run

    def test_why_not_of_a_killed_run_is_that_of_the_whole_run(self):
        whole = self.timed_game(1200)
        size = (whole / "inputs.bin").stat().st_size
        rules = sorted((SOURCE / "scenarios/rcll/agent").rglob("*.clp"))
        rule = next(line.split()[1] for file in rules for line in file.read_text().splitlines() if line.startswith("(defrule "))
        chance = random.Random(7)
        times = []
        for log_bytes in [0, 9, *(chance.randrange(9, size * 3 // 4) for _ in range(4))]:
            killed = self.killed("run", GAME, "--tier", "timed", log_bytes=log_bytes)
            self.assertEqual(json.loads((killed / "result.json").read_text())["reason"]["code"], "unfinished")
            done = subprocess.run([CXLAB, "why-not", killed, rule, "--json"], capture_output=True, text=True, timeout=60)
            if done.returncode == 3:
                self.assertIn("ended before the log of its inputs had the first tick", done.stderr)
                continue
            self.assertEqual(done.returncode, 0, done.stderr)
            answer = json.loads(done.stdout)
            times.append(answer["at_s"])
            self.assertIs(answer.pop("cut_off"), True)
            self.assertEqual(answer, self.answer("why-not", whole, rule, "--at", times[-1]))
            early = self.answer("why-not", killed, rule, "--at", times[-1] / 2)
            self.assertLessEqual(early["at_s"], times[-1] / 2)
            self.assertEqual(early, self.answer("why-not", whole, rule, "--at", times[-1] / 2))
            late = subprocess.run([CXLAB, "why-not", killed, rule, "--at", "1200"], capture_output=True, text=True, timeout=60)
            self.assertEqual(late.returncode, 2, late.stderr)
            self.assertIn(f"--at: the run ends at {times[-1]:.9g} s, where the log of the run is cut off", late.stderr)
        self.assertGreater(len(times), 3)
        self.assertGreater(max(times), 100)

    def test_why_not_of_a_killed_run_without_any_inputs(self):
        config = self.package("(defrule go => (assert (here)))\n(defrule never (there) => (println \"there\"))")
        killed = self.killed("env", config, "--until", 1e8, log_bytes=100)
        answer = self.answer("why-not", killed, "never")
        self.assertGreater(answer["at_s"], 1)
        self.assertEqual(answer["explanations"][0]["first_unmet"]["because"], "there is no fact of there")
        self.assertEqual(self.answer("why-not", killed, "never", "--at", 1)["at_s"], 1)
        (killed / "inputs.bin").write_bytes((killed / "inputs.bin").read_bytes()[:8])   # killed at once
        self.assertIn("ended before the log of its inputs had the first tick", self.cxlab("why-not", killed, "never", expect=3).stderr)
        (killed / "inputs.bin").unlink()
        self.assertIn("ended before", self.cxlab("why-not", killed, "never", expect=3).stderr)

    def test_a_definition_that_is_read_late_is_among_the_copies_of_a_killed_run(self):
        config = self.package("""(defrule late (time ?t&:(> ?t 30)) (not (sent)) => (assert (sent))
            (bind ?m (ros-msgs-create-message "geometry_msgs/msg/Pose")) (ros-msgs-destroy-message ?m))
            (defrule never (there) => (println "there"))""", plugins='"executive", "messages", "files"')
        config.write_text(config.read_text() + '    messages: {plugin: "cx::RosMsgsPlugin"}\n')
        killed = self.killed("env", config, "--until", 1e8, log_bytes=400)
        answer = self.answer("why-not", killed, "late")
        self.assertGreater(answer["at_s"], 40)
        self.assertEqual(answer["explanations"][0]["fired"], 1)

    def test_an_error_of_the_replay_is_reported(self):
        config = self.package('(defrule go (time ?t) => (assert (there (ament-index-get-package-share-directory "mine"))))')
        run = self.folder / "run"
        self.cxlab("env", config, "--until", 2, "--quiet", "--out", run)
        copy = next((run / "files").glob("[0-9a-f]*"))
        for copy in (run / "files").glob("[0-9a-f]*"):
            if "share-directory" in copy.read_text():
                copy.write_text(copy.read_text().replace("mine", "none"))
        self.assertIn("was changed", self.cxlab("why-not", run, "go", expect=3).stderr)

    def test_why_not_of_a_run_that_failed_looks_at_its_end(self):
        config = self.package("(defrule bad (time ?t&:(> ?t 1)) => (/ 1 0))\n(defrule never (there) => (println \"there\"))")
        run = self.folder / "run"
        scenario = self.folder / "scenario.yaml"
        scenario.write_text(f"schema: 1\nduration_s: 5\npackages: {{mine: {config.parent.parent}}}\nagents:\n  - config: {config}\n")
        self.cxlab("run", scenario, "--quiet", "--out", run, expect=4)
        self.assertEqual(self.answer("why-not", run, "never")["at_s"], 1.5)
        self.assertEqual(self.answer("why-not", run, "bad", "--at", 1)["explanations"][0]["fired"], 0)

    def test_a_rerun_without_its_files_plays_the_runs_copies(self):
        config = self.package('(defrule a => (assert (one) (share (ament-index-get-package-share-directory "mine"))))')
        self.cxlab("env", config, "--until", 1, "--quiet", "--out", self.folder / "run")
        shutil.rmtree(config.parent.parent)
        for number in range(2):   # the rerun of a rerun too
            done = self.cxlab("rerun", self.folder / "run", "--out", self.folder / f"again{number}")
            self.assertIn("the same: ", done.stdout)
            self.assertIn("the run's own copies", done.stderr)

    def test_a_game_whose_agent_is_missing_is_rerun(self):
        agent = self.folder / "rcll/agent"
        shutil.copytree(SOURCE / "scenarios/rcll/agent", agent)
        shutil.copy(GAME, agent.parent / "game.yaml")
        self.cxlab("run", agent.parent / "game.yaml", "--tier", "timed", "--until", 60, "--quiet", "--out", self.folder / "run")
        shutil.rmtree(agent.parent)
        self.assertTrue(self.answer("rerun", self.folder / "run", "--quiet", "--out", self.folder / "again")["same"])

    def test_a_rerun_without_files_of_no_package_says_what_is_missing(self):
        (self.folder / "elsewhere.clp").write_text("(deffacts e (there))")
        config = self.package(f'(defrule a => (load* "{self.folder}/elsewhere.clp"))')
        self.cxlab("env", config, "--until", 1, "--trust-rules", "--quiet", "--out", self.folder / "run")
        shutil.rmtree(config.parent.parent)
        error = self.cxlab("rerun", self.folder / "run", expect=3).stderr
        self.assertIn("the configuration is missing: ", error)
        self.assertIn("cxlab replay", error)

    # --- render

    def test_a_picture_of_a_run_is_that_of_its_scenario(self):
        run = self.physics_game(4)
        probe = [CXLAB, "render", run, "--at", "1", "--size", "320x240", "--out", self.folder / "probe.png"]
        if "OpenGL" in subprocess.run(probe, capture_output=True, text=True, env=os.environ | FEW_PICTURES).stderr:
            self.skipTest("no OpenGL here")
        self.cxlab("render", run, "--at", 3, "--camera", "top", "--size", "320x240", "--out", self.folder / "run.png")
        self.cxlab("render", GAME, "--at", 3, "--camera", "top", "--size", "320x240", "--out", self.folder / "scenario.png")
        self.assertEqual((self.folder / "run.png").read_bytes(), (self.folder / "scenario.png").read_bytes())
        self.cxlab("render", run, "--at", 100, "--out", self.folder / "late.png", expect=2)
        self.cxlab("render", run, "--camera", "top", "--size", "320x240", "--out", self.folder / "end.png")
        killed = self.killed("run", GAME, log_bytes=(run / "inputs.bin").stat().st_size // 2)
        self.cxlab("render", killed, "--camera", "top", "--size", "320x240", "--out", self.folder / "killed.png")
        self.assertNotEqual((self.folder / "end.png").read_bytes(), (self.folder / "run.png").read_bytes())
        start = self.folder / "start.png"
        self.cxlab("render", run, "--at", 0, "--camera", "top", "--size", "320x240", "--out", start)
        self.assertNotEqual((self.folder / "killed.png").read_bytes(), start.read_bytes())
        self.assertIn("robot1", self.cxlab("render", run, "--at", 1, "--camera", "robbot1", "--out", self.folder / "x.png", expect=3).stderr)

    def test_a_picture_of_a_run_has_the_points_of_then(self):
        run = self.folder / "run"
        options = ["--until", 90, "--snapshot", 90, "--quiet", "--out", run]
        if subprocess.run([CXLAB, "run", GAME, *map(str, options)], capture_output=True, cwd=self.folder, timeout=60, env=os.environ | FEW_PICTURES).returncode == 5:
            self.skipTest("no OpenGL here")
        self.assertGreater(json.loads((run / "result.json").read_text())["teams"]["CYAN"]["points"], 0)
        self.cxlab("render", run, "--at", 90, "--camera", "top", "--size", "640x400", "--out", self.folder / "again.png")
        self.assertTrue((self.folder / "again.png").read_bytes() == (run / "snapshots/0090.00-top.png").read_bytes())

    def test_an_impossible_picture_is_an_error(self):
        (self.folder / "empty.yaml").write_text("schema: 1\nduration_s: 2\n")
        self.cxlab("run", "empty.yaml", "--quiet", "--out", "empty")
        self.assertIn("empty world", self.cxlab("render", self.folder / "empty", "--at", 1, "--out", "x.png", expect=3).stderr)
        self.assertIn("--size", self.cxlab("render", GAME, "--at", 1, "--out", "x.png", "--size", "big", expect=2).stderr)


if __name__ == "__main__":
    unittest.main()
