"""cxlab view: what its server answers, to whom, and when it ends."""

import http.client
import json
import os
import re
import select
import shutil
import signal
import socket
import subprocess
import time
import unittest
from pathlib import Path

from lab import CXLAB, Lab
from questions import AGENT
from wall import HAS_WALL

RULES = AGENT.replace("(defrule begin\n", '(defrule begin\n  "A worker is free and a job is open: begin."\n').replace("(state LOST)) =>", "(state LOST)) (test (> ?id 0)) =>")
SCENARIO = """schema: 1
duration_s: 5
packages: {rules: rules}
agents:
  - config: agent.yaml
"""
LOOP = "(deffacts start (n 0))\n(defrule round (time ?t&:(>= ?t 1)) ?f <- (n ?n) => (retract ?f) (assert (n (+ ?n 1))))\n"


class Server:
    """cxlab view at work, and one who asks it."""

    def __init__(self, test, *arguments, env=None):
        self.process = subprocess.Popen([CXLAB, "view", *map(str, arguments)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True, cwd=test.folder, env=env)
        test.addCleanup(self.process.stderr.close)
        test.addCleanup(self.process.stdout.close)
        test.addCleanup(self.process.wait)
        test.addCleanup(self.process.kill)
        ready, _, _ = select.select([self.process.stdout], [], [], 30)
        self.address = self.process.stdout.readline().strip() if ready else ""
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/\?token=([0-9a-f]{32})", self.address)
        test.assertTrue(found, self.address + (self.process.stderr.read() if self.process.poll() is not None else ""))
        self.port, self.token = int(found[1]), found[2]

    def send(self, method, path, body=None, headers=(), token=True):
        """Status, headers and bytes of the answer."""
        line = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        own = {"Authorization": "Bearer " + self.token} if token is True else {"Authorization": "Bearer " + token} if token else {}
        if body is not None:
            own["Content-Type"] = "application/json"
        own.update(headers)
        line.request(method, path, body=body, headers={name: value for name, value in own.items() if value is not None})
        answer = line.getresponse()
        content = answer.read()
        line.close()
        return answer.status, dict(answer.getheaders()), content

    def get(self, path, expect=200):
        status, _, content = self.send("GET", path)
        assert status == expect, (status, content[:500])
        return json.loads(content)

    def post(self, path, body, expect=200):
        status, _, content = self.send("POST", path, json.dumps(body))
        assert status == expect, (status, content[:500])
        return json.loads(content)

    def ask(self, name, run="run", expect=200, **fields):
        answer = self.post(f"/run/{run}/ask", {"ask": name, **fields}, expect)
        return answer["error"] if expect != 200 else answer["answer"]

    def go(self, run="run", expect=200, **where):
        answer = self.post(f"/run/{run}/go", where, expect)
        return answer["error"] if expect != 200 else answer["place"]

    def cpu(self):
        """Seconds of CPU of the server and all its processes."""
        used = 0
        for pid in [self.process.pid, *self.children()]:
            used += sum(map(int, Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[11:15]))
        return used / os.sysconf("SC_CLK_TCK")

    def children(self):
        """Processes of the server, and theirs."""
        out, rest = [], [self.process.pid]
        while rest:
            pids = children_of(rest[0])
            rest = rest[1:] + pids
            out += pids
        return out


def children_of(pid):
    try:
        return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except (FileNotFoundError, ProcessLookupError):
        return []


def alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


class View(Lab):
    def play(self, rules=RULES, scenario=SCENARIO, out="run", code=0, arguments=()):
        self.agent(rules, scenario)
        done = subprocess.run([CXLAB, "run", "scenario.yaml", "--out", out, "--journal", "full", "--quiet", *arguments], cwd=self.folder,
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, code, done.stderr)
        return self.folder / out

    def answer(self, *arguments):
        done = subprocess.run([CXLAB, *map(str, arguments), "--json"], cwd=self.folder, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def attach(self, *commands):
        done = subprocess.run([CXLAB, "attach", "run", "--quiet", *(word for one in commands for word in ("-c", one))], cwd=self.folder,
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.splitlines()

    def files(self, folder):
        return {str(path.relative_to(folder)): (path.stat().st_mtime_ns, path.stat().st_size) for path in sorted(folder.rglob("*"))}


class Questions(View):
    def test_answers_are_those_of_the_commands(self):
        """Forwards and backwards in time, whatever was asked before."""
        run = self.play()
        server = Server(self, run)
        for t in (1.0, 3.0, 0.0, 5.0, 2.25, 1.0):
            with self.subTest(t=t):
                at = ("run", "--at", t)
                one = lambda *words: self.answer(*words)["environments"][0]
                same = lambda asked, told: self.assertEqual({key: asked[key] for key in told}, told)
                same(server.ask("facts", t=t), one("facts", *at))
                same(server.ask("facts", t=t, what="(job (id 1))"), one("facts", "run", "(job (id 1))", "--at", t))
                same(server.ask("agenda", t=t), one("agenda", *at))
                same(server.ask("globals", t=t), one("globals", *at))
                same(server.ask("firings", t=t), one("firings", "run", "--to", t))
                same(server.ask("firings", t=t, rule="begin"), one("firings", "run", "begin", "--to", t))
                same(server.ask("why", t=t, what="(job (id 1))"), one("why", "run", "(job (id 1))", "--at", t))
                same(server.ask("changes", t=t, what="work"), one("facts", "run", "work", "--from", 0, "--to", t))
                same(server.ask("rules", t=t), one("rules", *at))
                same(server.ask("why_not", t=t, what="(job (id 2))"), one("why-not", "run", "(job (id 2))", "--at", t))
                same(server.ask("why_not", t=t, what="(job (id 7))"), one("why-not", "run", "(job (id 7))", "--at", t))
                # Facts that were asserted to look at conditions are gone.
                same(server.ask("facts", t=t), one("facts", *at))
                for rule in ("begin", "never", "robbed", "end"):
                    asked = server.ask("why_not", t=t, what=rule)["explanations"]
                    told = self.answer("why-not", "run", rule, "--at", t)["explanations"]
                    self.assertEqual(len(asked), len(told))
                    same(asked[0], told[0])
                same(server.ask("agenda", t=t), one("agenda", *at))
                self.assertEqual(server.ask("where")["text"], "at the end of the run, 5.000 s" if t == 5 else f"after the tick at {2.2 if t == 2.25 else t:.3f} s")

    def test_conditions_tell_which_hold(self):
        self.play()
        server = Server(self, "run")
        holds = lambda rule, t: [one["holds"] for one in server.ask("source", rule=rule, t=t)["conditions"]]
        self.assertEqual(holds("begin", 1), [True, True, False])
        self.assertEqual(holds("begin", 5), [True, False, None])
        self.assertEqual(holds("never", 5), [False, None])
        source = server.ask("source", rule="begin", t=5)
        lines = source["text"].split("\n")
        self.assertEqual((lines[0], source["first_line"]), ("(defrule begin", 4))
        for one in source["conditions"]:
            self.assertIn(one["text"].split()[-1].strip("()"), lines[one["line"] - source["first_line"]])
            self.assertEqual(one["line"], one["end_line"])
        self.assertEqual([one["matches_alone"] for one in source["conditions"]], [1, 0, 1])
        self.assertEqual(source["because"], self.answer("why-not", "run", "begin")["explanations"][0]["first_unmet"]["because"])
        whole = server.ask("source", file=source["file"], t=5)
        self.assertEqual(whole["text"], RULES)
        self.assertIn({"kind": "defrule", "module": "MAIN", "name": "begin", "line": 4, "end_line": 12}, whole["constructs"])
        (self.folder / "rules/rules.clp").write_text("; the files of the run are its own\n")
        self.assertEqual(server.ask("source", file=source["file"], t=0)["text"], RULES)

    def test_conditions_of_an_or_and_over_several_lines(self):
        self.play(RULES + """(defrule either ; no condition
  (or (job (state LOST))
      (job (id ?id) (state DONE)))
  (not (and (job (state OPEN))
            (free ?)))
  (test (eq 1 2))
  (free ?who)
  =>
  (assert (seen)))
""")
        server = Server(self, "run")
        found = lambda t: [(one["line"], one["end_line"], one["holds"]) for one in server.ask("source", rule="either", t=t)["conditions"]]
        self.assertEqual(found(0), [(25, 26, False), (27, 28, None), (29, 29, None), (30, 30, None)])
        self.assertEqual(found(5), [(25, 26, True), (27, 28, True), (29, 29, False), (30, 30, None)])
        for t, condition in ((0, 1), (5, 3)):
            self.assertEqual(server.ask("why_not", what="either", t=t)["explanations"][0]["first_unmet"]["condition"], condition)

    def test_makers_and_users(self):
        self.play()
        server = Server(self, "run")
        self.assertEqual([one["rule"] for one in server.ask("producers", what="work", t=3)["rules"]], ["begin"])
        self.assertEqual([one["rule"] for one in server.ask("producers", what="(job (state DONE))", t=1)["rules"]], ["end"])
        users = server.ask("consumers", what="free", t=5)
        self.assertEqual({one["rule"] for one in users["waiting"]}, {"begin", "robbed"})
        self.assertEqual([server.ask("words", begun=begun, t=5)["words"] for begun in ("robb", "jo")],
                         [[{"word": "robbed", "kind": "rule"}], [{"word": "job", "kind": "template"}]])
        self.assertEqual(server.ask("facts", limit=1, t=5)["total"], server.ask("envs", t=5)["environments"][0]["facts"])
        # Facts are the first ones, changes and firings the last ones.
        for name, key, asked, end in [("facts", "facts", {"what": "job"}, 0), ("changes", "facts", {"what": "job"}, -1), ("firings", "firings", {}, -1)]:
            with self.subTest(name):
                everything = server.ask(name, t=5, **asked)
                self.assertGreater(everything["total"], 1)
                self.assertEqual(everything["total"], len(everything[key]))
                one = server.ask(name, limit=1, t=5, **asked)
                self.assertEqual((one["total"], one[key]), (everything["total"], [everything[key][end]]))
        brief = server.ask("facts", what="job", brief=True, t=5)["facts"]
        self.assertEqual([len(fact["changes"]) for fact in brief], [2, 2])
        self.assertEqual(brief[0]["changes"][1]["what"], "modify")

    def test_steps_agree_with_attach(self):
        self.play()
        server = Server(self, "run")
        place = server.go(t=2.5)
        self.assertEqual((place["firing"], place["rule"], place["text"]), (None, None, "after the tick at 2.500 s"))
        back = [server.go(back=1)["text"] for _ in range(4)]
        said = self.attach("at 2.6", "back", "back", "back", "back")[1:]
        self.assertEqual(["at: " + text for text in back], said)
        forward = [server.go(step=1)["text"] for _ in range(3)]
        self.assertEqual(forward, back[2::-1])
        place = server.go(back_until="begin")
        self.assertEqual((place["rule"], place["t"]), ("begin", 2.0))
        self.assertEqual(place["text"], self.attach("at 2.6", "back-until begin")[-1][4:])
        self.assertEqual(server.ask("agenda")["agenda"][0]["rule"], "begin")
        self.assertEqual(server.ask("agenda")["agenda"][0]["facts"], place["facts"])
        self.assertEqual(server.go(until="end")["text"], self.attach("at 2.6", "back-until begin", "until end")[-1].split(": ", 1)[1])
        self.assertEqual(server.go(t=5)["at_end"], True)
        self.assertIn("end of the run", server.go(step=1, expect=400))
        self.assertIn("there is no rule 'nobody'", server.go(until="nobody", expect=400))

    def test_refused_questions(self):
        self.play()
        server = Server(self, "run")
        for asked, why in [({"ask": "fact"}, "did you mean 'facts'"), ({"ask": 3}, "expected"), ([], "expected"), ({}, "expected"),
                           ({"ask": "facts", "t": "soon"}, "\"t\": found \"soon\""), ({"ask": "facts", "t": -1}, "expected a time"),
                           ({"ask": "facts", "t": 1e300}, "expected a time"), ({"ask": "facts", "t": 17}, "the run ends at 5 s"),
                           ({"ask": "facts", "what": "jobs"}, "did you mean 'job'"), ({"ask": "facts", "what": "(job (x 1))"}, "no slot 'x'"),
                           ({"ask": "facts", "env": "other"}, "no environment 'other'"), ({"ask": "why", "what": "never"}, "has not fired"),
                           ({"ask": "source", "rule": "x\ny"}, "no rule"), ({"ask": "source", "file": "/etc/passwd"}, "no rules were read from"),
                           ({"ask": "source", "file": "../../etc/passwd"}, "no rules were read from"), ({"ask": "why_not", "what": "begins"}, "did you mean 'begin'"),
                           ({"ask": "line", "line": "eval (exit)"}, "no question")]:
            with self.subTest(asked=asked):
                self.assertIn(why, server.post("/run/run/ask", asked, 400)["error"])
        for order, why in [({"step": "1"}, "expected a number"), ({"until": "a\nb"}, "there is no rule 'a\nb'"), ({"until": 3}, "found 3, expected a text"),
                           ({"until": "(job\n(x 1))"}, "no slot 'x'"), ({"env": 3, "step": 1}, "found 3, expected the name of an environment"),
                           ({"env": "a\nb", "step": 1}, "there is no environment 'a\nb'"), ({"eval": "(exit)"}, "expected where to go"), ({"step": -1}, "from 1"),
                           ({"pause": True, "x": 1}, None), ({"speed": 2}, "is over")]:
            with self.subTest(order=order):
                if why:
                    self.assertIn(why, server.post("/run/run/go", order, 400)["error"])
        status, _, content = server.send("POST", "/run/run/ask", "{\"ask\": ")
        self.assertEqual((status, json.loads(content)["error"]), (400, "the body is no JSON"))
        self.assertEqual(server.send("POST", "/run/run/ask", "{" + " " * 1_000_001)[0], 413)
        for deep in ("[" * 400_000 + "]" * 400_000, '{"ask": "facts", "x": ' + "[" * 400_000 + "]" * 400_000 + "}", '{"a":' * 150_000, '{"ask": "facts", "x": ' + "[" * 1001 + "]" * 1001 + "}"):
            self.assertEqual(server.send("POST", "/run/run/ask", deep)[0], 400)
        self.assertEqual(server.post("/run/run/ask", {"ask": "facts", "what": "(free a)", "x": "[" * 5000, "t": 5})["answer"]["total"], 1)
        self.assertEqual(server.ask("facts", what="(free a)", t=5)["total"], 1)  # and it goes on

    def test_a_run_that_failed_and_one_that_was_killed(self):
        looped = self.play(LOOP, out="looped", code=4)
        server = Server(self, "looped")
        told = self.answer("facts", "looped", "--at", 0.5)["environments"][0]["facts"]
        self.assertEqual(server.ask("facts", "looped", t=0.5)["facts"], told)
        self.assertEqual(server.go("looped", t=0.5)["text"], "after the tick at 0.500 s")
        self.assertTrue(server.go("looped", back=1, expect=200)["text"])
        killed = shutil.copytree(self.play(), self.folder / "killed")
        log = (killed / "inputs.bin").read_bytes()
        (killed / "inputs.bin").write_bytes(log[:len(log) * 2 // 3])
        shutil.copy(looped / "result.json", killed / "result.json")
        result = json.loads((killed / "result.json").read_text())
        result.update(status="failed", stream_hashes={}, reason={"code": "unfinished", "message": "unfinished", "file": None, "line": None})
        (killed / "result.json").write_text(json.dumps(result))
        (killed / "index.html").unlink()
        with socket.socket(socket.AF_UNIX) as left:
            left.bind(str(killed / "control.sock"))  # as a killed run of --control leaves it
        self.assertEqual([(row["name"], row["status"], row["live"]) for row in Server(self, ".").get("/api/runs")["runs"]],
                         [("killed", "unfinished", False), ("looped", "failed", False), ("run", "completed", False)])
        of_killed = Server(self, "killed")
        page = of_killed.send("GET", "/run/killed/")[2].decode()
        self.assertRegex(page, r'<b class="bad">unfinished</b> after 0:0[1-4] of simulated time')
        self.assertNotIn("in progress", page)
        end = of_killed.go("killed", t=1e6)["t"]
        self.assertLess(end, 5)
        self.assertEqual(of_killed.ask("facts", "killed", t=1)["facts"], self.answer("facts", "killed")["environments"][0]["facts"])
        self.assertGreaterEqual(of_killed.get("/run/killed/data.json")["end"], 0)

    def test_a_run_without_an_environment(self):
        self.write("scenario.yaml", "schema: 1\nduration_s: 3\nworld: {kind: rcll}\ntier: timed\n")
        subprocess.run([CXLAB, "run", "scenario.yaml", "--out", "run", "--quiet"], cwd=self.folder, check=True, stdout=subprocess.DEVNULL, timeout=60)
        server = Server(self, "run")
        place = server.ask("where")
        self.assertEqual((place["at_end"], place["env"], place["text"]), (True, None, "at the end of the run, 3.000 s"))
        self.assertEqual(server.ask("facts", t=2, expect=400), "there is no environment")
        self.assertIn("end of the run", server.go(step=1, expect=400))
        self.assertEqual(server.send("GET", "/run/run/")[0], 200)

    def test_a_process_that_dies_is_started_again(self):
        self.play()
        server = Server(self, "run")
        before = server.ask("facts", t=2)
        for pid in server.children()[1:]:
            os.kill(pid, signal.SIGKILL)
        self.assertIn("signal 9", server.ask("facts", t=2, expect=500))
        self.assertEqual(server.ask("facts", t=2), before)

    def test_in_a_run_that_was_opened_again_the_server_stands_where_the_person_stood(self):
        self.play()
        server = Server(self, "run")
        facts = server.ask("facts", t=2)
        server.go(t=2)
        step = server.go(step=1)
        for question, answer in ((lambda: server.ask("facts", stood=2), facts), (lambda: server.go(stood=2, step=1), step)):
            for pid in server.children()[1:]:
                os.kill(pid, signal.SIGKILL)
            server.ask("facts", t=1, expect=500)
            self.assertEqual(question(), answer)
        # Nothing was opened again: it goes on from where it stands.
        self.assertEqual(server.go(stood=1, back=1)["t"], 2)

    def test_two_environments(self):
        self.agent(RULES, SCENARIO)
        agent = self.folder / "agent.yaml"
        agent.write_text(agent.read_text().replace('["main"]', '["main", "other"]').replace("    main: {", "    other: {plugins: [\"executive\", \"files\"]}\n    main: {"))
        subprocess.run([CXLAB, "run", "scenario.yaml", "--out", "run", "--journal", "full", "--quiet"], cwd=self.folder, check=True, stdout=subprocess.DEVNULL, timeout=60)
        server = Server(self, "run")
        told = self.answer("facts", "run", "--at", 1)["environments"]
        self.assertEqual([one["environment"] for one in server.ask("envs", t=1)["environments"]], ["main", "other"])
        for one in told:
            asked = server.ask("facts", t=1, env=one["environment"])
            self.assertEqual((asked["environment"], asked["facts"]), (one["environment"], one["facts"]))
        self.assertEqual({server.go(env="other", step=1)["env"] for _ in range(5)}, {"other"})
        self.assertEqual(server.go(env="", t=2)["t"], 2.0)
        self.assertEqual({server.go(env="", step=1)["env"] for _ in range(9)}, {"main", "other"})


class Times(View):
    def test_a_whole_game_is_answered_within_a_second_of_cpu(self):
        subprocess.run([CXLAB, "run", "rcll/game", "--tier", "timed", "--out", "game", "--quiet"], cwd=self.folder, check=True, stdout=subprocess.DEVNULL, timeout=60)
        server = Server(self, "game")
        server.ask("where", "game")
        for name, fields in [("facts", {}), ("agenda", {}), ("why", {"what": "order-begin"})]:
            for t in (1100, 400):
                before = server.cpu()
                server.ask(name, "game", t=t, **fields)
                self.assertLess(server.cpu() - before, 1, (name, t))


class Access(View):
    def setUp(self):
        super().setUp()
        self.play(arguments=["--until", "1"])
        self.server = Server(self, "run")

    def refused(self, method="GET", path="/run/run/data.json", status=403, **how):
        got, headers, content = self.server.send(method, path, **how)
        self.assertEqual(got, status, content[:300])
        self.assertIn("error", json.loads(content))
        return json.loads(content)["error"]

    def test_nobody_without_the_token(self):
        for path in ("/", "/run/run/", "/run/run/data.json", "/api/runs", "/run.js", "/three.js", "/nothing", "/run/run/events?after=0"):
            self.assertIn("open the address that cxlab view printed", self.refused(path=path, token=None))
            self.refused(path=path, token="0" * 32)
            self.refused(path=path, token=self.server.token[:-1])
            self.refused(path=path, token=None, headers={"Cookie": f"cxlab_view_{self.server.port}={'0' * 32}"})
        self.refused(path="/?token=" + "0" * 32, token=None)
        self.refused(path="/run/run/data.json?token=" + self.server.token, token=None)
        self.refused("POST", "/run/run/ask", body="{}", token=None)

    def test_the_address_gives_a_cookie(self):
        status, headers, _ = self.server.send("GET", "/?token=" + self.server.token, token=None)
        self.assertEqual((status, headers["Location"]), (303, "/"))
        name = f"cxlab_view_{self.server.port}"
        self.assertEqual(headers["Set-Cookie"], f"{name}={self.server.token}; Path=/; HttpOnly; SameSite=Strict")
        cookie = {"Cookie": f"other=1; {name}={self.server.token}"}
        self.assertEqual(self.server.send("GET", "/run/run/data.json", token=None, headers=cookie)[0], 200)
        status, headers, content = self.server.send("GET", "/?token=" + self.server.token, token=None, headers={"Sec-Fetch-Site": "cross-site"})
        self.assertEqual(status, 200)
        self.assertIn(b"url=/", content)
        self.assertIn(name, headers["Set-Cookie"])

    def test_addresses_that_are_short_lead_to_the_page(self):
        for path in ("/", "/run/run"):
            status, headers, content = self.server.send("GET", path)
            self.assertEqual((status, headers["Location"], content), (303, "/run/run/", b""), path)

    def test_no_other_host_and_no_other_page(self):
        port = self.server.port
        for host in ("evil.example", f"evil.example:{port}", "127.0.0.1", f"127.0.0.1:{port + 1}", "", f"127.0.0.1:{port}.evil.example"):
            self.refused(headers={"Host": host})
            self.refused(path="/?token=" + self.server.token, token=None, headers={"Host": host})
        self.assertEqual(self.server.send("GET", "/api/runs", headers={"Host": f"localhost:{port}"})[0], 200)
        ask = json.dumps({"ask": "where"})
        for origin in ("http://evil.example", "null", f"http://127.0.0.1:{port + 1}", f"https://127.0.0.1:{port}", "http://127.0.0.1"):
            self.refused("POST", "/run/run/ask", body=ask, headers={"Origin": origin})
        for origin in (f"http://127.0.0.1:{port}", f"http://localhost:{port}"):
            self.assertEqual(self.server.send("POST", "/run/run/ask", ask, headers={"Origin": origin})[0], 200)
        for kind in ("text/plain", "application/x-www-form-urlencoded", "", None):
            self.refused("POST", "/run/run/ask", status=400, body=ask, headers={"Content-Type": kind})
        self.assertEqual(self.server.send("PUT", "/run/run/ask", ask)[0] // 100, 4)
        self.assertEqual(self.server.send("DELETE", "/run/run/")[0] // 100, 4)

    def test_pages_may_ask_nobody_else(self):
        for path in ("/run/run/", "/run/run/result.json", "/nothing"):
            _, headers, _ = self.server.send("GET", path)
            policy = headers["Content-Security-Policy"]
            self.assertIn("default-src 'none'", policy)
            self.assertIn("connect-src 'self'", policy)
            self.assertNotIn("unsafe-eval", policy)
            self.assertNotIn("*", policy)
            self.assertEqual((headers["X-Content-Type-Options"], headers["Cache-Control"]), ("nosniff", "no-store"))

    def test_only_files_that_the_page_names(self):
        run = self.folder / "run"
        (self.folder / "secret.txt").write_text("secret")
        (run / "secret.log").write_text("secret")
        (run / "logs").mkdir(exist_ok=True)
        (run / "logs/link.log").symlink_to(self.folder / "secret.txt")
        self.assertEqual(self.server.send("GET", "/run/run/result.json")[2], (run / "result.json").read_bytes())
        for path in ("/run/run/../secret.txt", "/run/run/%2e%2e/secret.txt", "/run/run/..%2fsecret.txt", "/run/run/logs/../../secret.txt", "/run/..", "/run/../run/",
                     "/run/%2e%2e/", "/run/run/%2fetc%2fpasswd", "/run/run//etc/passwd", "/run/run/secret.log", "/run/run/logs/link.log", "/run/run/inputs.bin",
                     "/run/run/result.json%00.html", "/run/other/", "/run//", "/%0a", "/run/run/logs", "/run/" + "x" * 3000 + "/"):
            status, _, content = self.server.send("GET", path)
            self.assertEqual(status, 404, path)
            self.assertNotIn(b"secret\n", content)
            self.assertNotEqual(content, b"secret")
        result = run / "result.json"
        result.rename(self.folder / "elsewhere.json")
        result.symlink_to(self.folder / "elsewhere.json")
        self.assertEqual(self.server.send("GET", "/run/run/result.json")[0], 404)
        elsewhere = self.folder / "other logs"
        (run / "logs").rename(elsewhere)
        (elsewhere / "a.log").write_text("secret")
        (run / "logs").symlink_to(elsewhere)
        self.assertEqual(self.server.send("GET", "/run/run/logs/a.log")[0], 404)
        self.assertEqual(self.server.send("GET", "/api/two?a=../run&b=run")[0], 404)

    @unittest.skipUnless(HAS_WALL, "this kernel has no wall")
    def test_the_server_is_behind_the_wall(self):
        run = self.folder / "run"
        self.server.ask("facts", t=1)
        checked = 0
        for task in Path(f"/proc/{self.server.process.pid}/task").iterdir():
            try:
                status = (task / "status").read_text()
            except (FileNotFoundError, ProcessLookupError):  # the thread of an answer that has been sent
                continue
            self.assertIn("\nSeccomp:\t2\n", status, "of each thread")
            self.assertIn("\nNoNewPrivs:\t1\n", status)
            checked += 1
        self.assertGreater(checked, 0)
        # Landlock: a run that becomes a link out of the folder that was named is not read.
        shutil.copytree(run, self.folder / "runs/a")
        many = Server(self, "runs")
        self.assertEqual(many.send("GET", "/run/a/data.json")[0], 200)
        (self.folder / "runs/a").rename(self.folder / "elsewhere")
        (self.folder / "runs/a").symlink_to(self.folder / "elsewhere")
        status, _, content = many.send("GET", "/run/a/data.json")
        self.assertEqual(status, 500)
        self.assertEqual(list(json.loads(content)), ["error"])

    def test_bytes_that_are_no_request(self):
        for raw in (b"", b"\0" * 100, b"GET / HTTP/1.1\r\n", b"POST /run/run/ask HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n\r\n",
                    b"GET " + b"/" * 100_000 + b" HTTP/1.1\r\n\r\n", b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nzzz\r\n"):
            with socket.create_connection(("127.0.0.1", self.server.port), timeout=20) as line:
                line.sendall(raw)
                line.shutdown(socket.SHUT_WR)
                while line.recv(65536):
                    pass
        self.assertEqual(self.server.send("GET", "/api/runs")[0], 200)

    def test_it_listens_at_one_address(self):
        with self.assertRaises(OSError):
            socket.create_connection(("127.0.0.2", self.server.port), timeout=5).close()
        taken = subprocess.run([CXLAB, "view", "run", "--port", str(self.server.port)], cwd=self.folder, capture_output=True, text=True, timeout=30)
        self.assertEqual(taken.returncode, 5)
        self.assertIn("--port gives another port", taken.stderr)
        self.assertNotIn(self.server.token, Path(f"/proc/{self.server.process.pid}/cmdline").read_text())


class Ends(View):
    def test_ctrl_c_ends_all_and_leaves_no_file(self):
        run = self.play()
        before = self.files(run)
        server = Server(self, "run")
        server.ask("why_not", what="begin", t=2)
        server.go(back=1)
        server.send("GET", "/run/run/")
        server.send("GET", "/run/run/scene.bin")
        pids = server.children()
        self.assertGreaterEqual(len(pids), 2)
        began = time.monotonic()
        server.process.send_signal(signal.SIGINT)
        self.assertEqual(server.process.wait(10), 130)
        self.assertLess(time.monotonic() - began, 3)
        self.assertIn("interrupted:", server.process.stderr.read())
        end = time.monotonic() + 5
        while any(map(alive, pids)) and time.monotonic() < end:
            time.sleep(0.01)
        self.assertFalse([pid for pid in pids if alive(pid)])
        self.assertEqual(self.files(run), before)

    def test_a_killed_server_leaves_no_process(self):
        self.play()
        server = Server(self, "run")
        server.ask("facts", t=2)
        pids = server.children()
        server.process.kill()
        server.process.wait(10)
        end = time.monotonic() + 10
        while any(map(alive, pids)) and time.monotonic() < end:
            time.sleep(0.01)
        self.assertFalse([pid for pid in pids if alive(pid)])

    def test_what_is_no_run(self):
        empty = self.folder / "empty"
        empty.mkdir()
        for place, code, said in [("nowhere", 3, "there is no folder"), ("empty", 3, "neither the folder of a run nor one with runs in it"), ("scenario.yaml", 3, "there is no folder")]:
            done = subprocess.run([CXLAB, "view", place], cwd=self.folder, capture_output=True, text=True, timeout=30)
            self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
            self.assertIn(said, done.stderr)
        self.play(arguments=["--until", "1"])
        done = subprocess.run([CXLAB, "view", "run", "--live"], cwd=self.folder, capture_output=True, text=True, timeout=30)
        self.assertEqual(done.returncode, 5)
        self.assertIn("--control or --break", done.stderr)


class Folders(View):
    def test_all_runs_of_a_folder(self):
        (self.folder / "runs/deep").mkdir(parents=True)
        self.play(out="runs/one")
        self.play(out="runs/deep/two", scenario=SCENARIO.replace("5", "3"), arguments=["--seed", "7"])
        hostile = "<img src=x onerror=alert(1)>&'\"\n%2e"
        (self.folder / "runs" / hostile).mkdir()
        os.rename(self.play(out="other"), self.folder / "runs" / hostile / "r")
        (self.folder / "runs/broken").mkdir()
        (self.folder / "runs/broken/manifest.json").write_text("{")
        (self.folder / "runs/linked").symlink_to(self.folder / "runs/one")
        server = Server(self, "runs")
        listed = server.get("/api/runs")
        by_name = {run["name"]: run for run in listed["runs"]}
        self.assertEqual(set(by_name), {"one", "deep/two", hostile + "/r", "broken"})
        self.assertEqual(len({run["id"] for run in listed["runs"]}), 4)
        self.assertTrue(all(re.fullmatch("[A-Za-z0-9_-]+", run["id"]) for run in listed["runs"]))
        two = by_name["deep/two"]
        self.assertEqual((two["seed"], two["status"], two["sim_time_s"], two["scenario"]), (7, "completed", 3.0, "scenario"))
        self.assertEqual(by_name["broken"]["status"], "unreadable")
        self.assertEqual(server.go(two["id"], t=9, expect=400), "the run ends at 3 s")
        self.assertEqual(server.go(by_name[hostile + "/r"]["id"], t=1)["t"], 1.0)
        for path in ("/", "/two?a=one&b=deep-two", "/run/one/", f"/run/{by_name[hostile + '/r']['id']}/"):
            status, headers, content = server.send("GET", path)
            self.assertEqual((status, headers["Content-Type"]), (200, "text/html; charset=utf-8"))
            self.assertNotIn(b"<img src=x", content)
            self.assertEqual(content.count(b'<a href="/">all runs</a>'), path.startswith("/run/"))
        # A run that comes later is found, and the others keep their ids.
        self.play(out="runs/a-first")
        again = {run["name"]: run["id"] for run in server.get("/api/runs")["runs"]}
        self.assertEqual({name: again[name] for name in by_name}, {name: run["id"] for name, run in by_name.items()})
        self.assertEqual(server.ask("facts", again["a-first"], t=1)["total"], server.ask("facts", "one", t=1)["total"])

    def test_two_runs(self):
        self.play(out="runs/a")
        self.play(RULES.replace("(+ ?now 1)", "(+ ?now 2)"), out="runs/b")
        temporary = self.folder / "temporary"
        temporary.mkdir()
        server = Server(self, "runs", env={**os.environ, "TMPDIR": str(temporary)})
        found = server.get("/api/two?a=a&b=b")
        told = subprocess.run([CXLAB, "diff", "runs/a", "runs/b"], cwd=self.folder, capture_output=True, text=True, timeout=60)
        self.assertEqual(found["text"], told.stdout)
        exact = json.loads(subprocess.run([CXLAB, "diff", "runs/a", "runs/b", "--json"], cwd=self.folder, capture_output=True, text=True, timeout=60).stdout)
        self.assertEqual((found["first"]["t"], found["first"]["a"], found["first"]["b"]), (exact["first"]["t_s"], exact["first"]["a"]["what"], exact["first"]["b"]["what"]))
        same = server.get("/api/two?a=a&b=a")
        self.assertEqual((same["same"], same["first"]), (True, None))
        self.assertEqual(list(temporary.iterdir()), [], "no comparison leaves its files")
        self.assertEqual(server.send("GET", "/api/two?a=a")[0], 404)

    def test_five_runs_have_four_processes(self):
        for n in range(5):
            self.play(out=f"runs/r{n}", arguments=["--until", "2"])
        server = Server(self, "runs")
        for n in (0, 1, 2, 3, 4, 0, 4):
            self.assertEqual(server.go(f"r{n}", t=1)["text"], "after the tick at 1.000 s")
        [starter] = [pid for pid in children_of(server.process.pid) if children_of(pid)]
        players = lambda: len([pid for pid in children_of(starter) if alive(pid)])
        end = time.monotonic() + 5
        while players() > 4 and time.monotonic() < end:
            time.sleep(0.02)
        self.assertEqual(players(), 4)

    def test_a_sweep(self):
        self.agent(RULES, SCENARIO)
        (self.folder / "suite.yaml").write_text("scenarios: [scenario.yaml]\nstrategies: {plain: {}}\nseeds: 1..2\n")
        done = subprocess.run([CXLAB, "bench", "suite.yaml", "--out", "sweep", "--quiet"], cwd=self.folder, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        runs = Server(self, "sweep").get("/api/runs")["runs"]
        self.assertEqual([(run["id"], run["seed"], run["strategy"], run["status"]) for run in runs], [(None, 1, "plain", "completed"), (None, 2, "plain", "completed")])
        self.assertIn("cxlab", runs[0]["command"])


class Live(View):
    def begin(self, *arguments, duration=5):
        self.agent(RULES, SCENARIO.replace("5", str(duration)))
        self.run_ = subprocess.Popen([CXLAB, "run", "scenario.yaml", "--out", "run", "--journal", "full", *arguments], cwd=self.folder, stdin=subprocess.DEVNULL,
                                     stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(self.run_.wait)
        self.addCleanup(self.run_.kill)
        end = time.monotonic() + 20
        while not (self.folder / "run/control.sock").exists():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)

    def test_steps_pause_and_the_end(self):
        self.begin("--break")
        server = Server(self, "run", "--live")
        place = server.ask("where")
        self.assertEqual((place["live"], place["running"], place["t"]), (True, False, 0.0))
        self.assertEqual(server.send("GET", "/run/run/")[0], 200)
        self.assertEqual(server.go(until="begin")["rule"], "begin")
        self.assertEqual(server.ask("facts", what="(free a)")["total"], 1)
        server.go(step=1)
        self.assertEqual(server.ask("facts", what="(free a)")["total"], 0)
        self.assertEqual(server.ask("why", what="(job (state BUSY))")["steps"][1]["text"], "begin")
        self.assertEqual(server.ask("why_not", what="never")["explanations"][0]["first_unmet"]["condition"], 1)
        self.assertGreater(server.go(tick=3)["t"], 1.0)
        self.assertIn("still being played", server.ask("facts", t=0, expect=400))
        self.assertIn("does not go back", server.go(back=1, expect=400))
        events = server.get("/run/run/events?after=0")
        self.assertEqual((events["live"], events["running"]), (True, False))
        self.assertIn("stopped", [event["event"] for event in events["events"]])
        server.go(**{"continue": True})
        self.assertEqual(self.run_.wait(20), 0)
        self.assertEqual(self.ends(server, events["next"]), 1)
        # The live run is a recorded run now.
        self.assertEqual(server.go(t=1)["live"], False)
        self.assertEqual(server.ask("facts", t=2)["facts"], self.answer("facts", "run", "--at", 2)["environments"][0]["facts"])
        self.assertEqual(json.loads((self.folder / "run/result.json").read_text())["deterministic"], True)

    def ends(self, server, after):
        """How many of the events from here on report the end of the run."""
        seen = []
        for _ in range(40):
            events = server.get(f"/run/run/events?after={after}")
            after = events["next"]
            seen += [event["event"] for event in events["events"]]
            if not events["live"]:
                break
        return seen.count("end")

    def test_a_run_that_is_killed_reports_its_end(self):
        self.begin("--break")
        server = Server(self, "run", "--live")
        self.assertEqual(server.ask("where")["live"], True)
        self.run_.kill()
        self.assertEqual(self.ends(server, 0), 1)

    def test_speed_changes_nothing_but_the_clock(self):
        plain = self.play(out="plain")
        self.begin("--break")
        server = Server(self, "run")
        server.go(speed=10)
        began = time.monotonic()
        self.assertEqual(server.go(**{"continue": True})["live"], True)
        time.sleep(0.15)
        paused = server.go(pause=True)
        self.assertFalse(paused["running"])
        self.assertLess(paused["t"], 4)
        server.go(**{"continue": True})
        self.assertEqual(self.run_.wait(20), 0)
        self.assertGreater(time.monotonic() - began, 0.45)
        hashes = [json.loads((self.folder / run / "result.json").read_text())["journal_hash"] for run in ("run", "plain")]
        self.assertEqual(hashes[0], hashes[1])

    def test_a_server_that_goes_leaves_the_run(self):
        self.begin("--break")
        server = Server(self, "run")
        server.go(step=1)
        server.process.send_signal(signal.SIGINT)
        self.assertEqual(server.process.wait(10), 130)
        self.assertIsNone(self.run_.poll())
        self.assertEqual(Server(self, "run").ask("where")["live"], True)
