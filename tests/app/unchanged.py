"""Agents of the CX as they are: games that were played, streams, questions, the trainer, files for ROS 2."""

import json
import re
import shutil
import subprocess

from lab import CXLAB, SOURCE, Lab

LEAGUE = SOURCE / "docs/examples/league"


class Agents(Lab):
    def config(self, plugins, more="", environments=("main",)):
        lists = "".join(f"    {e}: {{plugins: [{', '.join(plugins)}, {e}_rules], watch: [{'facts' if 'protobuf' in plugins else ''}]}}\n"
                        f"    {e}_rules: {{plugin: \"cx::FileLoadPlugin\", pkg_share_dirs: [agent], load: [{e}.clp]}}\n" for e in environments)
        return self.write("agent/params/agent.yaml", f"""/**:
  ros__parameters:
    environments: [{", ".join(environments)}]
{lists}    executive: {{plugin: "cx::ExecutivePlugin", refresh_rate: 10}}
    ros_param: {{plugin: "cx::RosParamPlugin"}}
    ros_msgs: {{plugin: "cx::RosMsgsPlugin"}}
    reset_env: {{plugin: "cx::CXCxRlInterfacesResetEnvPlugin"}}
    protobuf: {{plugin: "cx::ProtobufPlugin", pkg_share_dirs: [agent], proto_paths: [proto]}}
{more}""")

    def env(self, rules, *arguments, plugins=("executive",), more="", code=0, until=1, out="none", stdin=""):
        rules = {"main": rules} if isinstance(rules, str) else rules
        for environment, text in rules.items():
            self.write(f"agent/{environment}.clp", text)
        done = subprocess.run([CXLAB, "env", self.config(plugins, more, tuple(rules)), "--until", str(until), "--out", out, *map(str, arguments)],
                              cwd=self.folder, text=True, timeout=60, input=stdin, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, code, done.stdout)
        return done.stdout


