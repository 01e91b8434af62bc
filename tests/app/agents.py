"""Agents of the CLIPS-Executive as `cxlab env` runs them: what they see, and the errors for wrong ones."""

import subprocess
import unittest

from lab import CONFIG, CXLAB, Lab

AGENT = CONFIG.replace("/**", "clips_manager")


class Env(Lab):
    def env(self, rules, *arguments, config=AGENT, configs=("agent.yaml",), code=0):
        """Runs the agent for a second; its log."""
        self.write("agent.yaml", config)
        self.write("rules/rules.clp", rules)
        done = subprocess.run([CXLAB, "env", *configs, "--package", "rules=rules", "--until", "1", "--out", "out", "--force", *arguments],
                              cwd=self.folder, text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr


class Agents(Env):
    def test_two_that_are_called_the_same_have_logs_and_streams_of_their_own(self):
        log = self.env("""(defrule speak (time ?t&:(< ?t 0.05)) => (printout t "id " (ros-param-get-value id 0) crlf))""",
                       config=AGENT.replace('"ros_msgs", "files"]', '"ros_param", "files"]').replace("ros_msgs:", "ros_param:").replace("RosMsgs", "RosParam"),
                       configs=("agent.yaml", "agent.yaml"))
        for name, logger in ("main", "clips_manager/main"), ("main-2", "clips_manager-2/main"):
            self.assertIn(f"[{logger}] id 0\n", log)
            self.assertEqual((self.out / f"logs/{name}.log").read_text(), f"[0.000] [{logger}] [info] id 0\n")
        self.assertEqual({"env/main", "env/main-2"}, {r["stream"] for r in self.records() if r["stream"].startswith("env/")})
        replayed = subprocess.run([CXLAB, "replay", "out"], cwd=self.folder, text=True, timeout=60, stdout=subprocess.PIPE)
        self.assertEqual((replayed.returncode, replayed.stdout), (0, "rules: the same up to 1.000 s: env/main env/main-2\n"))

    def test_a_complaint_on_a_left_hand_side_names_the_rule(self):
        log = self.env("""(defrule test-it
  (thing ?x)
  (test (eq (ros-msgs-get-field ?x "nope") 1))
  =>)
(defrule go (time ?t&:(< ?t 0.05)) => (assert (thing (ros-msgs-create-message "std_msgs/msg/String"))))
""")
        self.assertIn("rules.clp:3: rule test-it, LHS: [CXLAB1] Function 'ros-msgs-get-field': std_msgs/msg/String has no field 'nope'", log)
        self.assertNotIn("rule go, RHS", log)


class Packages(Env):
    def test_those_beside_the_configuration_are_found_in_each_layout_of_a_workspace(self):
        # The last has no package.xml, as a build folder of our CMake.
        for layout in ("ws/src/{0}", "ws/merged/share/{0}", "ws/install/{0}/share/{0}", "build/share/{0}"):
            with self.subTest(layout):
                for name, files in (("my_agent", {"params/a.yaml": AGENT.replace('["rules"]', '["my_agent"]').replace("rules.clp", "clips/rules.clp"),
                                                  "clips/rules.clp": '(defrule tell => (println "sum " (ros-msgs-get-field (ros-msgs-create-message "my_msgs/msg/Sum") "sum")))'}),
                                    ("my_msgs", {"msg/Sum.msg": "int32 sum 7\n"})):
                    if layout.startswith("ws"):
                        self.write(f"{layout.format(name)}/package.xml", f'<package format="3"><name>{name}</name></package>')
                    for file, text in files.items():
                        self.write(f"{layout.format(name)}/{file}", text)
                done = subprocess.run([CXLAB, "env", f"{layout.format('my_agent')}/params/a.yaml", "--until", "0", "--out", "none"], cwd=self.folder, text=True,
                                      timeout=60, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn("[main] sum 7", done.stderr)


    def test_one_of_rules_alone_is_found_below_a_prefix(self):
        self.write("agent/a.yaml", AGENT.replace("rules.clp", "clips/rules.clp"))
        self.write("prefix/share/rules/clips/rules.clp", "(defrule tell => (println there))")
        done = subprocess.run([CXLAB, "env", "agent/a.yaml", "--prefix", "prefix", "--until", "0", "--out", "none"], cwd=self.folder, text=True, timeout=60,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("[main] there", done.stderr)


class WrongInput(Env):
    def test_messages_of_clips_are_reported_whole(self):
        log = self.env("(defrule a => (println ?*x*))\n(defrule b (n ?x&:(numberp ?x)) => (str-length (length$ ?x)))\n"
                       "(deftemplate t (slot e (type EXTERNAL-ADDRESS)))\n(defrule c (t (e ?e)) => (str-cat ?e))\n", code=3)
        self.assertIn("rules.clp:1: [GLOBLPSR1] Global variable ?*x* was referenced, but is not defined.", log)
        self.assertIn("rules.clp:4: [RULECSTR3] Previous variable bindings of ?e caused the type restrictions "
                      "for argument #1 of the expression (str-cat ?e) found in the rule's RHS to be violated.", log)

    def test_options_are_blamed_by_their_names(self):
        for option, value, code, text in (
                ("--param", "clips_mngr.x=1", 2, "--param: found 'clips_mngr.x=1', expected NODE.NAME=VALUE with one of the nodes clips_manager"),
                ("--param", "turtlesim.backgrund_r=1", 3, "--param turtlesim.backgrund_r=1: unknown key 'backgrund_r'"),
                ("--param", "clips_manager.main.watch=[fact]", 3, "--param clips_manager.main.watch=[fact]: Unknown watch item: fact"),
                ("--namespace", "a b", 2, "--namespace: the name 'a b' does not begin with '/'; expected an absolute name like /cyan"),
                ("--namespace", "/a//b", 2, "--namespace: the name '/a//b' has an empty part"),
                ("--package", "more=/nowhere", 3, "--package more=/nowhere: there is no folder /nowhere")):
            with self.subTest(option + ' ' + value):
                more = ["--with", "turtlesim"] if "turtlesim" in value else []
                self.assertIn("error: " + text, self.env("", option, value, *more, code=code))
        self.assertIn("--until: found 'soon', expected a time: s from 0 to 1e9",
                      subprocess.run([CXLAB, "env", "agent.yaml", "--until", "soon"], cwd=self.folder, text=True, stderr=subprocess.PIPE).stderr)
        self.assertIn("error: rules: is a folder, expected a configuration", self.env("", configs=("rules",), code=3))

    def test_empty_environments_are_reported(self):
        log = self.env("", config=AGENT.replace('["main"]', '["mian"]'))
        self.assertIn("agent.yaml:3: environment 'mian': no parameter 'mian.plugins', nothing is loaded into it, did you mean 'main'?", log)
        log = self.env("", config=AGENT.replace('environments: ["main"]', 'envs: ["main"]'))
        self.assertIn("agent.yaml: no parameter 'environments': nothing runs until create_env is called", log)


if __name__ == "__main__":
    unittest.main()
