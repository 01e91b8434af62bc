"""cxlab attach: a person stops a run, looks at it, changes it, and the run replays with what was done."""

import json
import os
import pathlib
import pty
import re
import select
import signal
import socket
import stat
import subprocess
import time

from lab import CXLAB, Lab

RULES = """(deftemplate order (slot id (type INTEGER)) (slot state (default new)))
(defglobal ?*count* = 0)
(deffacts start (order (id 1)) (order (id 2)))
(defrule begin ?o <- (order (state new)) => (bind ?*count* (+ ?*count* 1)) (modify ?o (state begun)))
(defrule finish (declare (salience -5)) ?o <- (order (state begun)) => (modify ?o (state done)))
(defrule seen (extra ?x) => (printout t "extra " ?x crlf))
(defrule never (order (id 99)) => (printout t "never" crlf))
"""
SCENARIO = """schema: 1
duration_s: 5
packages: {rules: rules}
agents:
  - config: agent.yaml
"""


class Attach(Lab):
    def begin(self, *arguments, stopped=True, rules=RULES, scenario=SCENARIO):
        """Plays the scenario in the background, and waits until one can attach."""
        self.agent(rules, scenario)
        self.log = open(self.folder / "log", "w+")
        self.addCleanup(self.log.close)
        self.run_ = subprocess.Popen([CXLAB, "run", "scenario.yaml", "--out", self.out, "--journal", "full", *(["--break"] if stopped else []),
                                      *map(str, arguments)], cwd=self.folder, stdin=subprocess.DEVNULL,
                                     stdout=subprocess.DEVNULL, stderr=self.log)
        self.addCleanup(self.run_.wait)
        self.addCleanup(self.run_.kill)
        end = time.monotonic() + 20
        while "control: " not in self.said():
            self.assertLess(time.monotonic(), end, self.said())
            self.assertIsNone(self.run_.poll(), self.said())
            time.sleep(0.01)

    def said(self):
        return (self.folder / "log").read_text()

    def attach(self, *commands, where=None, code=0, stdin="", arguments=("--quiet",)):
        """Carries them out, and returns what was printed."""
        of_commands = [word for command in commands for word in ("-c", command)]
        done = subprocess.run([CXLAB, "attach", where or self.out, *arguments, *of_commands], cwd=self.folder, text=True,
                              input=stdin, timeout=30, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout if code == 0 else done.stderr

    def event(self, lines, kind):
        """The text of the next event of that kind."""
        while (event := json.loads(lines.readline()))["event"] != kind:
            self.assertIn(event["event"], ("hello", "stopped", "log"))
        return event["text"]

    def end(self):
        """Lets the run go on to its end."""
        self.attach("continue")
        self.assertEqual(self.run_.wait(20), 0, self.said())

    def fired(self):
        return [record["data"]["rule"] for record in self.records() if record["kind"] == "fire"]

    def test_short_looks(self):
        self.begin()
        self.assertRegex(self.attach("where"), r"^main at 0\.000 s, before rule begin fires for f-2\n$")
        self.assertRegex(self.attach("envs"), r"main  \d+ facts, 2 on the agenda")
        self.assertRegex(self.attach("facts order"), r"f-\d+  \(order \(id 1\) \(state new\)\)\nf-\d+  \(order \(id 2\)")
        self.assertRegex(self.attach("facts (order (id 2))"), r"^f-\d+  \(order \(id 2\) \(state new\)\)\n$")
        self.assertEqual(self.attach("facts (order (id 7))"), "none\n")
        self.assertRegex(self.attach("agenda"), r"^0  begin: f-\d+\n0  begin: f-\d+\n$")
        self.assertRegex(self.attach("rules"), r"begin  .*rules\.clp:4\n")
        self.assertIn("(defrule begin", self.attach("rules begin"))
        self.assertIn("?*count* = 0", self.attach("globals"))
        self.assertIn("condition 1 does not hold", self.attach("why-not never"))
        self.assertIn("until T|RULE|PATTERN", self.attach("help until"))
        self.assertRegex(self.attach("why (order (id 2))"), r"^f-\d+  \(order \(id 2\) \(state new\)\)  asserted at 0.000 s, by the start of the environment\n$")
        self.assertRegex(self.attach("changes (order (id 2))"), r"\n +0.000 s  asserted  by the start of the environment\n$")
        self.assertEqual(self.attach("firings begin"), "none\n")
        self.end()
        self.assertEqual([rule for rule in self.fired() if rule != "time-retract"], ["begin", "begin", "finish", "finish"])

    def test_short_steps(self):
        self.begin()
        self.attach("step")
        self.assertIn("?*count* = 1", self.attach("globals"))
        self.attach("step 2")
        self.assertIn("before rule finish", self.attach("where"))
        self.assertEqual(self.attach("firings begin").count("begin"), 2)
        self.assertIn("└─ rule begin", self.attach("why (order (id 1) (state done))"))
        self.assertIn("(state done)", self.attach("facts order"))
        self.attach("until 2.5")
        self.assertIn("at 2.500 s", self.attach("where"))
        self.attach("tick 3")
        self.assertIn("at 2.800 s", self.attach("where"))
        self.assertIn("the run has ended: completed at 5.000 s", self.attach("continue"))
        self.assertEqual(self.run_.wait(20), 0)

    def test_short_a_program_asks_where_the_run_is(self):
        self.begin()
        self.attach("break rule begin", "continue")
        with socket.socket(socket.AF_UNIX) as at:
            at.settimeout(10)
            at.connect(str(self.out / "control.sock"))
            reader = at.makefile("rb")
            self.event(reader, "hello")
            at.sendall(b'{"id": 1, "ask": "where"}\n')
            place = json.loads(reader.readline())["answer"]
        self.assertEqual({name: place[name] for name in ("env", "rule", "live", "running", "at_end")},
                         {"env": "main", "rule": "begin", "live": True, "running": False, "at_end": False})
        self.assertRegex(place["facts"][0], r"^f-\d+$")
        self.attach("delete all")
        self.end()

    def test_short_break_points(self):
        self.begin("--set", "duration_s=1000", stopped=True)
        self.attach("break rule finish", "break fact (order (id 2) (state done))", "break 3.2")
        self.assertEqual(self.attach("breaks"), "1  rule finish\n2  fact (order (id 2) (state done))\n3  3.2 s\n")
        self.assertIn("break point 1: main at", self.attach("continue"))
        self.attach("delete 1")
        self.assertIn("break point 2: main at", self.attach("continue"))
        self.assertIn("(order (id 2) (state done))", self.attach("facts order"))
        self.assertIn("break point 3: main at 3.200 s", self.attach("continue"))
        self.attach("delete all")
        self.attach("break fact (order (id 2))", "break 3.5")
        self.assertIn("main at 3.500 s", self.attach("continue"), "the fact was there already")
        self.attach("delete all")
        self.assertEqual(self.attach("breaks"), "none\n")
        self.end()

    def test_short_changes_replay(self):
        self.begin("--set", "seed=7")
        self.attach("assert (extra 5)", "step", "(defrule mine (extra ?x) => (assert (twice (* 2 ?x))))",
                    "until fact (twice 10)", "eval (bind ?*count* 40)", "retract (extra ?)", "until 2", "assert (extra 6)",
                    "tick", "build (deffunction f (?x) (+ ?x 1))", "eval (f ?*count*)")
        self.assertEqual(self.attach("(f 1)"), "2\n")
        self.end()
        fired = self.fired()
        self.assertEqual([rule for rule in fired if rule in ("seen", "mine")].count("mine"), 2)
        self.assertIs(self.result()["deterministic"], False)
        acts = [r["data"]["text"] for r in self.records() if r["kind"] == "control"]
        self.assertIn("(assert (extra 5))", acts)
        hash_ = self.result()["journal_hash"]
        for how in ([], ["--rules"]):
            replayed = subprocess.run([CXLAB, "replay", self.out, *how], text=True, timeout=60, stdout=subprocess.PIPE,
                                      stderr=subprocess.STDOUT)
            self.assertEqual(replayed.returncode, 0, replayed.stdout)
            self.assertIn("the same", replayed.stdout)
        self.assertEqual(self.result()["journal_hash"], hash_)
        again = subprocess.run([CXLAB, "rerun", self.out, "--out", self.folder / "again"], text=True, timeout=60,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(again.returncode, 2, again.stdout)
        self.assertIn("a person (cxlab attach) took part in this run", again.stdout)
        why = subprocess.run([CXLAB, "why-not", self.out, "never"], text=True, timeout=60, stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT)
        self.assertEqual(why.returncode, 0, why.stdout)

    def test_short_control_alone_changes_nothing(self):
        self.begin("--control-at", "c.sock", stopped=True)
        self.attach("until rule finish", "step", "facts", "agenda", "globals", "continue", where="c.sock")
        self.assertEqual(self.run_.wait(20), 0)
        looked_at = self.result()
        self.run_it("--force", "--journal", "full")
        self.assertEqual(self.result()["journal_hash"], looked_at["journal_hash"])
        self.assertIs(looked_at["deterministic"], True)

    def test_short_wrong_commands(self):
        self.begin()
        for command, text in [
                ("orders", "there is no command 'orders' (help lists them)"), ("fcts", "there is no command 'fcts' (help lists them), did you mean 'facts'?"), ("facts ordr", "there is no template 'ordr'"),
                ("rules begn", "did you mean 'begin'?"), ("until rule begn", "did you mean 'begin'?"),
                ("until", "expected"), ("step 0", "expected a number from 1"), ("step x", "found 'x'"),
                ("tick -1", "found '-1'"), ("delete 9", "there is no break point '9'"),
                ("use nobody", "there is no environment 'nobody'"), ("(+ 1", "(+ 1"), ("eval", "eval"),
                ("assert (order (ix 1))", "ix"), ("(println 1) (println 2)", "expected one expression or construct, found 2"),
                ("(defrule broken", "broken"), ("retract x", "expected a fact's index or a pattern"),
                ("retract (order (id 99))", "no fact matches"), ("break fact (", "fact"), ("facts (", "("),
                ("why nothing", "there is neither a rule nor a template 'nothing'"), ("why-not nothing", "there is no rule 'nothing'"), ("back", "cxlab attach RUN"), ("at 3", "does not go back"), ("back-until begin", "does not go back"), ("why begin", "has not fired up to then"), ("e", "'e' may be envs or eval"),
                ("(undefined-function 1)", "undefined-function"), ("until fact (ordr (id 1))", "ordr"),
                ("build (+ 1 2)", "build"),
                *((f"break {no_time}", f"there is no rule '{no_time}'") for no_time in
                  ("1e99", "1000000000", "-1", "-0.5", "1:60", "1:-1", "-1:0", "10000001:0", ":5", "5:", "1:2:3", "x:5", "5:x"))]:
            with self.subTest(command):
                said = self.attach(command, code=1)
                self.assertIn(text, said)
                self.assertIn(f"error: {command}: ", said)
        self.assertIn("main at 0.000 s", self.attach("where"))
        self.end()

    def test_short_an_error_in_what_is_evaluated_stops_nobody(self):
        self.begin()
        self.attach("eval (/ 1 0)", code=1)
        self.attach("(while TRUE do (bind ?x 1))", code=1)
        self.assertEqual(self.attach("eval (+ 1 2)"), "3\n")
        self.end()

    def test_short_standard_input(self):
        self.begin()
        said = self.attach(stdin="until rule begin\n\nfacts (order (id 1))\nquit\nfacts\n")
        self.assertIn("(order (id 1) (state new))", said)
        self.assertNotIn("(id 2)", said)
        self.end()

    def test_short_nobody_there(self):
        self.assertIn("nothing to attach to", self.attach("where", where="nothing.sock", code=5))
        (self.folder / "empty").mkdir()
        self.assertIn("nothing to attach to", self.attach("where", where="empty", code=5))
        self.assertIn("expected a port", self.attach("where", where="127.0.0.1:99999", code=2))
        self.assertIn("107 characters", self.attach("where", where="x" * 200, code=2))
        self.assertIn("nothing to attach to", self.attach("where", where="127.0.0.1:1", code=5))

    def test_short_the_socket_is_the_users_alone(self):
        self.begin()
        path = self.out / "control.sock"
        self.assertTrue(stat.S_ISSOCK(path.stat().st_mode))
        self.assertEqual(stat.S_IMODE(path.stat().st_mode), 0o600)
        self.end()
        self.assertFalse(path.exists())

    def test_short_a_file_stays_and_a_run_keeps_its_socket(self):
        (self.folder / "mine.txt").write_text("keep")
        self.begin("--control-at", "live.sock")
        refused = self.run_it("--out", "second", "--control-at", "mine.txt", out=False)
        self.assertEqual(refused.returncode, 5, refused.stderr)
        self.assertIn("is no socket", refused.stderr)
        self.assertEqual((self.folder / "mine.txt").read_text(), "keep")
        refused = self.run_it("--out", "third", "--control-at", "live.sock", out=False)
        self.assertEqual(refused.returncode, 5, refused.stderr)
        self.assertIn("another run listens there", refused.stderr)
        self.attach("where", where="live.sock")
        self.run_.kill()
        self.run_.wait()
        self.assertTrue((self.folder / "live.sock").exists())
        self.begin("--control-at", "live.sock", "--force")
        self.attach("continue", where="live.sock")

    def test_short_token(self):
        self.begin("--control-at", "127.0.0.1:0")
        port, token = re.search(r"cxlab attach 127\.0\.0\.1:(\d+) --token ([0-9a-f]{32})", self.said()).groups()
        where = f"127.0.0.1:{port}"
        for wrong in ([], ["--token", token[:-1] + ("0" if token[-1] != "0" else "1")], ["--token", token + "0"]):
            self.assertIn("does not take this --token", self.attach("where", where=where, code=2, arguments=wrong))
        self.assertIn("main at", self.attach("where", where=where, arguments=["--token", token]))
        self.attach("continue", where=f"localhost:{port}", arguments=["--token", token, "--quiet"])
        self.assertEqual(self.run_.wait(20), 0)

    def test_short_nonsense_at_the_socket(self):
        self.begin()
        for sent in (b"nonsense\n", b"[]\n", b"{}\n", b'{"id": {}}\n', b'{"id": 1, "line": 5}\n', b'{"id": 1, "complete": []}\n',
                     b"\xff\xfe\n", b"\0\n", b'{"id": 1, "line": "\\u0000"}\n', b"[" * 100000 + b"\n"):
            with socket.socket(socket.AF_UNIX) as at:
                at.settimeout(10)
                at.connect(str(self.out / "control.sock"))
                reader = at.makefile("rb")
                self.event(reader, "hello")
                at.sendall(sent)
                answer = json.loads(reader.readline())
                self.assertIs(answer["ok"], False)
        with socket.socket(socket.AF_UNIX) as at:  # a line without an end
            at.settimeout(10)
            at.connect(str(self.out / "control.sock"))
            try:
                at.sendall(b"x" * 3_000_000)
                while at.recv(65536):
                    pass
            except (BrokenPipeError, ConnectionResetError):
                pass
        self.end()

    def test_short_a_signal_ends_a_run_that_is_stopped(self):
        self.begin()
        begun = time.monotonic()
        self.run_.send_signal(signal.SIGINT)
        self.assertEqual(self.run_.wait(10), 130, self.said())
        self.assertLess(time.monotonic() - begun, 2)
        self.assertEqual(self.result()["status"], "interrupted")

    def test_short_who_leaves_lets_the_run_be(self):
        self.begin()
        self.attach("until rule begin")
        self.assertIsNone(self.run_.poll())
        self.assertIn("before rule begin", self.attach("where"))
        self.end()

    def test_short_pause_of_a_running_run(self):
        self.begin("--realtime", "--control", "--set", "duration_s=60", stopped=False)
        self.assertRegex(self.attach("where"), r"^main at \d")
        self.assertIn("pause first", self.attach("eval (+ 1 1)", code=1))
        self.assertIn("paused: main at", self.attach("pause"))
        self.assertEqual(self.attach("eval (+ 1 1)"), "2\n")
        self.run_.send_signal(signal.SIGTERM)
        self.assertEqual(self.run_.wait(10), 143)

    def test_short_log(self):
        self.begin()
        said = self.attach("watch facts", "(printout t \"hello log\" crlf)", "until 1", "log HELLO")
        self.assertIn("hello log", said)
        self.assertIn("==> f-2     (order ... (state done))", self.attach("log f-2"))
        self.attach("unwatch facts")
        self.end()

    def test_short_two_at_once(self):
        self.begin()
        with socket.socket(socket.AF_UNIX) as at:
            at.settimeout(10)
            at.connect(str(self.out / "control.sock"))
            lines = at.makefile("r")
            self.event(lines, "hello")
            self.attach("until rule finish")
            self.assertIn("before rule finish", self.event(lines, "stopped"))
        self.end()

    def test_short_terminal(self):
        self.begin()
        pid, terminal = pty.fork()
        if pid == 0:
            os.environ.update(TERM="xterm", HOME=str(self.folder), XDG_STATE_HOME=str(self.folder / "state"))
            os.execv(CXLAB, [CXLAB, "attach", str(self.out)])
        self.addCleanup(os.close, terminal)
        seen = ""

        def until(text):
            nonlocal seen
            end = time.monotonic() + 20
            while text not in seen:
                self.assertLess(time.monotonic(), end, seen)
                if select.select([terminal], [], [], 0.1)[0]:
                    try:
                        seen += os.read(terminal, 65536).decode(errors="replace")
                    except OSError:
                        break
            self.assertIn(text, seen)
            seen = seen[seen.index(text) + len(text):]

        def types(text):
            os.write(terminal, text.encode())

        until("before rule begin")
        until("cxlab> ")
        types("until rule finish\n")
        until("before rule finish")
        types("glo\t\n")
        until("?*count* = 2")
        types("fcts\n")
        until("error: there is no command 'fcts'")
        types("facts (order (id 2))\n")
        until("(order (id 2) (state begun))")
        types("continue\n")
        until("completed at 5.000 s")
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), 0)
        self.assertEqual(self.run_.wait(20), 0)
        history = pathlib.Path(self.folder / "state/cxlab/attach_history").read_text()
        self.assertIn("facts", history)