class Ends(Lab):
    """An error while the agent shuts down does not undo a game that was played to its end."""

    FAILURES = {
        "a rule error": ("(executive-finalize)", "(+ 1 (nth$ 1 (create$ a-word)))", "ARGACCES"),
        "a loop": ("(executive-finalize) ?f <- (turn ?n)", "(retract ?f) (assert (turn (+ ?n 1)))", "max_firings_per_tick"),
        "an endless action": ("(executive-finalize)", "(while TRUE do (bind ?x 1))", "Still looping"),
        "an unknown file": ("(executive-finalize)", '(ros-msgs-get-field (ros-msgs-create-message (str-cat "no/msg/" Such)) "x")', "no/msg/Such"),
    }

    def test_they_are_completed(self):
        for name, (condition, action, text) in self.FAILURES.items():
            with self.subTest(name):
                self.agent(f"(deffacts turns (turn 0))\n(defrule late {condition} => {action})\n")
                shutil.rmtree(self.out, ignore_errors=True)
                done = self.run_it()
                self.assertEqual(done.returncode, 0, done.stderr)
                result = self.result()
                self.assertEqual((result["status"], result["reason"], result["sim_time_s"]), ("completed", None, 2.0))
                self.assertTrue(any(w.startswith("while the agent shut down: ") and text in w for w in result["warnings"]), result["warnings"])
                self.assertTrue(result["journal_hash"])

    def test_also_where_rules_ask_for_the_end(self):
        self.agent("(defrule stop (time ?t&:(> ?t 1)) => (cx-shutdown))\n(defrule late (executive-finalize) => (+ 1 (nth$ 1 (create$ a-word))))\n")
        self.assertEqual(self.run_it().returncode, 0)
        self.assertEqual(self.result()["status"], "stopped")
        self.assertTrue(self.result()["warnings"])

    def test_before_the_end_it_fails(self):
        self.agent("(defrule early (time ?t&:(> ?t 1)) => (+ 1 (nth$ 1 (create$ a-word))))\n(defrule late (executive-finalize) => (+ 1 (nth$ 1 (create$ another-word))))\n")
        done = self.run_it()
        self.assertEqual(done.returncode, 4)
        self.assertIn("early", self.result()["reason"]["message"] + done.stderr)
        self.assertEqual(self.result()["status"], "failed")
        self.assertFalse([w for w in self.result()["warnings"] if "shut down" in w])

    def test_a_file_that_is_loaded_then(self):
        self.agent('(defrule late (executive-finalize) => (load* (str-cat "more" ".clp")) (ros-msgs-create-publisher "/x" "no/msg/Such"))\n')
        done = subprocess.run([CXLAB, "env", "agent.yaml", "--package", "rules=rules", "--until", "1", "--out", self.out], cwd=self.folder, text=True,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual(self.result()["status"], "completed")

    def test_strict_findings_count_all_the_same(self):
        self.agent('(defrule keep (time 0.0) => (ros-msgs-create-message "std_msgs/msg/String"))\n')
        self.assertEqual(self.run_it("--strict-cx").returncode, 3)

    def test_a_whole_game_of_an_agent_that_opens_its_peers_again(self):
        shutil.copytree(LEAGUE, self.folder / "league")
        peers = self.folder / "league/clips/peers.clp"
        peers.write_text(peers.read_text().replace("  (not (executive-finalize))\n", "", 1))
        done = subprocess.run([CXLAB, "run", "league/game.yaml", "--set", "world.production_s=20", "--set", "world.overtime_s=0", "--set", "expect=[]", "--quiet", "--out", self.out],
                              cwd=self.folder, text=True, timeout=120, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual(self.result()["status"], "completed")
        self.assertTrue(any(w.startswith("while the agent shut down: ") for w in self.result()["warnings"]), self.result()["warnings"])


class Streams(Agents):
    def test_a_client_that_comes_first_finds_its_server(self):
        self.write("agent/proto/note.proto", 'syntax = "proto2";\nmessage Note { enum CompType { COMP_ID = 7; MSG_TYPE = 1; } required string text = 1; }\n')
        caller, listener = '(defrule call => (pb-connect "127.0.0.1" 4500))\n', "(defrule listen => (pb-server-enable 4500))\n"
        for rules in ({"caller": caller, "listener": listener}, {"listener": listener, "caller": caller}):
            said = self.env(rules, plugins=("executive", "protobuf"), out=str(self.out), until=2, *(["--force"] if self.out.exists() else []))
            self.assertIn("(protobuf-client-connected 1)", said)
            self.assertIn("(protobuf-server-client-connected 1 127.0.0.1 49152)", said)
            self.assertNotIn("disconnected", said)
            self.assertEqual((said.count("Initialised context!"), said.count("Destroying clips context!")), (2, 2))
            replayed = subprocess.run([CXLAB, "replay", self.out], text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            self.assertEqual(replayed.returncode, 0, replayed.stdout)
        said = self.env({"caller": caller}, plugins=("executive", "protobuf"))
        self.assertIn("(protobuf-client-disconnected 1)", said)

    def test_a_client_in_a_rule_that_fires_later(self):
        self.write("agent/proto/note.proto", 'syntax = "proto2";\nmessage Note { optional string text = 1; }\n')
        said = self.env({"caller": '(defrule call (time 0.5) => (pb-connect "127.0.0.1" 4500))\n', "listener": "(defrule listen (time 0.5) => (pb-server-enable 4500))\n"},
                        plugins=("executive", "protobuf"))
        self.assertIn("(protobuf-client-connected 1)", said)


class Words(Agents):
    def test_the_last_line_needs_no_end(self):
        said = self.env('(defrule r => (printout t "full line" crlf "and the result is 42"))', out=str(self.out))
        self.assertIn("full line\n", said)
        self.assertIn("and the result is 42\n", said)
        self.assertIn("and the result is 42\n", (self.out / "logs/main.log").read_text())

    def test_it_may_be_put_together(self):
        said = self.env('(defrule r => (printout t "all is " ) (printout warn "lost"))')
        self.assertIn("all is lost", said)
        self.assertRegex(said, r"\[info\].*all is lost")

    def test_a_question_is_shown_before_its_answer_is_read(self):
        said = self.env('(defrule q => (printout t "name? ") (bind ?n (readline)) (printout t "hello " ?n crlf))', "--trust-rules", stdin="Ann\n")
        self.assertLess(said.index("name? "), said.index("hello Ann"))
        self.assertNotIn("name? hello", said)

    QUESTION = """(deffunction ask (?q $?ok) (printout t ?q " ") (bind ?a (READ)) (while (not (member$ ?a ?ok)) (printout t ?q " ") (bind ?a (READ))) ?a)
(defrule q => (assert (answer (ask "engine starts (yes/no)?" yes no))))
"""

    def test_a_question_without_end_is_an_error_of_the_rule(self):
        for read in ("read", "readline"):
            for trust in ([], ["--trust-rules"]):
                with self.subTest(read, trust=trust):
                    self.setUp()
                    said = self.env(self.QUESTION.replace("READ", read), *trust, out=str(self.out))
                    self.assertLess(len(said), 200_000)
                    errors = json.loads((self.out / "result.json").read_text())["rule_errors"]
                    self.assertEqual(len(errors), 1, errors)
                    self.assertEqual(errors[0]["rule"], "q")
                    self.assertIn("The terminal was read 1000 times at its end in one action: stopped", errors[0]["message"])
                    self.assertEqual("--trust-rules" in errors[0]["message"], not trust)

    def test_one_question_in_each_of_many_firings_is_none_without_end(self):
        said = self.env('(deffacts n (n 0))\n(defrule q ?f <- (n ?n&:(< ?n 2000)) => (retract ?f) (if (eq (read) EOF) then (assert (n (+ ?n 1)))))\n'
                        '(defrule done (n 2000) => (printout t "asked 2000 times" crlf))')
        self.assertIn("asked 2000 times", said)
        self.assertNotIn("[error]", said)


class Files(Agents):
    GO = '(defrule go => (printout t "limit " (ros-param-get-value "limit" 0.0) crlf))'

    def strict(self, more, code=3):
        return self.env(self.GO, "--strict-cx", plugins=("executive", "ros_param"), more=more, code=code)

    def test_what_rcl_refuses_is_a_strict_error(self):
        for more, what in (("    zones: [1, 2.5]\n", "a list with an integer and a double"),
                           ("    zones: [a, true]\n", "a list with a string and a bool"),
                           ("    zones: [a, 'b', \"c\", 4]\n", "a list with a string and an integer"),
                           ("    zones:\n      - {id: 1}\n", "a map in a list"),
                           ("    zones: [[1, 2], [3, 4]]\n", "a list in a list"),
                           ("    limit: &l 1.0\n    other: *l\n", "an alias, which it does not know"),
                           ("    deep: {er: {list: [1, x]}}\n", "a list with an integer and a string"),
                           ("    base: &b {x: 1}\n    more: {<<: *b}\n", "an alias, which it does not know"),
                           ("/other:\n  ros__parameters: {z: [1, x]}\n", "a list with an integer and a string"),
                           ("/other:\n  speed: 3\n", "a value of 'speed' outside of ros__parameters")):
            with self.subTest(more):
                said = self.strict(more)
                line = (self.folder / "agent/params/agent.yaml").read_text().count("\n") - more.count("\n") + (1 if more.count("\n") == 1 else 2)
                self.assertIn(f"agent.yaml:{line}: strict-cx: yaml: found {what}: rcl's parser refuses the file", said)
                self.assertNotIn("strict-cx: yaml", self.env(self.GO, plugins=("executive", "ros_param"), more=more))

    def test_what_it_takes_is_none(self):
        self.strict("    limit: &unused 1.0\n    a: [1, 0x10]\n    b: [1.0, .inf, 2e3]\n    c: [on, false]\n    d: ['1', two, \"3\"]\n    e: []\n    f: {g: {h: [x]}}\n", code=0)

    def test_infinite_numbers_are_doubles(self):
        for text, value in ((".inf", "inf"), ("-.inf", "-inf"), (".INF", "inf"), (".nan", "nan"), ("1e308", "1e+308")):
            said = self.env(self.GO, plugins=("executive", "ros_param"), more=f"    limit: {text}\n")
            self.assertRegex(said, f"limit {re.escape(value)}(\\.0)?\n")
            self.assertNotIn("[error]", said)
        said = self.env('(defrule go => (printout t (ros-param-get-value "limit" 0) crlf))', plugins=("executive", "ros_param"), more="    limit: .inf\n")
        self.assertIn("the default wants an integer", said)


class Trainer(Agents):
    EARLY = """(defrule open
  (not (executive-finalize)) (not (ros-msgs-client))
  =>
  (ros-msgs-create-client "/cx_rl_node/get_status" "cx_rl_interfaces/srv/GetStatus")
  (cx-rl-interfaces-reset-env-create-server "/cx_rl_node/reset_env"))
(defrule ask (time ?) (not (asked))
  =>
  (bind ?q (ros-msgs-create-request "cx_rl_interfaces/srv/GetStatus"))
  (if (ros-msgs-async-send-request ?q "/cx_rl_node/get_status") then (assert (asked)))
  (ros-msgs-destroy-message ?q))
(defrule know ?r <- (ros-msgs-response (msg-ptr ?m))
  =>
  (printout t "mode " (ros-msgs-get-field ?m "mode") crlf)
  (ros-msgs-destroy-message ?m)
  (retract ?r)
  (assert (mode-known)))
(defrule too-early (declare (salience 10)) (cx-rl-interfaces-reset-env-accepted-goal) (not (mode-known))
  =>
  (printout warn "an episode begins before the mode is known" crlf))
(defrule begins (cx-rl-interfaces-reset-env-accepted-goal) => (printout t "an episode begins at " (now) crlf))
"""
    SPACES = """
(deffunction say (?name) (printout t "asked for " ?name " at " (now) crlf))
(deffunction /cx_rl_node/get_predefined_observables-service-callback (?s ?q ?a) (say predefined_observables))
(deffunction /cx_rl_node/get_observable_predicates-service-callback (?s ?q ?a)
  (say observable_predicates)
  (ros-msgs-set-field ?a "predicate_names" (create$ on clear))
  (ros-msgs-set-field ?a "param_counts" (create$ 2 1))
  (ros-msgs-set-field ?a "param_names" (create$ x y x))
  (ros-msgs-set-field ?a "param_types" (create$ block place block)))
(deffunction /cx_rl_node/get_predefined_actions-service-callback (?s ?q ?a) (say predefined_actions))
(deffunction /cx_rl_node/get_observable_actions-service-callback (?s ?q ?a)
  (say observable_actions)
  (ros-msgs-set-field ?a "param_types" (create$ block robot)))
(deffunction /cx_rl_node/get_observable_objects-service-callback (?s ?q ?a)
  (say (str-cat "objects of " (ros-msgs-get-field ?q "type"))))
(defrule serve
  =>
  (ros-msgs-create-service "/cx_rl_node/get_predefined_observables" "cx_rl_interfaces/srv/GetPredefinedObservables")
  (ros-msgs-create-service "/cx_rl_node/get_observable_predicates" "cx_rl_interfaces/srv/GetObservablePredicates")
  (ros-msgs-create-service "/cx_rl_node/get_predefined_actions" "cx_rl_interfaces/srv/GetPredefinedActions")
  (ros-msgs-create-service "/cx_rl_node/get_observable_actions" "cx_rl_interfaces/srv/GetObservableActions")
  (ros-msgs-create-service "/cx_rl_node/get_observable_objects" "cx_rl_interfaces/srv/GetObservableObjects"))
"""
    PLUGINS = ("executive", "ros_msgs", "reset_env")

    def test_it_asks_for_the_spaces_first(self):
        said = self.env(self.EARLY + self.SPACES, "--with", "cx_rl_node", plugins=self.PLUGINS, until=3)
        self.assertNotIn("[warn]", said.split("an episode begins")[0])
        asked = [line.split("asked for ")[1].split(" at ")[0] for line in said.splitlines() if "asked for " in line]
        self.assertEqual(asked, ["predefined_observables", "observable_predicates", "predefined_actions", "observable_actions",
                                 "objects of block", "objects of place", "objects of robot"])
        last = max(float(line.split(" at ")[1]) for line in said.splitlines() if "asked for " in line)
        begins = float(said.split("an episode begins at ")[1].split()[0])
        self.assertTrue(last + 1 <= begins < last + 1.3, (last, begins))

    def test_it_goes_on_without_spaces_that_nobody_serves(self):
        said = self.env(self.EARLY, "--with", "cx_rl_node", plugins=self.PLUGINS, until=8)
        self.assertIn("nobody serves get_predefined_observables, get_observable_predicates, get_predefined_actions, get_observable_actions: the training begins without", said)
        self.assertNotIn("before the mode is known", said)
        self.assertGreaterEqual(float(said.split("an episode begins at ")[1].split()[0]), 6)

    def test_one_that_hangs_is_reported(self):
        for rules, waits in ((self.EARLY, "the action reset_env, which the agent has accepted"), ('(defrule nothing (never) =>)', "the service get_predefined_observables")):
            with self.subTest(waits):
                self.setUp()
                self.env(rules, "--with", "cx_rl_node", plugins=self.PLUGINS, until=400, code=4, out=str(self.out))
                result = json.loads((self.out / "result.json").read_text())
                self.assertEqual((result["status"], result["reason"]["code"]), ("failed", "trainer_hangs"))
                self.assertIn("/cx_rl_node: the training has not ended: in episode 1 of 100 it waits since", result["reason"]["message"])
                self.assertIn(waits, result["reason"]["message"])

    def test_one_that_has_not_ended_is_a_warning(self):
        said = self.env(self.EARLY, "--with", "cx_rl_node", plugins=self.PLUGINS, until=9, out=str(self.out))
        result = json.loads((self.out / "result.json").read_text())
        self.assertEqual(result["status"], "completed")
        self.assertIn("the training has not ended", result["warnings"][0])
        self.assertIn("the training has not ended", said)


class League(Lab):
    def league(self, *edits):
        shutil.copytree(LEAGUE, self.folder / "league")
        for name, old, new in edits:
            file = self.folder / "league" / name
            self.assertIn(old, file.read_text())
            file.write_text(file.read_text().replace(old, new, 1))

    def test_a_robot_waits_at_a_machine_that_is_still_at_work(self):
        # Awaits PROCESSING where the example awaits READY-AT-OUTPUT, and gives up if a task fails.
        self.league(("clips/production.clp", "(step (number 3) (do AWAIT) (machine ?cs) (what READY-AT-OUTPUT))", "(step (number 3) (do AWAIT) (machine ?cs) (what PROCESSING))"),
                    ("clips/production.clp", "(robot (number 1) (state FAILED))\n  =>\n  (retract ?sent))", '(robot (number 1) (state FAILED))\n  =>\n  (printout t "gives up" crlf))'))
        for tier in ("timed", "physics"):
            with self.subTest(tier):
                done = subprocess.run([CXLAB, "run", "league/game.yaml", "--tier", tier, "--until", "300", "--set", "expect=[]", "--force", "--out", self.out],
                                      cwd=self.folder, text=True, timeout=250, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
                self.assertEqual(done.returncode, 0, done.stdout)
                self.assertNotIn("gives up", done.stdout)
                records = [json.loads(line) for line in open(self.out / "journal.jsonl") if '"skill":"pick"' in line and '"end"' in line]
                self.assertTrue(records)
                self.assertEqual([r["data"]["code"] for r in records][:1], [0])

    def test_nobody_takes_the_field(self):
        self.league(("clips/peers.clp", '(defrule peers-beacon\n  "Every second: our team is here."\n  (time ?now)', '(defrule peers-beacon\n  "Never."\n  (never) (time ?now)'))
        play = lambda *more: subprocess.run([CXLAB, "run", "league/game.yaml", "--until", "100", "--set", "expect=[]", "--set", "world.setup_s=90", "--out", "none", *more],
                                            cwd=self.folder, text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.STDOUT).stdout
        said = play()
        self.assertEqual(said.count("nobody has taken the field for 60 s"), 1, said)
        self.assertIn("rcll.refbox.team_cyan=NAME", said)
        self.assertNotIn("nobody has taken", play("--set", "world.refbox.team_cyan=Examples"))
