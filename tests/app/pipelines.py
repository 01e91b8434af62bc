"""cxlab new agent --ci: the commands of both pipelines, as they stand in the files, with the installed program as a tarball.

    ./dev test -R app_pipelines         in this system
    ./dev readers -R readers_pipelines  in a bare Debian 12, which it makes in build/readers; as root
"""

import hashlib
import http.server
import json
import os
import re
import shutil
import subprocess
import tempfile
import threading
import time
import unittest
from functools import partial
from pathlib import Path

SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])
BUILD = Path(os.environ["CXLAB_BUILD_DIR"])
GITHUB = ".github/workflows/agent.yml"
GITLAB = ".gitlab-ci.yml"


def commands_of(file):
    """What a pipeline runs, in its order: `run:` of GitHub, the list below `script:` of GitLab."""
    text = file.read_text()
    if file.suffix == ".yml" and "runs-on:" in text:
        return re.findall(r"^ +run: (.+)$", text, re.MULTILINE)
    return re.findall(r"^ +- (.+)$", re.search(r"^  script:\n((?:    - .+\n)+)", text, re.MULTILINE)[1], re.MULTILINE)


def make_tarball(folder):
    """The program of the tarball that `cpack` makes, the tarball, and its hash."""
    subprocess.run(["cpack", "--config", BUILD / "CPackConfig.cmake", "-B", folder / "made"], check=True, capture_output=True, timeout=600)
    tarball = next((folder / "made").glob("cxlab-*.tar.gz")).rename(folder / "cxlab.tar.gz")
    (folder / "unpacked").mkdir()
    subprocess.run(["tar", "-xf", tarball, "-C", folder / "unpacked", "--strip-components=1"], check=True, timeout=600)
    return folder / "unpacked/bin/cxlab", tarball, hashlib.sha256(tarball.read_bytes()).hexdigest()


