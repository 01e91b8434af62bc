"""cxlab rerun --at: a run that goes on otherwise from a time. python3 -m unittest what_if"""

import json
import shutil
import subprocess

from lab import CXLAB, SOURCE, Lab, stopped_run

GAME = SOURCE / "scenarios/rcll/game.yaml"
RULES = """(deftemplate order (slot id (type INTEGER)) (slot state (default new)))
(defglobal ?*limit* = 3)
(deffacts start (order (id 1)))
(defrule count (time ?t) => (assert (seen ?t ?*limit*)))
(defrule finish ?o <- (order (state new)) (ready) => (modify ?o (state done)))
"""


class WhatIf(Lab):
    def cxlab(self, *arguments, expect=0):
        done = subprocess.run([CXLAB, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder, timeout=120)
        self.assertEqual(done.returncode, expect, f"cxlab {arguments}\n{done.stdout}\n{done.stderr}")
        return done

    def small_run(self, *arguments):
        self.agent(RULES)
        self.write("repair.clp", "\n(defrule finish ?o <- (order (state new)) => (modify ?o (state done)))\n")
        self.cxlab("run", "scenario.yaml", "--quiet", "--journal", "full", "--out", "run", *arguments)

    def what_if(self, *arguments, of="run", out="again", expect=0):
        return json.loads(self.cxlab("rerun", of, "--quiet", "--json", "--out", out, *arguments, expect=expect).stdout)

    def lines(self, run, before):
        """The lines of the journal before that time (s)."""
        return [line for line in (self.folder / run / "journal.jsonl").read_text().splitlines() if json.loads(line)["t"] < before * 1e9]

    def hash(self, run):
        return json.loads((self.folder / run / "result.json").read_text())["journal_hash"]

    def plays_as_recorded(self, run):
        self.assertTrue(json.loads((self.folder / run / "result.json").read_text())["deterministic"])
        self.cxlab("replay", run)
        self.assertTrue(json.loads(self.cxlab("rerun", run, "--quiet", "--json", "--out", run + "-again").stdout)["same"])

    def test_the_answer_names_what_changed_and_what_followed(self):
        self.small_run()
        done = self.cxlab("rerun", "run", "--at", "0:01", "--then", "repair.clp", "--out", "again")
        text = done.stdout
        self.assertTrue(text.startswith(f"as then up to 1.000 s\n1.000 s  main: repair.clp replaces defrule finish ({self.folder}/rules/rules.clp:5)\n"), text)
        self.assertRegex(text, r"\n +then +now\nstatus +completed +completed\nsim_time_s +2\.0 +2\.0\n")
        self.assertRegex(text, r"\nfirst difference: env/main at 1\.000 s: then .*, now .*\n")
        self.assertTrue(text.endswith("\nagain\n"), text)
        self.assertNotIn("Permission denied", text + done.stderr)
        self.assertEqual(self.lines("run", 1), self.lines("again", 1))
        self.plays_as_recorded("again")
        # The repair is no difference itself, and what its rules do first is.
        self.assertRegex(self.cxlab("diff", "run", "again", expect=1).stdout, r"what differs first, in main:\na: .*\n   rule finish did not fire: .*\nb: rule finish \(repair")

    def test_the_answer_as_json(self):
        self.small_run()
        answer = self.what_if("--at", "1", "--set", "?*limit*=7", "--assert", "(order (id 2))", "--then", "repair.clp")
        self.assertEqual([change["what"].split(" (")[0] for change in answer["changes"]],
                         ["repair.clp replaces defrule finish", "sets ?*limit* to 7", answer["changes"][2]["what"].split(" (")[0]])
        self.assertRegex(answer["changes"][2]["what"], r"^asserts f-\d+ \(order \(id 2\)\)$")
        self.assertEqual({(change["t"], change["env"]) for change in answer["changes"]}, {(1, "main")})
        self.assertTrue(answer["same_before"])
        self.assertEqual((answer["at"], answer["again"], answer["now"]["status"], answer["now"]["sim_time_s"]), (1, "again", "completed", 2))
        self.assertEqual(answer["first_differences"][0]["stream"], "env/main")
        self.assertIn("what if, at 1.000 s: (order (id 2))", self.cxlab("why", "again", "(order (id 2))").stdout)
        made = json.loads(self.cxlab("facts", "again", "(order (id 2))", "--json").stdout)["environments"][0]["facts"][0]["changes"][0]
        self.assertEqual((made["by"]["kind"], made["by"]["name"]), ("what_if", "(order (id 2))"))
        manifest = json.loads((self.folder / "again/manifest.json").read_text())
        self.assertEqual(manifest["what_if"], [{"at": 1.0, "then": "repair.clp", "set": ["?*limit*=7"], "assert": ["(order (id 2))"],
                                                "copy": "what_if/0/repair.clp"}])

    def test_without_a_change_it_is_the_same_run(self):
        self.small_run()
        self.assertIn("no record of the journal differs", self.cxlab("rerun", "run", "--at", 1, "--out", "again").stdout)
        self.assertEqual(self.hash("run"), self.hash("again"))

    def test_another_end(self):
        self.small_run("--until", 1)
        answer = self.what_if("--at", 0.5, "--then", "repair.clp", "--until", "0:01.5")
        self.assertEqual((answer["then"]["sim_time_s"], answer["now"]["sim_time_s"]), (1, 1.5))
        self.assertRegex(self.cxlab("rerun", "run", "--at", 0.5, "--then", "repair.clp", "--until", 0.8, "--out", "short").stdout,
                         r"\n +then, up to 1\.000 s +now, up to 0\.800 s\n(.*\n)+\nfirst difference: env/main at 0\.500 s: .*\nshort\n$")
        self.assertIn("--until: found 0.2", self.cxlab("rerun", "run", "--at", 0.5, "--until", 0.2, expect=2).stderr)

    def test_a_run_that_failed_goes_on_with_a_repair(self):
        self.agent(RULES + "(defrule wrong (time ?t&:(> ?t 1.2)) => (+ 1 (nth$ 1 (create$ one))))\n")
        self.fails(4)
        self.write("repair.clp", "(undefrule wrong)\n")
        answer = self.what_if("--at", 1, "--then", "repair.clp", of="out")
        self.assertEqual((answer["then"]["status"], answer["now"]["status"], answer["now"]["sim_time_s"]), ("failed", "completed", 2))
        self.assertTrue(answer["same_before"])
        self.plays_as_recorded("again")

    def test_a_run_that_fails_now_has_its_exit_code_and_a_comparison(self):
        self.small_run()
        self.write("wrong.clp", "(defrule wrong (time ?t&:(> ?t 1.2)) =>\n  (+ 1 (nth$ 1 (create$ one))))\n")
        done = self.cxlab("rerun", "run", "--quiet", "--at", 1, "--then", "wrong.clp", "--out", "again", expect=4)
        self.assertIn("wrong.clp:2: rule wrong, RHS", done.stderr)
        self.assertRegex(done.stdout, r"\nstatus +completed +failed\n")

    def test_a_run_that_was_killed_goes_on_with_a_repair(self):
        self.small_run()
        result = json.loads((self.folder / "run/result.json").read_text())
        result.update(status="failed", stream_hashes={}, journal_hash="", sim_time_s=0)
        (self.folder / "run/result.json").write_text(json.dumps(result))
        journal = (self.folder / "run/journal.jsonl").read_text().splitlines(keepends=True)
        (self.folder / "run/journal.jsonl").write_text("".join(journal[:-20]) + journal[-20][:30])
        answer = self.what_if("--at", 1, "--then", "repair.clp")
        self.assertTrue(answer["same_before"])
        self.assertEqual(answer["changes"][0]["what"], f"repair.clp replaces defrule finish ({self.folder}/rules/rules.clp:5)")
        said = self.cxlab("rerun", "run", "--at", 5, "--then", "repair.clp", "--out", "late", expect=2).stderr
        self.assertIn("--at: the run ends at 2 s, where the log of the run is cut off", said)

    def test_a_changed_file_is_a_difference_before(self):
        self.small_run()
        self.write("rules/rules.clp", RULES.replace("(id 1)", "(id 9)"))
        done = self.cxlab("rerun", "run", "--quiet", "--at", 1, "--then", "repair.clp", "--out", "again", expect=1)
        self.assertRegex(done.stdout, r"^different before 1\.000 s: env/main at [-0-9.]+ s: then .*\(?.*1.*, now .*9.*\n  not the file of the run: agents/0/packages/rules/rules\.clp\n")
        self.assertEqual(json.loads(self.cxlab("rerun", "run", "--quiet", "--at", 1, "--json", "--out", "b", expect=1).stdout)["same_before"], False)

    def test_wrong_input_is_an_error(self):
        self.small_run()
        self.write("unbalanced.clp", "(defrule a =>)\n(defrule b =>\n")
        self.write("unknown.clp", "(defrule a =>)\n(defrule b (order (idd 1)) =>)\n")
        (self.folder / "binary.clp").write_bytes(bytes(range(256)) * 8)
        for arguments, code, text in [
                (["--at", "5"], 2, "--at: the run ends at 2 s"),
                (["--at", "-1"], 2, "--at: found '-1', expected a time"),
                (["--at", "soon"], 2, "--at: found 'soon', expected a time"),
                (["--at", "1", "--then", "missing.clp"], 3, "missing.clp: there is no such file"),
                (["--at", "1", "--then", "binary.clp"], 3, "binary.clp:1: "),
                (["--at", "1", "--then", "/dev/zero"], 3, "/dev/zero: is no file"),
                (["--at", "1", "--then", "unbalanced.clp"], 3, "unbalanced.clp:2: "),
                (["--at", "1", "--then", "unknown.clp"], 3, "unknown.clp:2: "),
                (["--then", "repair.clp"], 2, "--then: expected --at T as well"),
                (["--assert", "(ready)"], 2, "--assert: expected --at T as well"),
                (["--until", "1"], 2, "--until: expected --at T as well"),
                (["--at", "1", "--env", "main"], 2, "--env: says for which environment"),
                (["--at", "1", "--set", "agents[0].params={clips_manager.x: 1}"], 2, "a parameter is set by itself: --set NODE.NAME=VALUE, of /clips_manager"),
                (["--at", "1", "--set", "world.robots=2"], 2, "--set world.robots=2: found 'world.robots', expected a parameter of an agent's node"),
                (["--at", "1", "--set", "duration_s=2"], 2, "--set duration_s=2: duration_s is fixed when a run begins"),
                (["--at", "1", "--set", "clips_manager.refresh=2"], 3, "has no parameter 'refresh'"),
                (["--at", "1", "--set", "?*lmit*=2"], 3, "there is no global '?*lmit*', did you mean '?*limit*'?"),
                (["--at", "1", "--assert", "(ordr (id 1))"], 3, "there is no template 'ordr', did you mean 'order'?"),
                (["--at", "1", "--assert", "(order (id 1)) (order (id 2))"], 2, "expected one fact"),
                (["--at", "1", "--env", "mian", "--assert", "(order (id 1))"], 2, "did you mean 'main'?")]:
            shutil.rmtree(self.folder / "again", ignore_errors=True)
            done = self.cxlab("rerun", "run", "--quiet", "--out", "again", *arguments, expect=code)
            self.assertIn(text, done.stderr, arguments)
            self.assertEqual((done.stdout, done.stderr.count("error:")), ("", 1), arguments)

    def test_the_run_itself_is_no_place_for_the_new_one(self):
        self.small_run()
        before = self.hash("run")
        self.assertIn("--out: found the folder of the run itself", self.cxlab("rerun", "run", "--at", 1, "--out", "./run", "--force", expect=2).stderr)
        self.assertEqual(self.hash("run"), before)

    def test_a_run_with_a_person_is_refused(self):
        self.agent(RULES)
        run = stopped_run(self, "scenario.yaml", out="run", cwd=self.folder)
        self.cxlab("attach", "run", "--quiet", "-c", "assert (ready)", "-c", "continue")
        self.assertEqual(run.wait(30), 0)
        self.write("repair.clp", "(defrule a =>)\n")
        self.assertIn("a person (cxlab attach) took part", self.cxlab("rerun", "run", "--at", 1, "--then", "repair.clp", expect=2).stderr)

    def test_the_run_of_a_stranger_shows_no_other_files(self):
        self.small_run()
        (self.folder / "secret.clp").write_text("(secret)")
        manifest = json.loads((self.folder / "run/manifest.json").read_text())
        manifest["what_if"] = [{"at": 1, "then": str(self.folder / "secret.clp")}]
        (self.folder / "run/manifest.json").write_text(json.dumps(manifest))
        self.assertIn("what_if/0/secret.clp", self.cxlab("rerun", "run", "--quiet", "--out", "again", expect=3).stderr)
        for wrong in ([{}], [{"at": -1}], [{"at": "x"}], [{"at": 1e300}], "x", [3], [{"at": 1, "set": "x"}]):
            manifest["what_if"] = wrong
            (self.folder / "run/manifest.json").write_text(json.dumps(manifest))
            self.assertIn("not the manifest of a run", self.cxlab("rerun", "run", "--quiet", "--out", "again", expect=3).stderr, wrong)

    def test_a_repair_of_an_agent_delivers(self):
        shutil.copytree(SOURCE / "scenarios/rcll/agent", self.folder / "agent")
        products = (self.folder / "agent/clips/products.clp").read_text()
        broken = products.replace('(product (order ?id) (todo "DELIVER") (state WAITING))', '(product (order ?id) (todo "DELIVR") (state WAITING))')
        self.assertNotEqual(broken, products)
        self.write("agent/clips/products.clp", broken)
        self.write("products.clp", products)
        self.write("game.yaml", GAME.read_text())
        self.cxlab("run", "game.yaml", "--tier", "timed", "--until", 500, "--quiet", "--out", "run")
        answer = self.what_if("--at", "5:00", "--then", "products.clp")
        self.assertTrue(answer["same_before"], answer)
        self.assertRegex(answer["changes"][0]["what"], r"products\.clp replaces defrule product-deliver \(.*products\.clp:\d+\)")
        self.assertEqual(len(answer["changes"]), 1)
        self.assertEqual(answer["then"]["CYAN.delivery"], 0)
        self.assertGreater(answer["now"]["CYAN.delivery"], 0)
        self.assertGreater(answer["now"]["CYAN.points"], answer["then"]["CYAN.points"])
        self.assertIn("referee", [difference["stream"] for difference in answer["first_differences"]])
        self.assertEqual(self.lines("run", 300), self.lines("again", 300))
        self.what_if("--at", "300", "--then", "products.clp", out="twice")
        self.assertEqual(self.hash("again"), self.hash("twice"))
        self.plays_as_recorded("again")

    def test_a_game_with_physics(self):
        self.cxlab("run", GAME, "--until", 60, "--quiet", "--out", "run")
        same = self.what_if("--at", 30, out="same")
        self.assertEqual((same["changes"], same["first_differences"]), ([], []))
        self.write("still.clp", "(undefrule robot-take-job)\n(undefrule explore-go)\n")
        answer = self.what_if("--at", 30, "--then", "still.clp")
        self.assertTrue(answer["same_before"], answer)
        self.assertGreaterEqual(answer["first_differences"][0]["t"], 30)
        results = [json.loads((self.folder / run / "result.json").read_text()) for run in ("run", "same", "again")]
        self.assertEqual(results[0]["physics_hash"], results[1]["physics_hash"])
        self.assertNotEqual(results[0]["physics_hash"], results[2]["physics_hash"])
        self.plays_as_recorded("again")
