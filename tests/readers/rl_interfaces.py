"""cxlab.rl.CXEnv: the agent of docs/examples/rl, in rules, is trained with Gymnasium. ./dev readers"""

import json
import subprocess
import sys
import unittest
import warnings

import numpy as np
from cxlab.errors import InputError, RunError, UsageError
from cxlab.rl import CXEnv
from gymnasium.utils.env_checker import check_env
from lab import CXLAB, SOURCE, Lab

EXAMPLE = SOURCE / "docs/examples/rl"


def blocks(**options):
    return CXEnv(EXAMPLE / "example.yaml", packages={"example": EXAMPLE}, **options)


def any_allowed(env, chance):
    return int(chance.choice(env.action_masks().nonzero()[0]))


class Interfaces(Lab):
    def env(self, **options):
        env = blocks(**options)
        self.addCleanup(env.close)
        return env

    def play(self, env, seed, steps=60):
        """Play random actions, episode after episode, and return what came of them."""
        chance = np.random.default_rng(seed)
        seen = []
        observation, info = env.reset(seed=seed)
        for _ in range(steps):
            action = any_allowed(env, chance)
            observation, reward, terminated, truncated, info = env.step(action)
            seen.append((observation.tobytes(), action, reward, terminated, truncated, info["robot"], info["outcome"], info["time"]))
            if terminated or truncated:
                observation, info = env.reset()
        return seen

    def test_gymnasium_finds_no_fault(self):
        env = self.env()
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", message=".*not within the .* spec.*|.*render.*|.*spec is None.*")
            check_env(env, skip_render_check=True)

    def test_spaces_are_those_of_the_agent(self):
        env = self.env()
        self.assertEqual(env.actions[0], "no-op")
        self.assertEqual(env.observables, sorted(env.observables))
        self.assertEqual((len(env.observables), len(env.actions)), (3 * 4, 3 * 4 + 1))
        observation, info = env.reset(seed=1)
        true = {name for name, bit in zip(env.observables, observation) if bit}
        self.assertEqual(true, {"on(c#a)", "on(a#table)", "on(b#table)"})
        self.assertEqual({env.actions[i] for i in env.action_masks().nonzero()[0]}, {"move(c#b)", "move(c#table)", "move(b#c)"})
        self.assertEqual(info["robot"], "robot1")

    def test_a_step_does_what_it_says(self):
        env = self.env()
        env.reset(seed=1)
        for move, reward in (("move(c#table)", -1), ("move(b#c)", -1), ("move(a#b)", 19)):
            observation, got, terminated, truncated, info = env.step(env.actions.index(move))
            self.assertEqual(got, reward)
        self.assertEqual((terminated, truncated, info["outcome"], info["robot"]), (True, False, "end", ""))
        self.assertEqual({name for name, bit in zip(env.observables, observation) if bit}, {"on(a#b)", "on(b#c)", "on(c#table)"})
        self.assertFalse(env.action_masks().any())
        with self.assertRaisesRegex(UsageError, "call reset"):
            env.step(1)
        observation, _ = env.reset()
        self.assertTrue(observation[env.observables.index("on(c#a)")])

    def test_the_same_seed_and_choices_give_the_same(self):
        first, second = self.play(self.env(), 5), self.play(self.env(), 5)
        self.assertEqual(first, second)
        env = self.env()
        self.play(env, 4)
        self.assertEqual(self.play(env, 5), first)

    def test_an_episode_may_be_given_up_or_cut(self):
        env = self.env(max_steps=2)
        env.reset(seed=1)
        env.step(env.actions.index("move(c#table)"))
        observation, _ = env.reset()
        self.assertTrue(observation[env.observables.index("on(c#a)")])
        env.step(env.actions.index("move(c#table)"))
        _, _, terminated, truncated, info = env.step(env.actions.index("move(c#a)"))
        self.assertEqual((terminated, truncated, info["outcome"]), (False, True, "max_steps"))

    def test_what_the_mask_forbids_changes_nothing(self):
        env = self.env(max_steps=4)
        before, info = env.reset(seed=1)
        for wrong in (env.actions.index("move(a#b)"), 0):
            with self.subTest(wrong):
                self.assertFalse(env.action_masks()[wrong])
                after, reward, terminated, truncated, later = env.step(wrong)
                self.assertEqual((after.tobytes(), reward, terminated, truncated, later["invalid"]), (before.tobytes(), 0, False, False, True))
                self.assertGreaterEqual(later["time"], info["time"] + 1)
                info = later
        for wrong in (len(env.actions), -1):
            with self.subTest(wrong), self.assertRaisesRegex(UsageError, f"action: found {wrong}, expected an action from 0 to 12"):
                env.step(wrong)
        self.assertNotIn("invalid", env.step(env.actions.index("move(c#b)"))[4])
        self.assertTrue(env.step(0)[3])  # the fourth step

    def test_a_game_ends_whatever_is_chosen(self):
        env = self.env(max_steps=30)
        env.reset(seed=1)
        chance = np.random.default_rng(1)
        steps = 1
        while not any(env.step(int(chance.integers(len(env.actions))))[2:4]):
            steps += 1
        self.assertLessEqual(steps, 30)

    def test_no_op_leaves_the_robot_idle(self):
        env = self.env(no_op=True)
        before, info = env.reset(seed=1)
        self.assertTrue(env.action_masks()[0])
        after, reward, terminated, _, later = env.step(0)
        self.assertEqual((before.tobytes(), 0, False), (after.tobytes(), reward, terminated))
        self.assertGreaterEqual(later["time"], info["time"] + 1)

    def test_the_example_learns_the_shortest_way(self):
        script = SOURCE / "python/examples/blocks_q_learning.py"
        done = subprocess.run([sys.executable, script, EXAMPLE], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        lengths = [int(line.split()[2]) for line in done.stdout.splitlines()]
        self.assertEqual(len(lengths), 60)
        self.assertGreaterEqual(min(lengths), 3)
        self.assertGreaterEqual(lengths[-20:].count(3), 15, lengths)

    def test_a_training_is_a_run_that_replays(self):
        env = self.env(out=self.folder / "run", journal="full")
        self.play(env, 1, steps=20)
        env.reset()
        env.close()
        for folder in ("run", "run-2"):  # reset(seed) begins anew
            done = subprocess.run([CXLAB, "replay", self.folder / folder], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("given up", (self.folder / "run-2/training.csv").read_text())

    def test_a_scenario_may_be_played(self):
        file = self.write("training.yaml", "schema: 1\nseed: 1\nduration_s: 100000\nservers: [{node: cx_rl_node, policy: external, max_episodes: 1000}]\n"
                          f"agents: [{{config: {EXAMPLE / 'example.yaml'}, packages: {{example: {EXAMPLE}}}}}]\n")
        env = CXEnv(file, set={"servers[0].max_steps": 1})
        self.addCleanup(env.close)
        env.reset(seed=3)
        self.assertEqual(env.step(env.actions.index("move(c#b)"))[3], True)
        with self.assertRaisesRegex(UsageError, "packages and params are for configurations"):
            CXEnv(file, packages={"a": "b"})

    def test_what_goes_wrong_has_its_reason(self):
        with self.assertRaisesRegex(InputError, "none.yaml"):
            CXEnv("none.yaml")
        with self.assertRaisesRegex((InputError, UsageError), "robots: must be 1 or more"):
            self.env(robots=0)
        with self.assertRaisesRegex(UsageError, "set is for scenarios"):
            self.env(set={"a": 1})
        text = (EXAMPLE / "blocks.clp").read_text()
        self.write("example/blocks.clp", text.replace('"predicate_names" (create$ on)', '"predicate_names" (create$)').replace('"param_counts" (create$ 2)', '"param_counts" (create$)'))
        with self.assertRaisesRegex(InputError, "offers no spaces"):
            CXEnv(EXAMPLE / "example.yaml", packages={"example": self.folder / "example"})
        self.write("example/blocks.clp", text.replace("(finish ?goal ?id))", "(cx-shutdown))"))
        env = CXEnv(EXAMPLE / "example.yaml", packages={"example": self.folder / "example"})
        with self.assertRaisesRegex(RunError, "the run ended in the middle of an episode"):
            env.step(env.actions.index("move(c#b)")) if env.reset() else None


SHORT = {"world.exploration": False, "world.down": False, "world.production_s": 300, "world.overtime_s": 0}


class Factory(Lab):
    """A game of the Logistics League over the same interfaces: the rules of rcll/rl serve their choices."""

    def env(self, **options):
        env = CXEnv("rcll/rl", set={"tier": "timed", **SHORT, **options.pop("set", {})}, **options)
        self.addCleanup(env.close)
        return env

    def game(self, env, actions, **options):
        """A game with random allowed actions, by their seed: all that was seen."""
        chance = np.random.default_rng(actions)
        observation, info = env.reset(**options)
        seen, over = [observation.tobytes()], False
        while not over:
            action = any_allowed(env, chance)
            observation, reward, terminated, truncated, info = env.step(action)
            seen.append((observation.tobytes(), action, reward, info["robot"], info["outcome"], info["time"]))
            over = terminated or truncated
        self.assertEqual((terminated, info["outcome"]), (True, "end"))
        return seen

    def test_gymnasium_finds_no_fault(self):
        env = self.env()
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", message=".*not within the .* spec.*|.*render.*|.*spec is None.*")
            check_env(env, skip_render_check=True)

    def test_the_spaces_are_those_of_the_choices(self):
        env = self.env()
        self.assertEqual(len(env.observables), 2 + 8 * 8 + 16 * 21 * 8)
        self.assertEqual(sorted(env.actions), sorted(["no-op", *(f"choose({number + 1})" for number in range(16))]))

    def test_a_whole_game_gives_its_points(self):
        for robots, no_op in ((1, False), (4, True)):
            with self.subTest(robots=robots):
                env = self.env(set={"servers[0].robots": robots, "servers[0].no_op": no_op}, out=self.folder / str(robots))
                seen = self.game(env, 3, seed=3)
                self.assertEqual({robot for _, _, _, robot, _, _ in seen[1:-1]}, {"team", "robot1", "robot2", "robot3"})
                env.close()
                result = json.loads((self.folder / f"{robots}-2" / "result.json").read_text())
                self.assertEqual(sum(reward for _, _, reward, _, _, _ in seen[1:]), result["teams"]["CYAN"]["points"])
                replayed = subprocess.run([CXLAB, "replay", self.folder / f"{robots}-2"], capture_output=True, text=True)
                self.assertEqual(replayed.returncode, 0, replayed.stderr)

    def test_seeds_hold_to_the_byte_and_games_follow_from_them(self):
        env = self.env()
        first = [self.game(env, 1, seed=5), self.game(env, 2), self.game(env, 3)]
        again = self.env()
        self.assertEqual([self.game(again, 1, seed=5), self.game(again, 2), self.game(again, 3)], first)
        self.assertNotEqual(self.game(again, 1), first[0])

    def test_a_game_may_be_given_up_for_the_next_one(self):
        env = self.env()
        env.reset(seed=1)
        env.step(int(env.action_masks().nonzero()[0][0]))
        _, info = env.reset()
        self.assertEqual(info["outcome"], "")
        self.assertEqual(info["decision"], 1)  # of another run
        env.step(int(env.action_masks().nonzero()[0][0]))


if __name__ == "__main__":
    unittest.main()
