"""An agent in rules is trained by its rewards: docs/examples/rl, blocks that become a tower."""

import csv
import json
import subprocess

from lab import CXLAB, SOURCE, Lab

EXAMPLE = SOURCE / "docs/examples/rl"
# Asks what to do with the tower almost built, and stops.
ASKS = """(defrule ask
  (not (asked))
  =>
  (assert (asked))
  (cx-rl-interfaces-get-status-create-client "/cx_rl_node/get_status")
  (cx-rl-interfaces-exec-action-selection-create-client "/cx_rl_node/exec_action_selection")
  (bind ?status (cx-rl-interfaces-get-status-request-create))
  (cx-rl-interfaces-get-status-send-request ?status "/cx_rl_node/get_status")
  (bind ?request (cx-rl-interfaces-exec-action-selection-request-create))
  (bind ?all (create$))
  (progn$ (?on (create$ "b c" "a table" "c table"))
    (bind ?one (cx-rl-interfaces-observation-create-message))
    (cx-rl-interfaces-observation-set-field ?one "name" "on")
    (cx-rl-interfaces-observation-set-field ?one "params" (explode$ ?on))
    (bind ?all ?all ?one))
  (cx-rl-interfaces-exec-action-selection-request-set-field ?request "observations" ?all)
  (bind ?moves (create$))
  (progn$ (?move (create$ "b table" "b a" "a b"))
    (bind ?one (cx-rl-interfaces-action-create-message))
    (cx-rl-interfaces-action-set-field ?one "name" "move")
    (cx-rl-interfaces-action-set-field ?one "params" (explode$ ?move))
    (bind ?moves ?moves ?one))
  (cx-rl-interfaces-exec-action-selection-request-set-field ?request "actions" ?moves)
  (cx-rl-interfaces-exec-action-selection-request-set-field ?request "action_ids" (create$ one two three))
  (cx-rl-interfaces-exec-action-selection-send-request ?request "/cx_rl_node/exec_action_selection"))
(defrule status
  (cx-rl-interfaces-get-status-response (msg-ptr ?m))
  =>
  (printout t "mode " (cx-rl-interfaces-get-status-response-get-field ?m "mode")
    " loaded " (cx-rl-interfaces-get-status-response-get-field ?m "model_loaded") crlf))
(defrule answer
  (cx-rl-interfaces-exec-action-selection-response (msg-ptr ?m))
  =>
  (printout t "chosen " (cx-rl-interfaces-exec-action-selection-response-get-field ?m "action_id") crlf)
  (cx-shutdown))
"""
CONFIG = """clips_manager:
  ros__parameters:
    environments: ["main"]
    main: {plugins: ["executive", "status", "selection", "observation", "action", "files"]}
    executive: {plugin: "cx::ExecutivePlugin"}
    status: {plugin: "cx::CXCxRlInterfacesGetStatusPlugin"}
    selection: {plugin: "cx::CXCxRlInterfacesExecActionSelectionPlugin"}
    observation: {plugin: "cx::CXCxRlInterfacesObservationPlugin"}
    action: {plugin: "cx::CXCxRlInterfacesActionPlugin"}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["asks"], load: ["asks.clp"]}
"""