class Pipelines(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="cxlab-pipelines-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.cxlab, cls.tarball, cls.sha256 = make_tarball(cls.folder)

    def new_agent(self, name, *options, address=None, sha256=None, expect=0):
        agent = self.folder / name
        shutil.rmtree(agent, ignore_errors=True)
        tarball = ["--cxlab", address or str(self.tarball), "--sha256", sha256 or self.sha256]
        done = subprocess.run([self.cxlab, "new", "agent", agent, *options, "--ci", *tarball], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, expect, done.stderr)
        self.assertNotIn("does not say yet", done.stderr)  # it has the address
        return agent if expect == 0 else done

    def run_step(self, command, folder):
        return subprocess.run(["sh", "-c", command], cwd=folder, capture_output=True, text=True, timeout=900)

    def play(self, agent, pipeline=GITHUB):
        """The commands up to the first that fails: (command, exit code, what it said) of each."""
        played = []
        for command in commands_of(agent / pipeline):
            done = self.run_step(command, agent)
            played.append((command, done.returncode, done.stdout + done.stderr))
            if done.returncode != 0:
                break
        return played

    def assert_passes(self, agent, pipeline):
        played = self.play(agent, pipeline)
        self.assertEqual([code for _, code, _ in played], [0] * len(commands_of(agent / pipeline)), played[-1])


class OnThisSystem(Pipelines):
    def test_both_pipelines_have_the_same_commands(self):
        agent = self.new_agent("same_agent", "--rcll")
        self.assertEqual(commands_of(agent / GITHUB), commands_of(agent / GITLAB))
        self.assertEqual([re.sub(r"^\S+ (\S+).*", r"\1", command) for command in commands_of(agent / GITHUB)],
                         ["ci/get_cxlab.sh", "check", "test", "bench"])

    def test_a_new_agent_passes(self):
        for options in ([], ["--rcll"]):
            agent = self.new_agent("new_agent", *options)
            self.assert_passes(agent, GITLAB)
            for page in ("stories.xml", "coverage.info", "coverage.html", "suite/rows.csv", "suite/runs.sqlite", "suite/index.html"):
                self.assertGreater((agent / "pages" / page).stat().st_size, 0, page)

    def test_each_step_can_fail(self):
        agent = self.new_agent("failing_agent", "--rcll")
        rules = agent / "clips/agent.clp"
        whole = rules.read_text()

        rules.write_text(whole.replace('(defrule step-ended', '(defrule step-ended-twice (stap) => )\n\n(defrule step-ended'))
        command, code, _ = self.play(agent)[-1]
        self.assertIn(" check ", command)
        self.assertNotEqual(code, 0)

        # No story sees this one.
        rules.write_text(worse_rule(whole))
        command, code, said = self.play(agent)[-1]
        self.assertIn(" bench ", command, said)
        self.assertEqual(code, 1, said)
        self.assertRegex(said, r"mean\(points\) >= 90 +worse")

        story = agent / "stories/agent.story.yaml"
        story.write_text(story.read_text().replace("within_s: 20}", "within_s: 4}"))
        command, code, _ = self.play(agent)[-1]
        self.assertIn(" test ", command)
        self.assertEqual(code, 1)
        self.assertEqual(len(list((agent / "pages/failed").iterdir())), 1)

    def test_the_tarball_is_the_one_that_is_named(self):
        for line, said in ((f"sha256 {'0' * 64}", f"has the sha256 {self.sha256}, expected {'0' * 64}"),
                           ("address ../nowhere.tar.gz", "the tarball ../nowhere.tar.gz cannot be read")):
            agent = self.new_agent("other_agent")
            lock = agent / "ci/cxlab.txt"
            lock.write_text(re.sub(rf"(?m)^{line.split()[0]} .*$", line, lock.read_text()))
            done = self.run_step("sh ci/get_cxlab.sh", agent)
            self.assertEqual(done.returncode, 1)
            self.assertIn(said, done.stderr)

        agent = self.folder / "unnamed_agent"
        made = subprocess.run([self.cxlab, "new", "agent", agent, "--ci"], check=True, capture_output=True, text=True, timeout=60)
        self.assertIn("ci/cxlab.txt", made.stderr)
        done = self.run_step("sh ci/get_cxlab.sh", agent)
        self.assertEqual((done.returncode, done.stderr), (1, "ci/cxlab.txt: there is no address: write where the tarball of cxlab lies\n"))

        agent = self.new_agent("kept_agent")
        for _ in range(2):  # the second time it is there already
            self.assertEqual(self.run_step("sh ci/get_cxlab.sh", agent).returncode, 0)
        self.tarball.rename(self.tarball.with_suffix(".away"))
        self.addCleanup(lambda: self.tarball.with_suffix(".away").rename(self.tarball))
        self.assertEqual(self.run_step("sh ci/get_cxlab.sh", agent).returncode, 0)

    def test_both_pipelines_keep_the_program_until_the_tarball_changes(self):
        agent = self.new_agent("cached_agent")
        github, gitlab = (agent / GITHUB).read_text(), (agent / GITLAB).read_text()
        self.assertRegex(github, r"(?s)uses: actions/cache@v4\n +with:\n +path: \.cxlab\n +key: cxlab-\$\{\{ hashFiles\('ci/cxlab\.txt'\) \}\}\n.*get_cxlab")
        self.assertIn("  cache:\n    key:\n      files: [ci/cxlab.txt]\n    paths: [.cxlab]\n", gitlab)

    def test_a_new_agent_names_no_place_of_this_machine(self):
        for options in ([], ["--rcll"]):
            agent = self.new_agent("plain_agent", *options, address="https://files.example.org/cxlab.tar.gz")
            for file in agent.rglob("*"):
                if file.is_file():
                    self.assertNotIn(str(self.folder), file.read_text(), file)
        self.assertTrue((self.new_agent("plain_agent") / "README.md").read_text().endswith("`.cxlab/share/cxlab/scenarios/rcll/agent`.\n"))
        self.assertTrue((self.folder / "unpacked/share/cxlab/scenarios/rcll/agent").is_dir(), "ci/get_cxlab.sh unpacks it")

    def test_what_the_pipelines_cannot_use_is_said(self):
        def said(*tarball):
            agent = self.folder / "noted_agent"
            shutil.rmtree(agent, ignore_errors=True)
            return subprocess.run([self.cxlab, "new", "agent", agent, "--ci", *tarball], check=True, capture_output=True, text=True, timeout=60).stderr
        self.assertIn(f"ci/cxlab.txt names the file {self.tarball}: the pipelines find it only if it is in the repository", said("--cxlab", self.tarball, "--sha256", self.sha256))
        address = "https://files.example.org/cxlab.tar.gz"
        self.assertIn("ci/cxlab.txt has no SHA-256 yet", said("--cxlab", address))
        self.assertNotIn("note: ", said("--cxlab", address, "--sha256", self.sha256))

    def test_wrong_options_are_named(self):
        self.assertIn(f"found '{'0' * 64}', expected {self.sha256}, the one of {self.tarball}", self.new_agent("wrong_agent", sha256="0" * 64, expect=2).stderr)
        self.assertIn("64 hexadecimal digits", self.new_agent("wrong_agent", sha256="abc", expect=2).stderr)
        self.assertIn("without blanks", self.new_agent("wrong_agent", address="a b", expect=2).stderr)
        done = subprocess.run([self.cxlab, "new", "agent", self.folder / "wrong_agent", "--cxlab", "x"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--ci", done.stderr)
        self.assertFalse((self.folder / "wrong_agent").exists())


def worse_rule(rules):
    """The rules of the template, but an order is begun only where 200 s are left for it."""
    changed = rules.replace("?now&:(< ?now (+ ?zero ?end))", "?now&:(< (+ ?now 200) (+ ?zero ?end))")
    if changed == rules:
        raise AssertionError("the template has no such condition any more: change worse_rule")
    return changed


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@unittest.skipUnless("CXLAB_READERS" in os.environ, "needs a bare Debian 12: ./dev readers -R pipelines")
class InBareDebian(Pipelines):
    """As a machine of GitHub or GitLab sees it: a bare Debian 12, and a tarball behind an address."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        kept = Path(os.environ["CXLAB_READERS"]) / "debian12"
        if not (kept / "whole").exists():
            shutil.rmtree(kept, ignore_errors=True)
            sources = subprocess.run(["apt-get", "indextargets", "--format", "$(REPO_URI)", "Codename: bookworm", "Created-By: Packages"],
                                     check=True, capture_output=True, text=True).stdout.split()
            subprocess.run(["debootstrap", "--variant=minbase", "bookworm", kept, sources[0]], check=True, capture_output=True, timeout=1800)
            (kept / "whole").touch()
        cls.debian = cls.folder / "debian12"
        subprocess.run(["cp", "-a", kept, cls.debian], check=True)

    def run_step(self, command, folder):
        inside = f"mount --bind /proc {self.debian}/proc && mount --bind /dev {self.debian}/dev && exec chroot {self.debian} sh -c \"$0\""
        return subprocess.run(["unshare", "--mount", "sh", "-c", inside, f"cd /builds/{folder.name} && {command}"], capture_output=True,
                              text=True, timeout=900)

    def setUp(self):
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=self.folder))
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        self.address = f"http://127.0.0.1:{server.server_port}/cxlab.tar.gz"

    def test_both_pipelines_pass_in_under_ten_minutes(self):
        for pipeline in (GITHUB, GITLAB):
            agent = self.new_agent("bare_agent", "--rcll", address=self.address)
            there = self.debian / "builds/bare_agent"
            shutil.rmtree(there, ignore_errors=True)
            shutil.copytree(agent, there)
            begin = time.monotonic()
            self.assert_passes(there, pipeline)
            seconds = time.monotonic() - begin
            print(json.dumps({"pipeline": pipeline, "seconds": round(seconds, 1)}))
            self.assertLess(seconds, 600)

        rules = there / "clips/agent.clp"
        rules.write_text(worse_rule(rules.read_text()))
        command, code, said = self.play(there)[-1]
        self.assertIn(" bench ", command)
        self.assertEqual(code, 1, said)


if __name__ == "__main__":
    unittest.main()
