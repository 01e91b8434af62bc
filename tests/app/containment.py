"""A rule file from a stranger: what it cannot do, and how it ends. python3 -m unittest containment"""

import html.parser
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from lab import CONFIG, CXLAB, SCENARIO, Lab

LOOPS = {
    "while": '(while TRUE (format nil "%9999d" 1))',
    "asserts": "(bind ?i 0) (while TRUE (bind ?i (+ ?i 1)) (assert (x ?i)) (retract *))",
    "query": "(assert (x 0)) (do-for-all-facts ((?f x)) TRUE (assert (x (+ (nth$ 1 ?f:implied) 1))))",
    "text": '(bind ?s "") (while TRUE (bind ?s (str-cat ?s "abcdefgh")))',
    "evaluated": '(while TRUE (eval "(+ 1 2)"))',
    "built": '(bind ?i 0) (while TRUE (bind ?i (+ ?i 1)) (build (str-cat "(defrule r" ?i " (a " ?i ") => )")))',
    "printed": '(while TRUE (printout t (format nil "%999d" 1) crlf))',
}


class Memory(Lab):
    def ends(self, actions, *arguments, head="(defrule stranger\n  =>\n  {})\n"):
        self.agent(head.format(actions))
        return self.run_it("--memory", "100MB", *arguments)

    def test_rules_that_take_memory_without_end(self):
        for actions in ("(bind ?i 0) (while TRUE (bind ?i (+ ?i 1)) (assert (x ?i)))", LOOPS["query"],
                        "(bind ?s (create$ a b c d)) (while TRUE (bind ?s (create$ ?s ?s)))",
                        '(bind ?s "abcdefgh") (while TRUE (bind ?s (str-cat ?s ?s)))'):
            done = self.ends(actions, "--force", "--journal", "full", "--steps", "0")
            self.assertEqual(done.returncode, 5, actions)
            self.assertRegex(done.stderr, r"rules.clp:1: environment 'main': rule stranger: (rules hold more than 100 MB of "
                                          r"memory|no memory is left)")
            result = json.loads((self.out / "result.json").read_text())
            self.assertEqual((result["status"], result["reason"]["code"]), ("failed", "resource"))
            self.assertEqual((self.out / "journal.jsonl").read_text().splitlines(keepends=True)[-1][-1], "\n")

    def test_rules_may_go_on_after_errors_but_not_beyond_the_limit(self):
        self.agent("(defrule stranger (go ?n) => (bind ?i 0) (while (< ?i 100000) (bind ?i (+ ?i 1)) (assert (x ?n ?i)))"
                   " (assert (go (+ ?n 1))))\n(deffacts start (go 0))\n", SCENARIO + "on_rule_error: continue\n")
        done = self.run_it("--memory", "100MB")
        self.assertEqual(done.returncode, 5, done.stderr)
        self.assertIn("rule stranger: rules hold more than 100 MB", done.stderr)

    def test_alternatives_that_fill_memory_while_they_are_loaded(self):
        self.agent("(deffacts fine (a))\n(defrule stranger\n  " + "(or (a) (b)) " * 24 + "=>)\n")
        done = self.run_it("--memory", "50MB")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("rules.clp:2: ", done.stderr)
        self.assertIn("16777216", done.stderr)

    def test_a_limit_is_a_size(self):
        self.agent("")
        self.fails(2, "--memory", arguments=["--memory", "much"])
        self.assertEqual(self.run_it("--memory", "0").returncode, 0)