class Training(Lab):
    def train(self, *parameters, out="out", code=0, config=EXAMPLE / "example.yaml"):
        arguments = [word for p in parameters for word in ("--param", "cx_rl_node." + p)]
        done = subprocess.run([CXLAB, "env", config, "--package", f"example={EXAMPLE}", "--with", "cx_rl_node", *arguments,
                               "--until", "600", "--out", self.folder / out], text=True, timeout=60, cwd=self.folder,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, code, done.stdout)
        return done.stdout

    def episodes(self, out="out"):
        with open(self.folder / out / "training.csv") as file:
            return [(int(r["steps"]), float(r["reward"]), r["end"]) for r in csv.DictReader(file)]

    def test_short_it_learns_the_shortest_way(self):
        said = self.train("max_episodes=60")
        self.assertIn("trained 60 episodes", said)
        self.assertNotIn("[warn]", said)
        episodes = self.episodes()
        self.assertEqual(len(episodes), 60)
        # Off with c, b onto it, a onto that: 3 moves cost 3, the tower gives 20.
        self.assertTrue(all(steps >= 3 and end == "end" and reward == 20 - steps for steps, reward, end in episodes), episodes)
        self.assertGreaterEqual([steps for steps, _, _ in episodes[-20:]].count(3), 18)
        decisions = [json.loads(line)["data"] for line in open(self.out / "journal.jsonl") if '"decision"' in line]
        self.assertEqual([(d["steps"], d["reward"], d["end"]) for d in decisions], episodes)
        self.assertIs(json.loads((self.out / "result.json").read_text())["deterministic"], True)

    def test_short_the_spaces_are_written(self):
        self.assertNotIn("nobody serves", self.train("max_episodes=1"))
        spaces = json.loads((self.out / "spaces.json").read_text())
        self.assertEqual((len(spaces["observables"]), len(spaces["actions"])), (3 * 4, 3 * 4 + 1))
        self.assertEqual(spaces["actions"][:2], ["no-op", "move(a#a)"])

    def test_short_a_choice_that_nobody_makes_is_a_warning(self):
        self.train("max_episodes=1", "policy=external")
        warning = "/cx_rl_node: nobody answered decision 1; with the policy external a program at a seat chooses"
        self.assertEqual(json.loads((self.out / "result.json").read_text())["warnings"], [warning])

    def test_short_by_chance_it_does_not(self):
        self.train("max_episodes=60", "policy=random")
        self.assertGreater(sum(steps for steps, _, _ in self.episodes()[-20:]), 100)
        self.assertFalse((self.out / "model.json").exists())

    def test_short_the_same_training_again(self):
        for out in ("one", "two"):
            self.train("max_episodes=10", out=out)
        for name in ("training.csv", "model.json", "journal.jsonl"):
            self.assertEqual((self.folder / "one" / name).read_bytes(), (self.folder / "two" / name).read_bytes(), name)
        replayed = subprocess.run([CXLAB, "replay", self.folder / "one"], text=True, timeout=60, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT)
        self.assertEqual(replayed.returncode, 0, replayed.stdout)

    def test_short_what_was_learned_chooses(self):
        self.train("max_episodes=60")
        config = self.write("asks/params/asks.yaml", CONFIG)
        self.write("asks/asks.clp", ASKS)
        arguments = [CXLAB, "env", config, "--package", f"asks={self.folder / 'asks'}", "--with", "cx_rl_node", "--out", self.folder / "asked",
                     "--param", "cx_rl_node.rl_mode=EXECUTION"]
        done = subprocess.run([*arguments, "--param", f"cx_rl_node.model={self.out / 'model.json'}"], text=True, timeout=60,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("mode EXECUTION loaded TRUE", done.stdout)
        self.assertIn("chosen three", done.stdout)
        self.assertIn('"nodes/rl/model.json"', (self.folder / "asked/files/index.jsonl").read_text())

    def test_short_steps_of_an_episode_have_an_end(self):
        self.train("max_episodes=3", "max_steps=2")
        self.assertEqual([(steps, end) for steps, _, end in self.episodes()], [(2, "max_steps")] * 3)

    def test_short_no_agent(self):
        config = self.write("asks/params/asks.yaml", CONFIG)
        self.write("asks/asks.clp", "(defrule nothing (never) =>)")
        done = subprocess.run([CXLAB, "env", config, "--package", f"asks={self.folder / 'asks'}", "--with", "cx_rl_node", "--out", "none",
                               "--until", "8"], text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual(done.stdout.count("nobody serves the action /cx_rl_node/reset_env"), 1, done.stdout)

    def test_short_wrong_inputs(self):
        self.write("bad.json", "{\"s\": 1}")
        for parameter, text in [("gamma=2", "gamma: must be from 0 to 1"), ("max_episodes=0", "max_episodes: must be 1 or more"),
                                ("max_steps=-1", "max_steps: must be 1 or more"), ("rl_mode=TRAIN", "TRAINING"),
                                ("policy=deep", "q_table"), ("model=bad.json", "not a table of values"),
                                ("model=nothing.json", "nothing.json"), ("learning_rate=x", "learning_rate"),
                                ("robots=0", "robots: must be 1 or more"), ("no_op=true", "no_op: only the policy external"),
                                ("epsilon=1", "epsilon")]:
            with self.subTest(parameter):
                self.assertIn(text, self.train(parameter, out=parameter.replace("=", "-"), code=3))
