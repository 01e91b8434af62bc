"""Installs cxlab below a prefix, moves it, and builds and runs plugins and programs against it, as a user would."""

import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from pages import RunPage

SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])
BUILD = Path(os.environ["CXLAB_BUILD_DIR"])
CMAKE = os.environ["CMAKE"]

WHOLE_LIFE = ["initialize", "clips_env_init one", "clips_env_init two", "clips_env_destroyed one", "clips_env_destroyed two", "finalize", "gone"]


def call(*arguments, expect=0, cwd=None, **environment):
    done = subprocess.run(list(map(str, arguments)), capture_output=True, text=True, cwd=cwd, timeout=900, env={**os.environ, **environment})
    if done.returncode != expect:
        raise AssertionError(f"{arguments}: exit code {done.returncode}, expected {expect}\n{done.stdout}\n{done.stderr}")
    return done


def build(source, folder, prefix):
    call(CMAKE, "-S", source, "-B", folder, "-D", f"CMAKE_PREFIX_PATH={prefix}", "-D", "CMAKE_BUILD_TYPE=Debug")
    call(CMAKE, "--build", folder, "-j2")


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="cxlab-own-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        call(CMAKE, "--install", BUILD, "--prefix", cls.folder / "first")
        (cls.folder / "first").rename(cls.folder / "prefix")  # an installation may be moved
        cls.prefix = cls.folder / "prefix"
        cls.cxlab = cls.prefix / "bin/cxlab"

    def env(self, config, *arguments, expect=0, **environment):
        return call(self.cxlab, "env", config, "--out", "none", *arguments, expect=expect, cwd=self.folder, **environment)