class Signals(Lab):
    def stop(self, number, *arguments, wait_for=b""):
        """The exit code, and the seconds from the signal to the end."""
        process = subprocess.Popen([CXLAB, *map(str, arguments)], cwd=self.folder, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        time.sleep(1)
        self.assertIsNone(process.poll(), "it has ended by itself")
        begin = time.monotonic()
        process.send_signal(number)
        code = process.wait(30)
        self.errors = process.stderr.read().decode()
        return code, time.monotonic() - begin

    def test_each_loop_ends_within_a_second_of_a_signal(self):
        for i, (name, actions) in enumerate(LOOPS.items()):
            self.agent("(deffacts known (before))\n(defrule stranger\n  =>\n  " + actions + ")\n")
            number = (signal.SIGINT, signal.SIGTERM)[i % 2]
            code, seconds = self.stop(number, "run", "scenario.yaml", "--quiet", "--out", self.out, "--force", "--steps", "0")
            self.assertEqual(code, 128 + number, name + self.errors)
            self.assertLess(seconds, 3, name)  # 1 s where nothing else uses the machine
            self.assertIn("rules.clp:2: environment 'main': rule stranger: stopped by a signal", self.errors, name)
            result = json.loads((self.out / "result.json").read_text())
            self.assertEqual((result["status"], result["stream_hashes"]), ("interrupted", {}), name)

    def test_a_stopped_run_has_no_hashes_to_compare(self):
        self.agent("(defrule stranger => " + LOOPS["while"] + ")\n")
        self.stop(signal.SIGINT, "run", "scenario.yaml", "--quiet", "--out", self.out, "--steps", "0")
        done = subprocess.run([CXLAB, "replay", self.out], capture_output=True, text=True)
        self.assertEqual(done.returncode, 3)
        self.assertIn("the run was cut off before its end", done.stderr)

    def test_why_not_looks_at_the_tick_before_a_loop(self):
        self.agent("(defrule stranger => " + LOOPS["printed"] + ")\n")
        self.stop(signal.SIGINT, "run", "scenario.yaml", "--quiet", "--out", self.out, "--steps", "0")
        done = subprocess.run([CXLAB, "why-not", self.out, "stranger"], capture_output=True, text=True, timeout=30)
        self.assertIn("ended before the log of its inputs had the first tick", done.stderr)
        self.agent("(defrule stranger (time ?t&:(> ?t 0.5)) => " + LOOPS["printed"] + ")\n")
        self.stop(signal.SIGINT, "run", "scenario.yaml", "--quiet", "--out", self.out, "--force", "--steps", "0")
        done = subprocess.run([CXLAB, "why-not", self.out, "stranger"], capture_output=True, text=True, timeout=30)
        self.assertIn("condition 1 does not hold", done.stdout)

    def test_stories_end_too(self):
        self.agent("(defrule stranger => " + LOOPS["printed"] + ")\n")
        self.write("loop.story.yaml", "common:\n  rules: rules/rules.clp\nstories:\n  - story: endless\n    expect: [{no_fact: (b), within_s: 1}]\n")
        for arguments in (("test", "loop.story.yaml", "--steps", "0"), ("test", "loop.story.yaml", "--steps", "0", "-j", "2")):
            code, seconds = self.stop(signal.SIGTERM, *arguments)
            self.assertEqual(code, 143, self.errors)
            self.assertLess(seconds, 3, arguments)


ADDS_A_DOMAIN = """(defrule start => (ros-msgs-create-client "/pddl_manager/add_pddl_instance" "cx_pddl_interfaces/srv/AddPddlInstance"))
(defrule add (ros-msgs-client (service ?s))
  => (bind ?q (ros-msgs-create-request "cx_pddl_interfaces/srv/AddPddlInstance"))
  (ros-msgs-set-field ?q "name" "x") (ros-msgs-set-field ?q "directory" %s) (ros-msgs-set-field ?q "domain_file" "%s")
  (ros-msgs-async-send-request ?q ?s) (ros-msgs-destroy-message ?q))
(defrule added (ros-msgs-response (msg-ptr ?r))
  => (printout t "answer: " (ros-msgs-get-field ?r "success") " " (ros-msgs-get-field ?r "error") crlf))
"""


class Escapes(Lab):
    """Files outside of packages and the run's folder."""

    def setUp(self):
        super().setUp()
        self.elsewhere = pathlib.Path(tempfile.mkdtemp(prefix="cxlab-elsewhere-"))
        self.addCleanup(shutil.rmtree, self.elsewhere)

    def file(self, name, text=""):
        (self.elsewhere / name).write_text(text)
        return self.elsewhere / name

    def env(self, rules, *arguments, plugins=""):
        self.agent(rules)
        config = self.write("agent.yaml", CONFIG.replace('"ros_msgs", "files"]', '"ros_msgs", "params", "files"]').replace(
            'pkg_share_dirs: ["rules"], load: ["rules.clp"]', f'load: ["{self.folder}/rules/rules.clp"]') +
            '    params: {plugin: "cx::RosParamPlugin"}\n' + plugins)
        return subprocess.run([CXLAB, "env", config, "--until", "2", "--out", self.out, "--force", *map(str, arguments)],
                              cwd=self.folder, capture_output=True, text=True, timeout=60)

    def everything(self, done):
        return done.stdout + done.stderr + "".join(
            p.read_text(errors="replace") for p in self.out.rglob("*") if p.is_file() and p.name != "rules.clp")

    def test_a_plugin_that_rules_load_reads_what_rules_may_read(self):
        rules = """(deffacts names (name (ros-param-get-value "stolen.plugin" "cx::FileLoadPlugin"))
  (name (ros-param-get-value "stolen.load" (create$ "%s"))))
(defrule start => (ros-msgs-create-client "/clips_manager/load_plugin" "cx_msgs/srv/LoadClipsPlugin"))
(defrule load (ros-msgs-client (service ?s))
  => (bind ?q (ros-msgs-create-request "cx_msgs/srv/LoadClipsPlugin"))
  (ros-msgs-set-field ?q "env_name" "main") (ros-msgs-set-field ?q "plugin_name" "stolen")
  (ros-msgs-async-send-request ?q ?s) (ros-msgs-destroy-message ?q))
(defrule loaded (ros-msgs-response (msg-ptr ?r))
  => (printout t "loaded: " (ros-msgs-get-field ?r "success") " " (ros-msgs-get-field ?r "error") crlf))
""" % self.file("secret.clp", "SECRET")
        done = self.env(rules)
        self.assertIn("is refused: rules read only files of packages, and those that rules of this run wrote", done.stderr)
        self.assertNotIn("SECRET", self.everything(done))
        self.assertIn("SECRET", self.everything(self.env(rules, "--trust-rules")))

    def test_the_pddl_manager_reads_for_rules_what_rules_may_read(self):
        outside = self.file("secret.txt", "SECRET")
        self.write("rules/domain.pddl", '{% include "' + str(outside).lstrip("/") + '" %}')
        os.symlink(outside, self.folder / "rules" / "link.pddl")
        for directory, file in ((outside.parent, "secret.txt"), ("/", str(outside).lstrip("/")), ("", outside),
                                (self.folder / "rules", "link.pddl"), (self.folder / "rules", "domain.pddl")):
            done = self.env(ADDS_A_DOMAIN % (f'"{directory}"', file), "--with", "pddl_manager", "--package", f"rules={self.folder}/rules")
            self.assertIn("answer: FALSE", done.stderr, (directory, file))
            if file != "domain.pddl":
                self.assertIn("is refused: for rules the manager reads", done.stderr, (directory, file))
            self.assertNotIn("SECRET", self.everything(done), (directory, file))

    def test_the_pddl_manager_reads_domains_where_a_rule_file_names_their_folder(self):
        domain = self.file("domain.pddl", "(define (domain far) (:predicates (secret)))")
        self.file("notes.txt", "SECRET")
        computed = f'(str-cat "{str(domain.parent)[:-1]}" "{str(domain.parent)[-1]}")'
        for where, file, answer in ((f'"{domain.parent}"', "domain.pddl", "TRUE"), (f'"{domain.parent}"', "notes.txt", "FALSE"),
                                    (computed, "domain.pddl", "FALSE")):
            with self.subTest(where=where, file=file):
                done = self.env(ADDS_A_DOMAIN % (where, file), "--with", "pddl_manager", "--package", f"rules={self.folder}/rules")
                self.assertIn(f"answer: {answer}", done.stderr)
                self.assertEqual("in a folder that a rule file names" in done.stderr, answer == "FALSE", done.stderr)
                self.assertNotIn("SECRET", self.everything(done))

    def test_copies_are_as_private_as_the_files(self):
        self.agent("(deffacts secret (x))")
        os.chmod(self.folder / "rules" / "rules.clp", 0o600)
        os.chmod(self.folder / "agent.yaml", 0o644)
        self.assertEqual(self.run_it().returncode, 0)
        lines = (self.out / "files" / "index.jsonl").read_text().splitlines()
        files = {line["name"]: line["hash"] for line in map(json.loads, lines)}
        modes = {name.rsplit("/", 1)[1]: (self.out / "files" / file).stat().st_mode & 0o777 for name, file in files.items()
                 if "/" in name}
        self.assertEqual((modes["rules.clp"], modes["agent.yaml"]), (0o600, 0o644))

    def test_a_replay_of_trusted_rules_touches_nothing_outside(self):
        victim = self.file("victim.txt")
        gone = self.file("gone.txt")
        rules = f"""(defrule act =>
  (open "{victim}" f "w") (printout f "by rules" crlf) (close f)
  (open "{victim}" f "r") (printout t "read: " (readline f) crlf) (close f)
  (printout t "removed: " (remove "{gone}") " renamed: " (rename "{gone}" "{gone}2") crlf))
"""
        done = self.env(rules, "--trust-rules")
        self.assertIn("read: by rules", done.stderr)
        self.assertIn("removed: TRUE renamed: FALSE", done.stderr)
        self.assertEqual(victim.read_text(), "by rules\n")
        victim.write_text("mine")
        gone.write_text("mine")
        for command in (["replay", self.out], ["why-not", self.out, "act"]):
            again = subprocess.run([CXLAB, *map(str, command)], capture_output=True, text=True)
            self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
            self.assertEqual((victim.read_text(), gone.read_text()), ("mine", "mine"), command)
        again = subprocess.run([CXLAB, "rerun", str(self.out), "--out", str(self.folder / "again")], capture_output=True, text=True)
        self.assertEqual(again.returncode, 2, again.stdout + again.stderr)
        self.assertIn("cxlab rerun --trust-rules", again.stderr)
        self.assertEqual((victim.read_text(), gone.read_text()), ("mine", "mine"))
        again = subprocess.run([CXLAB, "rerun", str(self.out), "--trust-rules", "--quiet", "--out", str(self.folder / "trusted")],
                               capture_output=True, text=True)
        self.assertEqual(victim.read_text(), "by rules\n", again.stderr)

    def test_a_path_to_what_rules_wrote_means_the_same_in_a_replay(self):
        written = self.out / "written"
        self.agent(f"""(defrule act =>
  (open "a" f "w") (printout f "by rules" crlf) (close f)
  (open "{written}/a" f "r") (assert (read-back (readline f))) (close f)
  (open "{written}/b/c" f "w") (printout f "there" crlf) (close f)
  (open "b/c" f "r") (assert (read-back (readline f))) (close f))
""")
        self.assertEqual(self.run_it().returncode, 0)
        moved = self.folder / "moved"
        self.out.rename(moved)
        again = subprocess.run([CXLAB, "replay", str(moved)], capture_output=True, text=True)
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        self.assertFalse(self.out.exists())


class Functions(Lab):
    def test_a_callback_that_calls_its_own_service_is_a_loop(self):
        self.agent("""(deffunction call-twice ()
  (bind ?request (ros-msgs-create-request "std_srvs/srv/Trigger"))
  (ros-msgs-async-send-request ?request "echo")
  (ros-msgs-async-send-request ?request "echo")
  (ros-msgs-destroy-message ?request))
(deffunction echo-service-callback (?service ?request ?response) (call-twice))
(defrule start => (ros-msgs-create-service "echo" "std_srvs/srv/Trigger")
  (ros-msgs-create-client "echo" "std_srvs/srv/Trigger"))
(defrule first (ros-msgs-client (service "echo")) => (call-twice))
(defrule answered ?answer <- (ros-msgs-response (msg-ptr ?message)) => (ros-msgs-destroy-message ?message)
  (retract ?answer))
""", SCENARIO + "max_firings_per_tick: 1000\n")
        done = self.run_it()
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("environment 'main': 1024 callbacks were called in one tick; if they are right, allow more with "
                      "max_firings_per_tick (now 1000, 0 = no limit)", done.stderr)

    def test_names_and_texts_are_text_in_the_page(self):
        hostile = "<img src=x onerror=alert(1)>'\""
        self.write("rules.clp", f"""(defrule stranger => (printout t "{hostile[:-1]}" crlf) (assert-string "(a")
  (printout error "<script>alert(2)</script>" crlf))""")
        quoted = json.dumps(hostile)
        self.write("agent.yaml", f"""/**:
  ros__parameters:
    environments: [{quoted}]
    {quoted}: {{plugins: ["files"]}}
    files: {{plugin: "cx::FileLoadPlugin", load: ["{self.folder}/rules.clp"]}}
""")
        self.write("<b>scenario'.yaml", "schema: 1\nduration_s: 1\nagents: [{config: agent.yaml}]\n")
        done = subprocess.run([CXLAB, "run", "<b>scenario'.yaml", "--quiet", "--out", self.out], cwd=self.folder,
                              capture_output=True, text=True)
        self.assertIn(done.returncode, (0, 4), done.stderr)
        tags = []
        parser = html.parser.HTMLParser()
        parser.handle_starttag = lambda tag, attributes: tags.append((tag, dict(attributes)))
        page = (self.out / "index.html").read_text()
        parser.feed(page)
        self.assertIn("onerror", page)
        own = ({"type": "text/plain", "id": "run-data"}, {"type": "text/plain", "id": "three-js"}, {"type": "module"})
        self.assertEqual([tag[1] for tag in tags if tag[0] == "script"], list(own))
        self.assertFalse([tag for tag in tags if tag[0] == "b" or "onerror" in tag[1] or tag[1].get("src") == "x"])

    def test_a_stream_that_is_closed_is_no_file_of_the_run(self):
        self.agent('(defrule hello => (printout error "hello" crlf))')
        for streams in ("2>&-", ">&- 2>&-", "<&- >&- 2>&-"):
            code = subprocess.run(["sh", "-c", f'"$0" run scenario.yaml --out out --force {streams}', CXLAB],
                                  cwd=self.folder, timeout=60, stdout=subprocess.DEVNULL).returncode
            self.assertIn(code, (0, 5), streams)
            for file in self.out.rglob("*"):
                if file.is_file() and file.suffix != ".log":
                    self.assertNotIn("[error]", file.read_text(errors="replace"), file)

    def test_nothing_of_the_machine_is_seen(self):
        self.agent('(defrule stranger => (printout t (read) (readline) crlf) (watch statistics) (profile constructs))')
        done = subprocess.run([CXLAB, "run", "scenario.yaml", "--out", self.out, "--set", "on_rule_error=continue"],
                              cwd=self.folder, input="secret\nsecret\n", capture_output=True, text=True)
        self.assertNotIn("secret", done.stderr)
        self.assertIn("EOFEOF", done.stderr)


if __name__ == "__main__":
    unittest.main()
