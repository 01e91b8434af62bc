"""The second wall around rules: a plugin stands for a fault of the program, and tries from inside to reach what is outside."""

import json
import os
import resource
import signal
import socket
import subprocess
import threading
import time
import unittest

from lab import CXLAB, Lab

ESCAPE = os.environ.get("ESCAPE", "")
NO_WALL = os.environ.get("NO_WALL", "")
SECRET = "S3CRET"
CONFIG = """/**:
  ros__parameters:
    environments: ["main"]
    main: {plugins: ["executive", "ros_msgs", "escape", "files"]}
    executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 10}
    ros_msgs: {plugin: "cx::RosMsgsPlugin"}
    escape: {plugin: "escape::Plugin"}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["rules"], load: ["rules.clp"]}
"""
SCENARIO = "schema: 1\nduration_s: 1\npackages: {rules: rules}\nagents:\n  - config: agent.yaml\n"
STORY = "stories:\n- story: tries\n  config: agent.yaml\n  packages: {rules: rules}\n  expect: [{not_fires: nobody, within_s: 1}]\n"
HAS_WALL = "Landlock" in (doctor := subprocess.run([CXLAB, "doctor"], capture_output=True, text=True).stdout) and "no seccomp" not in doctor and "no Landlock" not in doctor


class Behind(Lab):
    def setUp(self):
        super().setUp()
        self.outside = self.folder / "outside"
        (self.outside / "empty").mkdir(parents=True)
        for name in ("secret.txt", "victim.txt"):
            self.write(f"outside/{name}", SECRET)
        self.write("rules/known.txt", "known")
        self.write("rules/cxlab_plugins.yaml", f"library: {ESCAPE}\nplugins:\n  - class: escape::Plugin\n")
        self.write("agent.yaml", CONFIG)
        self.write("rules/agent.yaml", CONFIG)
        self.write("scenario.yaml", SCENARIO)
        self.write("tries.story.yaml", STORY)
        self.other = subprocess.Popen(["sleep", "300"])
        self.addCleanup(self.other.wait)
        self.addCleanup(self.other.kill)
        self.server = socket.socket()
        self.addCleanup(self.server.close)
        self.server.bind(("127.0.0.1", 0))
        self.server.listen(64)
        self.unix = socket.socket(socket.AF_UNIX)
        self.addCleanup(self.unix.close)
        self.unix.bind(str(self.outside / "server.sock"))
        self.unix.listen(64)
        run = self.out
        self.write("rules/rules.clp", f'(defrule try => (escape "{self.outside}" "{self.folder}/rules" "{run}" {self.other.pid} {self.server.getsockname()[1]}))\n')

    def cxlab(self, *arguments, first=(CXLAB,), **environment):
        return subprocess.run([*first, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL, env={**os.environ, **environment})

    def holds(self, said):
        self.assertIn("tried ", said)
        self.assertNotIn("escaped: ", said)
        self.assertEqual((self.outside / "victim.txt").read_text(), SECRET)
        self.assertEqual((self.folder / "rules/known.txt").read_text(), "known")
        self.assertIsNone(self.other.poll(), "the other process lives")
        self.assertEqual(sorted(p.name for p in self.outside.iterdir()), ["empty", "secret.txt", "server.sock", "victim.txt"])


class Wall(Behind):
    @unittest.skipUnless(HAS_WALL, "this kernel has no wall")
    def test_no_escape_comes_through(self):
        done = self.cxlab("run", "scenario.yaml", "--out", "out")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.holds(done.stderr)
        self.assertNotIn("warning: rules are checked", done.stderr)
        for command in (["replay", "out", "--trust-programs"], ["why-not", "out", "try", "--trust-programs"],
                        ["rerun", "out", "--out", "again", "--trust-programs"], ["run", "scenario.yaml", "--out", "none"],
                        ["env", "rules/agent.yaml", "--until", "1", "--out", "none"], ["test", "tries.story.yaml"],
                        ["run", "scenario.yaml", "--sockets", "--out", "sockets"], ["run", "scenario.yaml", "--control", "--out", "control"]):
            with self.subTest(" ".join(command)):
                self.holds(self.cxlab(*command).stderr)
        self.write("suite.yaml", "scenarios: [scenario.yaml]\nseeds: [1]\nstrategies: {one: []}\n")
        self.cxlab("bench", "suite.yaml", "--out", "sweep")
        self.holds("".join(p.read_text() for p in (self.folder / "sweep/rows").glob("*.log")))

    def test_trusted_rules_have_no_wall(self):
        self.write("scenario.yaml", SCENARIO + "trust_rules: true\n")
        self.write("rules/rules.clp", f'(defrule try => (open "{self.outside}/secret.txt" f "r") (printout t (readline f) crlf))\n')
        self.assertIn(SECRET, self.cxlab("run", "scenario.yaml", "--out", "out").stderr)

    def test_run_without_a_wall_warns_once(self):
        self.write("rules/rules.clp", "(defrule nothing =>)\n")
        for command in (["run", "scenario.yaml", "--out", "out"], ["test", "tries.story.yaml"]):
            done = self.cxlab(*command, first=(NO_WALL, CXLAB))
            self.assertEqual(done.stderr.count("warning: "), 1, done.stderr)
            self.assertIn("cxlab doctor", done.stderr)
        self.assertRegex(self.cxlab("doctor", first=(NO_WALL, CXLAB)).stdout, r"note +wall +seccomp, no Landlock; ")

    def test_temporary_folders_go(self):
        self.write("rules/rules.clp", '(defrule w => (open "a/b.txt" f "w") (printout f "b") (close f))\n')
        (self.folder / "tmp").mkdir()
        for command in (["run", "scenario.yaml", "--out", "none"], ["run", "scenario.yaml", "--out", "out"], ["replay", "out", "--trust-programs"],
                        ["why-not", "out", "w", "--trust-programs"]):
            done = self.cxlab(*command, TMPDIR=str(self.folder / "tmp"))
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(list((self.folder / "tmp").iterdir()), [], command)

    @unittest.skipUnless(HAS_WALL, "this kernel has no wall")
    def test_no_file_is_swapped_between_look_and_open(self):
        self.write("rules/rules.clp", '(defrule read => (loop-for-count 20000 (if (open "{0}/rules/f" f "r") then (bind ?l (readline f)) '
                   '(if (str-index "3CR" (str-cat ?l)) then (printout t ?l crlf)) (close f))))\n'.replace("{0}", str(self.folder)))
        self.write("scenario.yaml", SCENARIO + "on_rule_error: continue\n")
        mine, link, name = (self.folder / "rules" / n for n in ("mine", "link", "f"))
        over = threading.Event()

        def swap():
            while not over.is_set():
                mine.write_text("mine")
                mine.rename(name)
                link.symlink_to(self.outside / "secret.txt")
                link.rename(name)

        mine.write_text("mine")
        mine.rename(name)
        swapper = threading.Thread(target=swap)
        swapper.start()
        try:
            said = "".join(self.cxlab("run", "scenario.yaml", "--out", "out", "--force", "--steps", "0").stderr for _ in range(3))
        finally:
            over.set()
            swapper.join()
        self.assertNotIn(SECRET, said)
        for copy in (self.out / "files").iterdir():
            self.assertNotIn(SECRET.encode(), copy.read_bytes())


class Crashes(Behind):
    """The rest of a run whose process crashes."""

    def test_run_that_crashes_names_signal_and_rule_and_keeps_its_folder(self):
        self.write("rules/rules.clp", "(defrule first => (assert (done)))\n(defrule fall\n  (done)\n  (time $? ?t&:(> ?t 0.5))\n  =>\n  (crash))\n")
        for command in (["run", "scenario.yaml"], ["env", "rules/agent.yaml", "--until", "1"]):
            done = self.cxlab(*command, "--out", "out", "--force", "--journal", "full")
            self.assertEqual(done.returncode, 70, done.stderr)
            self.assertRegex(done.stderr, r"rules\.clp:2: environment 'main': rule fall: .*crashed \(SIGSEGV\)")
            result = json.loads((self.out / "result.json").read_text())
            self.assertEqual((result["status"], result["reason"]["code"]), ("failed", "crashed"))
            self.assertIn("rule fall", result["reason"]["message"])
            self.assertIn('"done"', (self.out / "journal.jsonl").read_text())
        self.assertEqual(self.cxlab("run", "scenario.yaml", "--out", "none").returncode, 70)

    def test_cell_that_crashes_fails_alone(self):
        self.write("rules/rules.clp", "(defrule fall (time $? ?t&:(> ?t 0.8)) => (crash))\n")
        self.write("suite.yaml", 'scenarios: [scenario.yaml]\nseeds: [1]\nstrategies:\n  short: ["duration_s=0.5"]\n  whole: []\n')
        done = self.cxlab("bench", "suite.yaml", "--out", "sweep")
        rows = [json.loads(p.read_text()) for p in sorted((self.folder / "sweep/rows").glob("*.json"))]
        self.assertEqual([row["status"] for row in rows], ["completed", "crashed"], done.stderr)
        self.assertEqual(rows[1]["exit"], 70)
        self.assertRegex(rows[1]["errors"][0], r"exit code 70 .*rule fall: .*crashed \(SIGSEGV\)")
        self.assertIn(rows[1]["errors"][0], done.stderr)

    def test_story_that_crashes_fails_alone(self):
        self.write("rules/rules.clp", "(defrule fall (fall) => (crash))\n(defrule stand (stand) => (assert (stood)))\n")
        story = "- story: {0} {1}\n  config: agent.yaml\n  packages: {rules: rules}\n  given: [(TEXT)]\n  expect: [{fires: {0}, within_s: 1}]\n"
        self.write("mixed.story.yaml", "stories:\n" + "".join(story.replace("{0}", "fall" if i == 1 else "stand").replace("{1}", str(i)).replace("TEXT", "fall" if i == 1 else "stand") for i in range(4)))
        for jobs in ("1", "2"):
            done = self.cxlab("test", "mixed.story.yaml", "-j", jobs)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn("3 passed, 1 failed", done.stdout)
            self.assertIn("mixed.story.yaml:7: the process that played this story ended with exit code 70", done.stdout)

    def test_killed_film_has_no_name(self):
        ffmpeg = self.write("bin/ffmpeg", '#!/bin/sh\nfor last; do :; done\nexec cat > "${last#file:}"\n')
        ffmpeg.chmod(0o755)
        environment = {**os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}"}
        films = self.folder / "films"
        films.mkdir()
        command = [CXLAB, "run", "turtlesim/figures", "--video", str(films / "film.mp4"), "--out", "none", "--quiet"]
        playing = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for _ in range(200):
            time.sleep(0.02)
            if any(p.stat().st_size for p in films.iterdir()):
                break
        playing.send_signal(signal.SIGKILL)
        playing.wait()
        for _ in range(200):
            if not list(films.iterdir()):
                break
            time.sleep(0.02)
        self.assertEqual(list(films.iterdir()), [])


class Strangers(Behind):
    """A run folder, a scenario or a machine that somebody else has made."""

    def test_rerun_reads_no_hidden_package_of_a_manifest(self):
        self.write("rules/rules.clp", "(defrule nothing =>)\n")
        self.write("agent.yaml", CONFIG.replace(', "escape"', ""))
        self.write(".keys/key", SECRET)
        self.write("scenario.yaml", SCENARIO.replace("rules: rules", "rules: rules, keys: .keys"))
        self.assertEqual(self.cxlab("run", "scenario.yaml", "--out", "out").returncode, 0)
        done = self.cxlab("rerun", "out", "--out", "again")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("package keys of this run is the hidden folder", done.stderr)
        self.assertEqual(self.cxlab("rerun", "out", "--out", "again", "--trust-rules").returncode, 0)

    def test_packages_elsewhere_are_listed(self):
        self.write("rules/rules.clp", "(defrule nothing =>)\n")
        self.write("agent.yaml", CONFIG.replace(', "escape"', ""))
        (self.folder / "deep").mkdir()
        self.write("deep/scenario.yaml", SCENARIO.replace("rules: rules", "rules: ../rules").replace("agent.yaml", "../agent.yaml"))
        self.assertRegex(self.cxlab("run", "deep/scenario.yaml", "--out", "none").stderr, r"rules may read \S*/rules")

    def test_too_few_descriptors_or_too_little_memory_is_a_shortage(self):
        self.write("agent.yaml", CONFIG.replace(', "escape"', ""))
        self.write("rules/rules.clp", "(defrule nothing =>)\n")
        for limit, values in ((resource.RLIMIT_NOFILE, range(4, 24)), (resource.RLIMIT_AS, (60_000_000, 120_000_000, 200_000_000))):
            for value in values:
                done = subprocess.run([CXLAB, "run", "scenario.yaml", "--out", "none"], cwd=self.folder, capture_output=True, text=True,
                                      preexec_fn=lambda: resource.setrlimit(limit, (value, value)))
                # 127: the loader of programs itself finds no memory.
                self.assertIn(done.returncode, (0, 5, 127), f"{value}: {done.stderr}")


if __name__ == "__main__":
    unittest.main()
