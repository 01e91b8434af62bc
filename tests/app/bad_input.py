"""Bad input: exit code, place and remedy. python3 -m unittest bad_input"""

import json
import os
import resource
import shutil
import subprocess
import unittest

from lab import CONFIG, CXLAB, GAME, SCENARIO, SOURCE, Lab

HEAD = "(deftemplate pose (slot x))\n(deffacts start (go))\n"
STIMULI = SCENARIO + "stimuli:\n"


class Scenarios(Lab):
    def scenario_fails(self, text, *messages, arguments=(), **options):
        self.agent("")
        self.write("scenario.yaml", text)
        return self.fails(3, *messages, arguments=arguments, **options)

    def test_misspelt_keys(self):
        self.scenario_fails(SCENARIO.replace("duration_s", "duraton_s"),
                            "scenario.yaml:2: unknown key 'duraton_s', did you mean 'duration_s'?")
        self.scenario_fails(GAME.replace("production_s", "producton_s"),
                            "scenario.yaml:2: unknown key 'producton_s' in 'world', did you mean 'production_s'?")
        self.scenario_fails(SCENARIO.replace("config:", "confg:"), "scenario.yaml:5: agents[0]: key 'config' is missing")

    def test_values(self):
        self.scenario_fails(SCENARIO.replace(": 2", ": two"), "scenario.yaml:2: duration_s: found 'two', expected a number")
        self.scenario_fails("schema: 1\nagents: [\n", "scenario.yaml:3: not YAML")
        self.scenario_fails(GAME.replace("production_s: 20", "\n  robots: 7"),
                            "scenario.yaml:3: world.robots: found 7, expected 0 to 3")

    def test_machine_that_does_not_exist(self):
        self.scenario_fails(GAME.replace("production_s: 20", "layout: [{machine: C-XS, zone: C_Z23}]"),
                            "scenario.yaml:2: world.layout[0].machine: no machine 'C-XS', did you mean 'C-BS'?")

    def test_a_node_of_a_name_that_is_there(self):
        self.scenario_fails(GAME + "servers:\n  - pddl_manager\n  - {node: pddl_manager, namespace: /}\n",
                            "scenario.yaml:6: found a second node '/pddl_manager', expected another `name` or `namespace`")

    def test_goals_with_a_machine_that_does_not_exist_are_aborted(self):
        self.write("scenario.yaml", GAME + """stimuli:
  - {at: 1, send_goal: /robot1/drive_to, type: cxlab_skills/action/DriveTo, goal: {target: C-XS-OUTPUT}}
  - {at: 1, send_goal: /factory/instruct_machine, type: rcll_interfaces/action/InstructMachine, goal: {machine: C-XS}}
""")
        self.assertEqual(self.run_it("--journal", "full").returncode, 0)
        results = {r["stream"]: r["data"]["result"] for r in self.records() if r["data"].get("op") == "result"}
        self.assertEqual(results["node/robot1"]["error_code"], 103)
        self.assertIn("did you mean 'C-BS-OUTPUT'?", results["node/robot1"]["error"])
        self.assertEqual(results["node/factory"]["error_code"], 203)

    def test_overrides(self):
        self.scenario_fails(GAME, "unknown key 'tem' in 'world', did you mean 'team'?", arguments=["--set", "world.tem=CYAN"])
        self.agent("", GAME)
        self.fails(2, "--set team: expected PATH=VALUE", arguments=["--set", "team"])
        self.scenario_fails(GAME, "error: --set world.robots=7: world.robots: found 7, expected 0 to 3", arguments=["--set", "world.robots=7"])
        self.scenario_fails(GAME, "error: --set world.layout=[{machin: C-BS}]: world.layout[0]: ", arguments=["--set", "world.layout=[{machin: C-BS}]"])
        self.scenario_fails(GAME.replace("20", "twenty"), "scenario.yaml:2: world.production_s: found 'twenty'", arguments=["--set", "world.robots=2"])
        self.scenario_fails(SCENARIO, "index 3 is beyond the list's 1 items", arguments=["--set", "agents[3].config=x"])

    def test_expectations(self):
        for path, message in (("teams.CYAN.pionts", "did you mean 'points'?"), ("team.CYAN.points", "did you mean 'teams'?"),
                              ("robots[0].skils", "did you mean 'skills'?"), ("robots.skills", "expected an index like robots[0]"),
                              ("teams.RED.points", "known are: CYAN, MAGENTA")):
            self.scenario_fails(GAME + f"expect:\n  - {{path: '{path}', min: 1}}\n", "scenario.yaml:5: expect[0].path: ", message)

    def test_an_empty_world_has_no_tier(self):
        self.agent("")
        self.assertEqual(self.run_it().returncode, 0)
        self.assertEqual(self.result()["tier"], "none")

    def test_missing_files(self):
        self.scenario_fails(SCENARIO.replace("agent.yaml", "agnt.yaml"), "agents[0].config: agnt.yaml: there is no such file")
        self.assertEqual(self.result()["reason"]["code"], "bad_input")
        shutil.rmtree(self.out)
        self.scenario_fails(SCENARIO.replace("rules: rules", "rules: rulez"), "scenario.yaml:3: package rules: there is no folder rulez")
        shutil.rmtree(self.out)
        (self.folder / "rules/rules.clp").unlink()
        self.write("scenario.yaml", SCENARIO)
        self.fails(3, "agent.yaml:7: Cannot resolve file rules.clp: not in")

    def test_stimuli(self):
        self.scenario_fails(STIMULI + "  - {at: 1, publish: /a, type: std_msgs/msg/Strin}\n",
                            "scenario.yaml:7: /a: 'std_msgs/msg/Strin' is not defined", "nearest is 'std_msgs/msg/String'")
        shutil.rmtree(self.out)
        self.scenario_fails(STIMULI + "  - {at: 1, publish: /a, type: std_msgs/msg/String, data: {dat: x}}\n",
                            "scenario.yaml:7: /a: std_msgs/msg/String has no field 'dat'; nearest is 'data'")

    def test_plugins(self):
        self.agent("")
        self.write("agent.yaml", CONFIG.replace("FileLoadPlugin", "FileLoadPlugn"))
        self.fails(3, "agent.yaml:7: unknown plugin type 'cx::FileLoadPlugn', did you mean 'cx::FileLoadPlugin'?")
        shutil.rmtree(self.out)
        self.write("agent.yaml", CONFIG.replace("refresh_rate: 10", "refresh_rate: 0"))
        self.fails(3, "agent.yaml:5: parameter 'executive.refresh_rate': found 0")

    def test_parameters_of_a_scenario(self):
        self.agent("", SCENARIO + "    params:\n      clips_manager.executive.refresh_rate: fast\n")
        fault = "parameter 'executive.refresh_rate': found 'fast' (a string), expected an integer"
        self.fails(3, "error: scenario.yaml:7: " + fault)
        shutil.rmtree(self.out)
        setting = "agents[0].params={clips_manager.executive.refresh_rate: fast}"
        self.agent("")
        self.fails(3, f"error: --set {setting}: {fault}", arguments=["--set", setting])

    def test_parameters_that_cx_does_not_know(self):
        self.agent("(defrule go => (printout t \"up\" crlf))")
        self.write("agent.yaml", CONFIG.replace("refresh_rate", "refresh_rat"))
        place = "agent.yaml:5: unknown parameter 'executive.refresh_rat' of plugin 'executive' (cx::ExecutivePlugin), did you mean 'refresh_rate'?"
        self.fails(3, "error: ", place, arguments=["--strict-cx"])
        env = [CXLAB, "env", "agent.yaml", "--package", "rules=rules", "--until", "1", "--out", "none"]
        loose, strict = (subprocess.run(env + more, cwd=self.folder, text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                         for more in ([], ["--strict-cx"]))
        self.assertEqual((loose.returncode, strict.returncode), (0, 3))
        lines = [line for line in loose.stderr.splitlines() if place in line]
        self.assertEqual(len(lines), 1, "one line")
        self.assertIn("[info]", lines[0])
        self.assertIn(place, strict.stderr)

    def test_what_cx_would_do_otherwise(self):
        self.agent("(deffacts start (go))\n(defrule late (time ?t&:(> ?t 1)) => (printout t \"late\" crlf))\n"
                   "(defrule more (go) => (load* (str-cat (ament-index-get-package-share-directory \"rules\") \"/more.clp\")))",
                   SCENARIO, more="(deffunction a-service-callback () TRUE)\n",
                   batch="(assert (lost))\n(ros-msgs-create-action-client \"fly\" \"example_interfaces/action/Fibonacci\")\n")
        self.write("agent.yaml", CONFIG.replace('"ros_msgs", "files"', '"ros_msgs", "ament_index", "files"').replace(
            'load: ["rules.clp"]', 'load: ["rules.clp"], batch: ["batch.clp"]')
            + '    ament_index: {plugin: "cx::AmentIndexPlugin"}\n')
        self.assertEqual(self.run_it(out=False).returncode, 0)
        shutil.rmtree(self.folder / "runs", ignore_errors=True)
        done = self.fails(3, "rules.clp:2: strict-cx: time: (> ?t 1) needs simulated time", "strict-cx: reset: the fact (lost)",
                          "more.clp:1: strict-cx: callback: 'a-service-callback' takes ()", arguments=["--strict-cx", "--release", "jazzy"])
        self.assertEqual(json.loads((self.out / "manifest.json").read_text())["release"], "jazzy")
        self.assertEqual(self.result()["sim_time_s"], 2, done.stderr)
        self.assertIn("--release: found 'foxy', expected one of: humble, jazzy, kilted", self.fails(2, arguments=["--release", "foxy"]).stderr)

    def test_what_cx_would_do_otherwise_in_the_run(self):
        self.agent("""(defrule go => (bind ?m (ros-msgs-create-message "geometry_msgs/msg/Point"))
  (ros-msgs-create-publisher "p" "geometry_msgs/msg/Point") (assert (made ?m)))
(defrule float (made ?m) => (ros-msgs-set-field ?m "x" 3))""")
        self.assertEqual(self.run_it(out=False).returncode, 0)
        env = [CXLAB, "env", "agent.yaml", "--package", "rules=rules", "--until", "1", "--out", "none", "--strict-cx"]
        done = subprocess.run(env, cwd=self.folder, text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 3, done.stderr)
        for text in ("strict-cx: leak: ros_msgs: Found 1 message(s), cleaning up ...", "strict-cx: leak: ros_msgs: Environment main has open p publisher",
                     "expected a FLOAT: CX converts no INTEGER (--strict-cx)"):
            self.assertIn(text, done.stderr)
        self.agent("""(defrule go => (bind ?m (ros-msgs-create-message "std_msgs/msg/Int32"))
  (ros-msgs-set-field ?m "data" 3.0) (ros-msgs-destroy-message ?m))""")
        done = subprocess.run(env, cwd=self.folder, text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("rules.clp:2: strict-cx: error: ", done.stderr)
        self.assertIn("expected an INTEGER: CX converts no FLOAT", done.stderr)

    def test_usage(self):
        self.agent("")
        self.fails(2, "--frob", arguments=["--frob"])
        self.fails(2, "--journal: found 'some', expected one of: none, decisions, full", arguments=["--journal", "some"])
        self.fails(2, "error: --seed: found '-1', expected a whole number from 0", "cxlab run --help", arguments=["--seed", "-1"])
        self.fails(2, "error: --until: found '-3', expected a time: s from 0 to 1e9", arguments=["--until", "-3"])
        for swapped, meant in (("rnu", "run"), ("evn", "env")):
            done = subprocess.run([CXLAB, swapped], text=True, stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 2)
            self.assertIn(f"there is no command '{swapped}', did you mean '{meant}'?", done.stderr)

    def test_an_option_of_two_names_is_named_with_both(self):
        for command, said in (("bench -j x s.yaml", "-j, --jobs: found 'x', expected"), ("bench --jobs 0 s.yaml", "-j, --jobs: found '0', expected"),
                              ("test -j", "-j, --jobs: its value is missing"), ("test -j 1 --jobs 2", "-j, --jobs: given 2 times, expected once"),
                              ("bench page --jobs 2 s", "-j, --jobs requires --"), ("attach run --command=", "-c, --command: its value is missing"),
                              ("env a.yaml --plugin-path=", "--prefix, --plugin-path: its value is missing"), ("bench --verbose=x s.yaml", "-v, --verbose: takes no value")):
            with self.subTest(command):
                done = subprocess.run([CXLAB, *command.split()], text=True, capture_output=True, timeout=60)
                self.assertEqual(done.returncode, 2)
                self.assertIn("error: " + said, done.stderr)

    def test_pictures_that_cannot_be(self):
        self.agent("", GAME)
        for text, message in (("every:0", "found 'every:0', expected every:SECONDS"), ("1,,2", "found '1,,2'"), ("1,21", "no picture at 21 s: the run ends at 20 s")):
            done = self.fails(2, "error: --snapshot: ", message, arguments=["--snapshot", text])
            self.assertEqual(done.stdout, "")
            self.assertFalse(self.out.exists(), "nothing is written")
        self.fails(2, "no picture at 6 s: the run ends at 5 s", arguments=["--snapshot", "6", "--until", "5"])

    def test_remaps_of_names_that_ros_refuses(self):
        self.agent("")
        for remap, message in (("a b:=c", "the name 'a b' has a ' '"), ("a:=b//c", "the name 'b//c' has an empty part"), ("__node:=/a", "the name '/a' has more than")):
            done = subprocess.run([CXLAB, "env", "agent.yaml", "--remap", remap, "--out", "none"], cwd=self.folder, text=True, stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 2)
            self.assertIn(f"error: --remap {remap}: {message}", done.stderr)
        self.scenario_fails(SCENARIO + "    remap: {a: b, c: d e}\n", "scenario.yaml:6: agents[0].remap.c: the name 'd e' has a ' '")

    def test_a_package_option_without_its_folder(self):
        self.agent("")
        done = subprocess.run([CXLAB, "env", "agent.yaml", "--package", "a=nowhere", "--out", "none"], cwd=self.folder, text=True, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 3)
        self.assertIn("--package a=nowhere: there is no folder nowhere", done.stderr)

    def test_a_package_that_nobody_named_is_reported_with_its_option(self):
        self.agent("")
        remedy = "Cannot resolve file rules.clp: package 'rules' not found; say where it is: packages: {rules: DIR} in the scenario or story, or --package rules=DIR of cxlab env, check, test and mutate"
        self.scenario_fails(SCENARIO.replace("packages: {rules: rules}\n", ""), "agent.yaml:7: " + remedy)
        for command in ("env", "check", "test", "mutate"):
            self.assertIn("--package TEXT", subprocess.run([CXLAB, command, "--help"], text=True, stdout=subprocess.PIPE).stdout)

    def test_a_configuration_of_another_copy_of_its_package_is_a_warning(self):
        shutil.copytree(SOURCE / "scenarios/rcll/agent", self.folder / "copy")
        packages = f"agents[0].packages={{rcll_agent: {self.folder}/copy}}"
        for config, warned in (("agent/params/agent.yaml", True), (f"{self.folder}/copy/params/agent.yaml", False)):
            self.assertEqual(0, subprocess.run([CXLAB, "run", SOURCE / "scenarios/rcll/game.yaml", "--tier", "timed", "--until", "1", "--force", "--quiet", "--out", self.folder / "out",
                                               "--set", packages, "--set", f"agents[0].config={config}"], capture_output=True).returncode)
            warnings = json.loads((self.folder / "out/result.json").read_text())["warnings"]
            self.assertEqual(["config is " + config in one and "set config, too" in one for one in warnings], [True] * warned)

    def test_a_configuration_of_cx_is_not_a_scenario(self):
        self.write("scenario.yaml", CONFIG)
        done = self.run_it()
        self.assertEqual(done.returncode, 3)
        self.assertIn("cxlab env runs it", done.stderr)

    def test_an_empty_file_of_stimuli_has_none(self):
        self.agent("")
        for text in ("", "# none yet\n", "[]\n"):
            self.write("stimuli.yaml", text)
            done = subprocess.run([CXLAB, "env", "agent.yaml", "--package", "rules=rules", "--stimuli", "stimuli.yaml", "--until", "1", "--out", "none"],
                                  cwd=self.folder, text=True, stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 0, done.stderr)

    def test_turtlesim_has_no_timed_tier(self):
        self.scenario_fails("schema: 1\nworld: {kind: turtlesim}\ntier: timed\n", "scenario.yaml:3: tier: found 'timed', expected physics")


class Rules(Lab):
    """The rule files begin with two fine lines."""

    def rule_fails(self, code, text, place, *messages, scenario=SCENARIO, side=None, rule=None, **files):
        self.agent(HEAD + text, scenario, **files)
        shutil.rmtree(self.out, ignore_errors=True)
        self.fails(code, f"{place}: ", *messages)
        result = self.result()
        self.assertEqual(result["status"], "failed")
        file, line = place.split(":")
        for entry in [result["reason"], result["rule_errors"][0]]:
            self.assertTrue(entry["file"].endswith("/" + file), entry)
            self.assertEqual(entry["line"], int(line))
        error = result["rule_errors"][0]
        self.assertEqual(error["side"], side or error["side"])
        if rule:
            self.assertEqual(error["rule"], rule)
        return error

    def test_load(self):
        self.rule_fails(3, "(defrule a\n (go)\n =>\n (println 1)\n(defrule b (go) => )\n", "rules.clp:3",
                        "no closing parenthesis for (defrule a ...)", side="load")
        self.rule_fails(3, "(defrule a\n (pose (z 1))\n =>)\n", "rules.clp:4", "Invalid slot 'z'", side="load")
        self.rule_fails(3, "(defrule a\n (go)\n =>\n (frobnicate 1))\n", "rules.clp:6", "'frobnicate'", side="load")
        self.rule_fails(3, '(defrule a\n (go)\n (test (ros-msgs-create-message "std_msgs/msg/Empty"))\n =>)\n', "rules.clp:5",
                        "rule 'a' calls 'ros-msgs-create-message' on its left-hand side", side="load")

    def test_division_by_zero(self):
        error = self.rule_fails(4, "(defrule a\n (go)\n =>\n (bind ?x\n  (/ 1 0)))\n", "rules.clp:7", "rule a, RHS", side="RHS", rule="a")
        self.assertEqual(error["tick"], 0)
        error = self.rule_fails(4, """(defrule late (time ?t&:(> ?t 0.45)) => (assert (n 0)))
(defrule a
  (n ?x)
  (test (> (/ 1 ?x) 2))
  =>)
""", "rules.clp:6", "rule a, LHS", side="LHS", rule="a")
        self.assertEqual(error["tick"], 25, "0.5 s of ticks of 20 ms")

    def test_what_comes_first_is_shown_first(self):
        self.agent("(defrule first (time ?t&:(> (/ 1 0) 2)) =>)\n(defrule second (time ?t) => (div 1 0))")
        said = self.fails(4, "rules.clp:1: rule first, LHS: ", "rules.clp:2: rule second, RHS: ").stderr
        self.assertLess(said.index("rule first"), said.index("rule second"))
        self.assertEqual(said.count("rule first"), 1)

    def test_what_a_function_of_a_plugin_reports_is_shown_before_what_comes_of_it(self):
        self.agent('(defrule r (time ?t) => (load* (str-cat (ament-index-get-package-share-directory "nowhere") "/x.clp")) (div 1 0))')
        self.write("agent.yaml", CONFIG.replace('"files"]', '"index", "files"]') + '    index: {plugin: "cx::AmentIndexPlugin"}\n')
        said = self.fails(4, "package 'nowhere' not found; say where it is", "divide by zero").stderr
        self.assertLess(said.index("nowhere"), said.index("divide by zero"))

    def test_in_a_deffunction_the_rule_and_its_call_are_reported(self):
        self.rule_fails(4, "(deffunction f (?x)\n  (/ 1 ?x))\n(deffunction g (?x) (f ?x))\n(defrule a\n (go)\n =>\n (g 0))\n",
                        "rules.clp:9", side="RHS", rule="a")

    def test_in_a_service_callback(self):
        error = self.rule_fails(4, """(deffunction /door-service-callback (?service ?request ?response)
  (bind ?x 1)
  (/ 1 0))
(defrule open (go) => (ros-msgs-create-service "/door" "std_srvs/srv/SetBool"))
""", "rules.clp:5", scenario=STIMULI + "  - {at: 1.0, call: /door, type: std_srvs/srv/SetBool}\n",
                                side="callback", rule="/door-service-callback")
        self.assertEqual(error["tick"], 50)

    def test_in_batch_files(self):
        config = CONFIG.replace('["executive"', '["executive", "ament"') + '    ament: {plugin: "cx::AmentIndexPlugin"}\n'
        load = '(defrule a\n (go)\n =>\n (batch* (str-cat (ament-index-get-package-share-directory "rules") "/more.clp")))\n'
        for code, more, place in [(3, "(bind ?q 1)\n(bind ?x\n (/ 1 0))\n", "more.clp:2"),
                                  (3, "(deffacts x (y))\n(defrule x\n (pose (z 1))\n =>)\n", "more.clp:3"),
                                  (3, "(deffacts x (y))\n\n(defrule x\n (go)\n =>\n", "more.clp:3"),
                                  (4, None, "rules.clp:6")]:
            with self.subTest(more=more):
                self.agent(HEAD + load)
                self.write("agent.yaml", config)
                (self.write("rules/more.clp", more) if more else (self.folder / "rules/more.clp").unlink())
                shutil.rmtree(self.out, ignore_errors=True)
                self.fails(code, f"rules/{place}: ")

    def test_reading_elsewhere_is_refused_with_the_rule_and_the_remedy(self):
        self.rule_fails(4, '(defrule a\n (go)\n =>\n (batch* "/etc/hostname"))\n', "rules.clp:6", "is refused", "trust_rules: true")

    def test_messages(self):
        self.rule_fails(4, '(defrule a\n (go)\n =>\n (ros-msgs-create-message "std_msgs/msg/Strin"))\n', "rules.clp:6",
                        "nearest is 'std_msgs/msg/String'")
        self.rule_fails(4, '(defrule a (go)\n =>\n (bind ?m (ros-msgs-create-message "std_msgs/msg/String"))\n'
                        ' (ros-msgs-set-field ?m "dat" "x"))\n', "rules.clp:6", "did you mean 'data'?")

    def test_loop(self):
        self.agent("(deffacts n (n 0))\n(defrule grow ?f <- (n ?n) => (retract ?f) (assert (n (+ 1 ?n))))\n",
                   SCENARIO + "max_firings_per_tick: 1000\n")
        self.fails(4, "rules.clp:2: environment 'main'", "grow (", "rules.clp:2)", "n (", "max_firings_per_tick (now 1000, 0 = no limit)")
        self.assertEqual(self.result()["reason"]["code"], "rule_loop")

    def test_loop_inside_an_action(self):
        self.agent("(deffacts n (n 0))\n(defrule turn (n ?) =>\n  (while TRUE do (bind ?x 1)))\n")
        self.fails(4, "rule turn, RHS", "Still looping")

    def test_recursion_without_end(self):
        self.agent("(deffacts n (n 0))\n(deffunction f (?x) (f (+ ?x 1)))\n(defrule fall (n ?x) => (f ?x))\n")
        self.fails(4, "rules.clp:3: rule fall, RHS", "Function 'f' is called again and again from within itself")
        self.assertEqual(self.result()["reason"]["line"], 3)

    def test_handlers_that_send_without_end(self):
        self.agent("(defclass A (is-a USER))\n(defmessage-handler A f () (send ?self f))\n(deffacts n (n 0))\n"
                   "(defrule fall (n ?x) => (send (make-instance a of A) f))\n")
        self.fails(4, "rules.clp:4: rule fall, RHS", "Function 'send' is called again and again from within itself")

    def test_continue_goes_on_and_reports(self):
        self.agent(HEAD + "(defrule a (go) => (/ 1 0))\n(defrule b (declare (salience -1)) (go) => (println goes on))\n",
                   SCENARIO + "on_rule_error: continue\n")
        done = self.run_it()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("rules.clp:3: rule a, RHS: ", (self.out / "logs/main.log").read_text())
        self.assertEqual(self.result()["status"], "completed")
        self.assertEqual([(e["rule"], e["line"]) for e in self.result()["rule_errors"]], [("a", 3)])
        self.assertEqual([r["data"]["file"] for r in self.records() if r["kind"] == "error"], ["rules/rules.clp"],
                         "the journal names files from their package")


class Models(Lab):
    def test_wrong_mjcf(self):
        share = self.folder / "share"
        shutil.copytree(SOURCE / "models", share / "models")
        (share / "interfaces").symlink_to(SOURCE / "cx/interfaces")
        self.write("scenario.yaml", GAME.replace("timed", "physics"))
        robot = share / "models/robot.xml"
        good = robot.read_text()
        for find, put in [("<geom", "<gem"), ("</", "</x")]:
            lines = good[:good.index(find)].count("\n") + 1
            robot.write_text(good.replace(find, put, 1))
            done = self.fails(3, "robot.xml:", arguments=["--force"], env={**os.environ, "CXLAB_SHARE": str(share)})
            line = int(done.stderr.split("robot.xml:")[1].split(":")[0])
            self.assertLessEqual(line, lines, "where the element begins, or where it went wrong")
            self.assertGreater(line, 0)
        robot.unlink()
        self.fails(3, "robot.xml: no such model part", arguments=["--force"], env={**os.environ, "CXLAB_SHARE": str(share)})


class Output(Lab):
    def test_folder_in_use(self):
        self.agent("")
        self.write("out/mine.txt", "mine")
        self.fails(2, "the output folder is not empty", "--force")
        self.assertEqual(self.run_it("--force").returncode, 0)
        self.assertEqual((self.out / "mine.txt").read_text(), "mine")

    def test_what_cannot_begin_leaves_the_former_run(self):
        self.agent("")
        self.assertEqual(self.run_it().returncode, 0)
        former = {file: file.read_bytes() for file in self.out.rglob("*") if file.is_file()}
        for code, *arguments in ((3, "--set", "agents[0].config=missing.yaml"),
                                 (2, "--tier", "fast"), (5, "--snapshot", "0"), (5, "--video", str(self.folder / "x.mp4")),
                                 (2, "--snapshot", "99999")):
            done = self.run_it("--force", *arguments)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertEqual({file: file.read_bytes() for file in self.out.rglob("*") if file.is_file()}, former, arguments)

    def test_full_disk(self):
        self.agent('(defrule t (time ?t) => (println "time " ?t))', SCENARIO.replace(": 2", ": 2000"))
        for limit in [6000, 100000]:
            with self.subTest(limit=limit):
                shutil.rmtree(self.out, ignore_errors=True)
                done = self.fails(
                    5, "File too large", arguments=["--journal", "full"],
                    preexec_fn=lambda limit=limit: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
                self.assertEqual((self.result()["status"], self.result()["reason"]["code"]), ("failed", "resource"))
                self.assertTrue(os.path.exists(done.stdout.splitlines()[-1].removeprefix("file://")), "the page, or the folder where there is none")
                self.assertGreater(len(self.records()), 5)
                self.assertTrue((self.out / "logs/main.log").read_text().endswith("\n"))


if __name__ == "__main__":
    unittest.main()