class OwnPackages(Installed):
    def test_template_of_a_plugin_builds_and_runs_its_test(self):
        folder = self.folder / "my_plugin"
        call(self.cxlab, "new", "plugin", folder)
        build(folder, folder / "build", self.prefix)
        call("ctest", "--test-dir", folder / "build", "--output-on-failure")

        # Installed below a prefix of its own it is found through the option, or through the variable.
        own = self.folder / "own"
        call(CMAKE, "--install", folder / "build", "--prefix", own)
        shutil.rmtree(folder)
        config = self.folder / "demo.yaml"
        shutil.copy(own / "share/my_plugin/params/demo.yaml", config)
        said = self.env(config, "--until", 3, "--prefix", own).stderr
        self.assertIn("three counts make 6", said)
        self.assertNotRegex(said, r"\[(warn|error)\]")
        self.assertIn("three counts make 6", self.env(config, "--until", 3, CXLAB_PREFIX_PATH=str(own)).stderr)
        for answer in (call(self.cxlab, "list", "plugins", "--prefix", own), call(self.cxlab, "doc", "my::MyPluginCounter", "--prefix", own),
                     call(self.cxlab, "doc", CXLAB_PREFIX_PATH=str(own))):
            self.assertIn("my::MyPluginCounter", answer.stdout)
            self.assertIn("my_plugin", answer.stdout)
        self.assertIn("(deftemplate counter", call(self.cxlab, "doc", "counter", "--package", f"my_plugin={own}/share/my_plugin").stdout)
        self.assertNotIn("my::MyPluginCounter", call(self.cxlab, "list", "plugins").stdout)
        story = self.folder / "own.story.yaml"
        story.write_text(f"stories:\n  - {{story: counts, config: {config}, end: 2, expect: [{{fact: (counter), within_s: 2}}]}}\n")
        call(self.cxlab, "test", story, "--prefix", own)
        call(self.cxlab, "test", story, expect=3)
        self.assertIn("unknown plugin type 'my::MyPluginCounter'", self.env(config, "--until", 3, "--no-keep-going", expect=3).stderr)

        # A run keeps the library: its rules play again without it.
        run = self.folder / "run"
        call(self.cxlab, "env", config, "--until", 3, "--out", run, "--prefix", own)
        shutil.rmtree(own)
        for command in (["replay", run, "--rules"], ["why-not", run, "count"], ["rerun", run, "--out", self.folder / "again"]):
            self.assertIn("--trust-programs", call(self.cxlab, *command, expect=2).stderr)
        self.assertIn("rules: the same", call(self.cxlab, "replay", run, "--rules", "--trust-programs").stdout)

    def test_plugins_made_by_names_live_below_one_prefix(self):
        own = self.folder / "several"
        for name in ("new", "time"):  # a keyword, and a function of the C library
            call(self.cxlab, "new", "plugin", self.folder / name)
            build(self.folder / name, self.folder / name / "build", self.prefix)
            call("ctest", "--test-dir", self.folder / name / "build", "--output-on-failure")
            call(CMAKE, "--install", self.folder / name / "build", "--prefix", own)
        for name in ("new", "time"):
            self.assertIn("three counts make 6", self.env(own / f"share/{name}/params/demo.yaml", "--until", 3, "--prefix", own).stderr)
        listed = call(self.cxlab, "list", "plugins", "--prefix", own).stdout
        self.assertIn("my::NewCounter", listed)
        self.assertIn("my::TimeCounter", listed)

    def test_program_of_ones_own_plays_the_same_episode(self):
        build(self.prefix / "share/cxlab/docs/examples/play_episode", self.folder / "play", self.prefix)
        game = self.prefix / "share/cxlab/scenarios/rcll/game.yaml"
        own = call(self.folder / "play/play_episode", game, 130).stdout
        self.assertRegex(own, r"(?m)^ 120.0 s: agent has \d+ facts$")
        result = json.loads(call(self.cxlab, "run", game, "--until", 130, "--out", "none", "--json").stdout)
        self.assertIn(f"journal {result['journal_hash']}", own)

    def test_laboratory_of_ones_own_plays_replays_and_compares(self):
        build(self.prefix / "share/cxlab/docs/examples/own_lab", self.folder / "own_lab", self.prefix)
        done = call(self.folder / "own_lab/own_lab", self.prefix / "share/cxlab/scenarios/rcll/game.yaml", self.folder / "lab")
        self.assertIn("the replay agrees\n", done.stdout)
        self.assertRegex(done.stdout, r"(?m)^game +three +2/2 ")
        self.assertRegex(done.stdout, r"(?m)^game +one +2/2 ")
        self.assertIn("[4/4] game one seed 2: completed, exit 0", done.stderr)

    def test_program_takes_a_seat_and_its_run_replays_without_it(self):
        example, run = self.prefix / "share/cxlab/docs/examples/own_seat", self.folder / "seat_run"
        build(example, self.folder / "own_seat", self.prefix)
        said = call(self.folder / "own_seat/own_seat", example / "canvas.yaml", run).stdout
        self.assertRegex(said, r"(?m)^ 1\.0 s: 0\.0 m driven, 0 times home$")
        driven, home = re.search(r"(?m)^29\.\d s: (\S+) m driven, (\d+) times home$", said).groups()
        self.assertGreater(float(driven), 10)
        self.assertGreaterEqual(int(home), 2)
        self.assertEqual(call(self.folder / "own_seat/own_seat", example / "canvas.yaml", self.folder / "seat_again").stdout, said)
        for file in ("journal.jsonl", "inputs.bin"):
            self.assertEqual((run / file).read_bytes(), (self.folder / "seat_again" / file).read_bytes())
        replayed = call(self.cxlab, "replay", run).stdout
        self.assertIn("rules: the same", replayed)
        self.assertIn("physics: the same", replayed)
        call(self.cxlab, "rerun", run, "--out", self.folder / "seat_rerun")
        self.assertIn("turtle1/pose", call(self.cxlab, "why", run, "turtle-teleport-request").stdout)
        self.assertIn("seat pilot", call(self.cxlab, "rerun", run, "--at", 5, "--assert", "(turtle-out-of-bounds)", expect=2).stderr)

    def test_world_of_ones_own_has_all_commands(self):
        example = self.prefix / "share/cxlab/docs/examples/own_world"
        build(example, self.folder / "own_world", self.prefix)

        def own_world(*arguments, expect=0):
            return call(self.folder / "own_world/own_world", *arguments, expect=expect, cwd=self.folder)

        maze, run = example / "maze.yaml", self.folder / "grid"
        self.assertRegex(own_world("run", maze, "--out", run, "--snapshot", "every:10").stdout, r"^at the goal after \d+ steps and \d+ bumps\n")
        self.assertEqual((run / "index.html").read_text().count("alt=\"grid at "), 5)
        result = json.loads((run / "result.json").read_text())
        self.assertEqual((result["status"], result["grid"]["reached"]), ("completed", True))
        for seed in (1, 2):
            again = json.loads(own_world("run", maze, "--seed", seed, "--out", "none", "--json").stdout)
            self.assertEqual(again["journal_hash"] == result["journal_hash"], seed == 1)
        (lane,) = RunPage(run).lanes()
        self.assertEqual(lane["name"], "robot")
        for kind in ("step", "bump"):
            bars = [bar for bar in lane["bars"] if bar["kind"] == kind and bar["text"] != "step stay"]
            self.assertEqual(len(bars), result["grid"][kind + "s"])
            for bar in bars:
                self.assertAlmostEqual(bar["end"] - bar["begin"], 0.5)
        self.assertIn("rules: the same", own_world("replay", run).stdout)
        own_world("rerun", run, "--out", self.folder / "rerun")
        self.assertIn("turn-back", own_world("why-not", run, "turn-back", "--at", 10).stdout)
        own_world("render", maze, "--at", 10, "--out", self.folder / "grid.png")
        self.assertRegex(own_world("bench", example / "bench.yaml").stdout, r"(?m)^maze +no walls +4/4 +-")
        self.assertRegex(own_world("list", "worlds").stdout, r"(?m)^grid +a robot")
        self.assertIn("world.map[2]: found 2 cells, expected 12", own_world("run", maze, "--set", "world.map[2]=..", expect=3).stderr)
        self.assertIn("found 'grid', expected one of: none, rcll, turtlesim", call(self.cxlab, "run", maze, expect=3).stderr)
        self.assertIn("found 'grid'", call(self.cxlab, "export", run, "--csv", expect=3).stderr)
        self.assertFalse((run / "export").exists())

    def test_shipped_scenarios_play_where_they_are_installed(self):
        for name in (line.split()[0] for line in call(self.cxlab, "list", "scenarios").stdout.splitlines()):
            short = ["--until", 2] if name.startswith("rcll/") else []  # the others expect what their last seconds bring
            said = call(self.cxlab, "run", name, *short, "--out", "none", cwd=self.folder).stderr
            self.assertNotIn("[error]", said, name)

    def test_manual_page_and_completion_are_installed(self):
        share = self.prefix / "share"
        self.assertTrue((share / "man/man1/cxlab.1").read_text().startswith(".TH CXLAB 1"))
        self.assertIn("complete -o filenames -F _cxlab cxlab", (share / "bash-completion/completions/cxlab").read_text())
        self.assertTrue((share / "zsh/site-functions/_cxlab").read_text().startswith("#compdef cxlab"))

    @classmethod
    def examples(cls):
        """The configurations of the examples, which are built once."""
        folder = cls.folder / "own_plugins"
        if not folder.exists():
            build(cls.prefix / "share/cxlab/docs/examples/own_plugins", folder, cls.prefix)
        return folder / "share/own_plugins/params"

    def test_bridge_hands_facts_over_at_the_next_tick_and_replays(self):
        run = self.folder / "bridge"
        said = call(self.cxlab, "env", self.examples() / "bridge.yaml", "--until", 3, "--out", run).stderr
        lines = re.findall(r"\[ *([.\d]+)\] \[info\] \[(eye|hand)\] (.*)", said)
        self.assertNotRegex(said, r"\[(warn|error)\]")
        self.assertEqual([(who, what) for _, who, what in lines], [("hand", "grasping the cup, seen at 1.1"), ("eye", "the hand has the cup")])
        self.assertEqual([float(when) for when, _, _ in lines], [1.2, 1.3])  # executives of 10 Hz
        self.assertIn("rules: the same", call(self.cxlab, "replay", run, "--rules", "--trust-programs").stdout)

    def test_thread_of_a_plugin_posts_facts_and_the_run_replays(self):
        run = self.folder / "sensor"
        said = call(self.cxlab, "env", self.examples() / "sensor.yaml", "--until", 100000, "--out", run).stderr
        self.assertEqual(re.findall(r"reading (\d)", said), ["1", "2", "3"])
        self.assertNotRegex(said, r"\[(warn|error)\]")
        result = json.loads((run / "result.json").read_text())
        self.assertEqual((result["status"], result["deterministic"]), ("stopped", False))
        self.assertIn("rules: the same", call(self.cxlab, "replay", run, "--rules", "--trust-programs").stdout)

    def test_template_of_an_agent_is_installed(self):
        folder = self.folder / "agent"
        call(self.cxlab, "new", "agent", folder)
        call(self.cxlab, "test", cwd=folder)


class HooksInOrder(Installed):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        build(SOURCE / "tests/app/own_plugins", cls.folder / "wrong", cls.prefix)

    def run_plugin(self, plugin, *arguments, expect=0, **parameters):
        """One instance `talk` in two environments, and a rule that calls it. The hooks that the instance logged, and all that was printed."""
        lines = "".join(f"      {name}: {value}\n" for name, value in parameters.items())
        (self.folder / "config.yaml").write_text(f"""
/**:
  ros__parameters:
    environments: ["one", "two"]
    one: {{plugins: ["talk", "files"]}}
    two: {{plugins: ["talk"]}}
    files: {{plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["rules"], load: ["rules.clp"]}}
    talk:
      plugin: "{plugin}"
{lines}""")
        (self.folder / "rules").mkdir(exist_ok=True)
        (self.folder / "rules/rules.clp").write_text("(deffacts start (begin))\n(defrule talk (begin) => (printout info (chat) crlf))\n")
        said = self.env(self.folder / "config.yaml", "--until", 1, "--package", f"rules={self.folder / 'rules'}", "--no-keep-going",
                        "--stop-on-rule-error", *arguments, expect=expect).stderr
        return re.findall(r"^\[[ .\d]+\] \[info\] \[talk\] (.*)$", said, re.MULTILINE), said

    def chatty(self, *arguments, expect=0, **parameters):
        return self.run_plugin("test::Chatty", "--prefix", self.folder / "wrong", *arguments, expect=expect, **parameters)

    def broken(self, manifest, expect):
        folder = self.folder / "broken"
        folder.mkdir(exist_ok=True)
        (folder / "cxlab_plugins.yaml").write_text(manifest)
        return self.run_plugin("test::Broken", "--package", f"broken={folder}", expect=expect)[1]

    def library(self, name):
        return self.broken(f"library: {self.folder}/wrong/lib/{name}\nplugins:\n  - class: test::Broken\n", 5 if "symbol" in name else 3)

    def test_each_hook_is_called_in_its_order(self):
        hooks, said = self.chatty()
        self.assertEqual(hooks, WHOLE_LIFE)
        self.assertIn("[one] 7", said)

    def test_plugin_that_cannot_begin_is_not_finalized(self):
        for how, words in (("throw", "initialize threw: out of words"), ("fail", "initialize: does not want to")):
            hooks, said = self.chatty(expect=4, **{how: "initialize"})
            self.assertEqual(hooks, ["initialize", "gone"])
            self.assertIn(f"plugin 'talk' (test::Chatty of {self.folder}/wrong/lib/libchatty.so): {words}", said)

    def test_plugin_that_refuses_an_environment_is_finalized_and_not_destroyed_there(self):
        for how, words in (("throw", "clips_env_init threw: out of words"), ("fail", "clips_env_init: does not want to")):
            hooks, said = self.chatty(expect=4, **{how: "clips_env_init"})
            self.assertEqual(hooks, ["initialize", "clips_env_init one", "finalize", "gone"])
            self.assertIn(f"libchatty.so): {words}", said)

    def test_plugin_that_throws_at_its_end_gets_all_calls_of_its_end(self):
        for hook in ("clips_env_destroyed", "finalize"):
            hooks, said = self.chatty(throw=hook)
            self.assertEqual(hooks, WHOLE_LIFE)
            self.assertIn("warning: while the agent shut down: ", said)
            self.assertIn(f"libchatty.so): {hook} threw: out of words", said)

    def test_library_is_closed_after_the_last_environment_that_used_it(self):
        steps = [("unload_plugin", "UnloadClipsPlugin", "{env_name: one, plugin_name: talk}"), ("destroy_env", "DestroyClipsEnv", "{env_name: two}"),
                 ("destroy_env", "DestroyClipsEnv", "{env_name: one}"), ("create_env", "CreateClipsEnv", "{env_name: two}")]
        (self.folder / "stimuli.yaml").write_text("".join(
            f"- {{at: {0.2 * (i + 1):.1f}, call: /clips_manager/{name}, type: cx_msgs/srv/{kind}, request: {request}}}\n"
            for i, (name, kind, request) in enumerate(steps)))
        hooks, said = self.chatty("--stimuli", self.folder / "stimuli.yaml")
        life = ["initialize", "clips_env_init one", "clips_env_init two", "clips_env_destroyed one", "clips_env_destroyed two", "finalize", "gone"]
        again = ["initialize", "clips_env_init two", "clips_env_destroyed two", "finalize", "gone"]
        self.assertEqual(hooks, life + again)
        # The plugin has left both environments after 0.4 s; `one`, which had used it, holds its code until 0.6 s.
        marks = [said.index("[talk] finalize"), said.index("the library is closed"), said.index("[talk] clips_env_init two", said.index("[talk] finalize"))]
        self.assertEqual(marks, sorted(marks))
        between = said[marks[0]:marks[1]]
        self.assertRegex(between, r"\[ +0.6\d*\]")

    def test_function_that_throws_is_an_error_of_the_rule(self):
        hooks, said = self.chatty(expect=4, throw="chat")
        self.assertEqual(hooks, WHOLE_LIFE)
        self.assertRegex(said, r"rules.clp:2: rule talk, RHS: .*no words")

    def test_disorder_in_clips_ends_a_run_as_a_bug_with_the_rule_and_a_result(self):
        self.chatty()  # writes the rules
        (self.folder / "disorder.yaml").write_text("""
/**:
  ros__parameters:
    environments: ["one"]
    one: {plugins: ["talk", "files"]}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["rules"], load: ["rules.clp"]}
    talk: {plugin: "test::Chatty", fail: clips}
""")
        (self.folder / "scenario.yaml").write_text(
            f"schema: 1\nworld: {{kind: none}}\nduration_s: 2\nagents:\n  - {{config: disorder.yaml, packages: {{rules: {self.folder / 'rules'}}}}}\n")
        run = self.folder / "disorder"
        said = call(self.cxlab, "run", self.folder / "scenario.yaml", "--prefix", self.folder / "wrong", "--out", run, expect=70).stderr
        self.assertRegex(said, r"rules\.clp:2: environment 'one': rule talk: CLIPS found")
        result = json.loads((run / "result.json").read_text())
        self.assertEqual((result["status"], result["reason"]["code"]), ("failed", "bug"))
        self.assertIn("rule talk", result["reason"]["message"])

    def test_a_fault_of_a_library_is_reported_with_the_place_in_its_manifest(self):
        manifest = f"{self.folder}/broken/cxlab_plugins.yaml"
        said = self.broken("library: libnone.so\nplugins:\n  - class: test::Broken\n", 5)
        self.assertIn(f"{manifest}:1: library 'libnone.so' is not there (looked for {self.folder}/broken/libnone.so", said)
        self.assertRegex(self.library("libother_abi.so"), re.escape(manifest) + r":1: .*was built for cxlab 0.0.1 .*build it again")
        self.assertRegex(self.library("libno_exports.so"), re.escape(manifest) + r":1: .*CXLAB_PLUGINS")
        self.assertRegex(self.library("libmissing_symbol.so"), re.escape(manifest) + r":1: .*undefined symbol: .*defined_nowhere")
        self.assertRegex(self.library("libchatty.so"), re.escape(manifest) + r":3: .*no plugin class 'test::Broken', its CXLAB_PLUGINS names test::Chatty")

    def test_manifest_that_is_wrong_is_an_error_with_its_line(self):
        manifest = f"{self.folder}/broken/cxlab_plugins.yaml"
        self.assertIn(f"{manifest}:2: key 'plugins' is missing, did you mean it by 'plugin'?", self.broken("library: libx.so\nplugin: []\n", 3))
        self.assertIn(f"{manifest}:4: ", self.broken("library: libx.so\nplugins:\n  - class: test::Broken\n    base: cx::ClipsPlugin\n", 3))
        twice = self.broken("library: libx.so\nplugins:\n  - class: test::Broken\n  - class: test::Broken\n", 3)
        self.assertIn(f"{manifest}:4: found the plugin class 'test::Broken', which {manifest}:3 has too, expected a name of its own", twice)
        ours = self.broken("library: libx.so\nplugins:\n  - class: cx::ConfigPlugin\n", 3)
        self.assertIn(f"{manifest}:3: found the plugin class 'cx::ConfigPlugin', which cxlab has too", ours)


if __name__ == "__main__":
    unittest.main()
