"""The environments of cxlab.learn, checked by Gymnasium and PettingZoo. ./dev readers"""

import subprocess
import sys
import unittest
import warnings

import cxlab
import gymnasium
import numpy as np
from cxlab.learn import RCLLDispatchEnv, RCLLDispatchVectorEnv, RCLLRobotsEnv, RCLLRobotsParallelEnv, play
from cxlab.learn.games import HEAD
from cxlab.learn.policy import preferred
from cxlab.learn.registration import register
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, seed_test

register()
SHORT = {"until": 120.0, "journal": "decisions"}


def random_game(env, seed, actions):
    """Actions at random of those that are allowed; observations, rewards, and the hash of the run."""
    random = np.random.default_rng(actions)
    seen, info = env.reset(seed=seed)
    out = [seen]
    while True:
        seen, reward, terminated, truncated, info = env.step(random.choice(np.flatnonzero(info["action_mask"])))
        out += [seen, reward]
        if terminated or truncated:
            return out, info


def vector(count, **more):
    return RCLLDispatchVectorEnv(count, **(SHORT | more))


class Vector(unittest.TestCase):
    """Many games in threads are those that single environments play."""

    def test_each_row_is_the_single_environment_with_its_seed_and_actions(self):
        singles, ends = {}, {}
        for row in range(3):
            env = RCLLDispatchEnv(**SHORT)
            random = np.random.default_rng(row)
            played = [env.reset(seed=7 + row)]
            for _ in range(2):  # two games: the second one follows from the seed
                over = False
                while not over:
                    action = random.choice(np.flatnonzero(played[-1][-1]["action_mask"]))
                    played.append(env.step(action))
                    over = played[-1][2] or played[-1][3]
                ends.setdefault(row, []).append(played[-1][-1]["journal_hash"])
                played.append(env.reset())
            singles[row] = played
            env.close()
        for threads, ahead in ((1, True), (2, True), (3, False)):
            with self.subTest(threads=threads, ahead=ahead):
                env = vector(3, threads=threads, ahead=ahead)
                self.addCleanup(env.close)
                randoms = [np.random.default_rng(row) for row in range(3)]
                seen, infos = env.reset(seed=7)
                step, over = 0, np.zeros(3, dtype=bool)
                while any(step < len(played) for played in singles.values()):
                    for row, played in singles.items():
                        if step < len(played):
                            single, info = played[step][0], played[step][-1]
                            np.testing.assert_array_equal(seen[row], single)
                            np.testing.assert_array_equal(infos["action_mask"][row], info["action_mask"])
                            for name in ("kind", "who", "preferred", "now", "points", "journal_hash", "seed"):
                                self.assertEqual(name in info, bool(infos.get(f"_{name}", np.zeros(3))[row]), name)
                                if name in info:
                                    self.assertEqual(infos[name][row], info[name], name)
                    np.testing.assert_array_equal(env.action_masks(), infos["action_mask"])
                    actions = [0 if over[row] else randoms[row].choice(np.flatnonzero(mask)) for row, mask in enumerate(infos["action_mask"])]
                    seen, rewards, terminated, truncated, infos = env.step(np.array(actions))
                    over = terminated | truncated
                    step += 1
                    for row, played in singles.items():
                        if step < len(played):
                            wanted = played[step][1:4] if len(played[step]) == 5 else (0.0, False, False)
                            self.assertEqual((rewards[row], terminated[row], truncated[row]), wanted)

    def test_gymnasium_makes_it(self):
        env = gymnasium.make_vec("cxlab/RCLLDispatch-v0", num_envs=2, **SHORT)
        self.addCleanup(env.close)
        self.assertIsInstance(env.unwrapped, RCLLDispatchVectorEnv)
        seen, infos = env.reset(seed=[5, None])
        self.assertTrue(env.observation_space.contains(seen))
        self.assertEqual(infos["seed"][0], 5)
        forbidden = np.flatnonzero(~infos["action_mask"][1])[0]
        *_, infos = env.step(np.array([infos["preferred"][0], forbidden]))
        np.testing.assert_array_equal(infos["invalid"], [False, True])

    def test_a_step_that_raises_ends_the_games_and_reset_begins_others(self):
        env = vector(2)
        self.addCleanup(env.close)
        env.reset(seed=1)
        with self.assertRaises(IndexError):
            env.step(np.zeros(1, dtype=np.int64))
        with self.assertRaisesRegex(cxlab.UsageError, "call reset"):
            env.step(np.zeros(2, dtype=np.int64))
        seen, _ = env.reset(seed=1)
        single = RCLLDispatchEnv(**SHORT)
        self.addCleanup(single.close)
        np.testing.assert_array_equal(seen[0], single.reset(seed=1)[0])

    def test_what_a_game_raises_is_raised_and_wrong_arguments_are_told(self):
        env = vector(2, scenario="rcll/game")
        with self.assertRaisesRegex(cxlab.InputError, "expected rules that ask"):
            env.reset(seed=1)
        env.close()
        with self.assertRaisesRegex(cxlab.UsageError, "closed"):
            env.reset(seed=1)
        for wrong, says in ((lambda: vector(0), "num_envs: found 0"), (lambda: vector(1, threads=0), "threads: found 0"),
                            (lambda: vector(1, out="x"), "one game"), (lambda: vector(1, render_mode="rgb_array"), "no picture")):
            with self.subTest(says), self.assertRaisesRegex(cxlab.UsageError, says):
                wrong()
        env = vector(1)
        self.addCleanup(env.close)
        with self.assertRaisesRegex(cxlab.UsageError, "call reset"):
            env.step(np.zeros(1, dtype=np.int64))
        with self.assertRaisesRegex(cxlab.UsageError, "found 2 seeds"):
            env.reset(seed=[1, 2])


class Dispatch(unittest.TestCase):
    def test_gymnasium_finds_nothing_wrong(self):
        env = gymnasium.make("cxlab/RCLLDispatch-v0", **SHORT).unwrapped
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_env(env)
        env.close()

    def test_it_finds_nothing_wrong_with_a_fixed_interval_either(self):
        env = gymnasium.make("cxlab/RCLLDispatch-v0", interval=1.0, **SHORT).unwrapped
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_env(env)
        env.close()
        for make, test in ((RCLLRobotsEnv, api_test), (RCLLRobotsParallelEnv, parallel_api_test)):
            env = make(interval=1.0, **SHORT)
            test(env, num_cycles=100)
            env.close()

    def test_at_a_fixed_interval_the_same_seed_and_actions_are_the_same_run(self):
        env = RCLLDispatchEnv(interval=1.0, **SHORT)
        one, two, three = (random_game(env, 5, actions) for actions in (1, 1, 2))
        env.close()
        self.assertEqual(one[1]["journal_hash"], two[1]["journal_hash"])
        self.assertNotEqual(one[1]["journal_hash"], three[1]["journal_hash"])
        for a, b in zip(one[0], two[0], strict=True):
            np.testing.assert_array_equal(a, b)

    def test_the_same_seed_and_actions_are_the_same_run_and_others_another_one(self):
        env = gymnasium.make("cxlab/RCLLDispatch-v0", **SHORT)
        one, two, three = (random_game(env, 5, actions) for actions in (1, 1, 2))
        env.close()
        self.assertEqual(one[1]["journal_hash"], two[1]["journal_hash"])
        self.assertNotEqual(one[1]["journal_hash"], three[1]["journal_hash"])
        for a, b in zip(one[0], two[0], strict=True):
            np.testing.assert_array_equal(a, b)

    def test_a_game_that_is_cut_off_is_truncated_and_a_whole_one_terminates_with_all_its_points(self):
        env = gymnasium.make("cxlab/RCLLDispatch-v0", **SHORT)
        _, info = env.reset(seed=1)
        while True:
            *_, terminated, truncated, info = env.step(info["preferred"])
            if terminated or truncated:
                break
        env.close()
        self.assertEqual((terminated, truncated), (False, True))
        env = gymnasium.make("cxlab/RCLLDispatch-v0")
        _, info = env.reset(seed=1)
        total = 0.0
        while True:
            _, reward, terminated, truncated, info = env.step(info["preferred"])
            total += reward
            if terminated or truncated:
                break
        env.close()
        self.assertEqual((terminated, truncated), (True, False))
        self.assertEqual(total, info["points"])
        self.assertEqual(total, play(preferred, 1)["teams"]["CYAN"]["points"])

    def test_seeds_after_the_first_follow_from_it(self):
        env = gymnasium.make("cxlab/RCLLDispatch-v0", **SHORT)
        rows = []
        for _ in range(2):
            row = [env.reset(seed=9)[1]["seed"], *(env.reset()[1]["seed"] for _ in range(3))]
            rows.append(row)
        env.close()
        self.assertEqual(rows[0], rows[1])
        self.assertEqual(rows[0][0], 9)
        self.assertEqual(len(set(rows[0])), 4)

    def test_the_mask_is_that_of_the_information_and_a_forbidden_action_is_told(self):
        env = RCLLDispatchEnv(**SHORT)
        _, info = env.reset(seed=2)
        mask = env.action_masks()
        np.testing.assert_array_equal(mask, info["action_mask"])
        self.assertEqual((mask.dtype, mask.shape), (np.bool_, (16,)))
        *_, info = env.step(np.int64(np.flatnonzero(~mask)[0]))
        self.assertIs(info["invalid"], True)
        *_, info = env.step(np.int64(info["preferred"]))
        self.assertNotIn("invalid", info)
        env.close()

    def test_a_picture_is_drawn_at_the_open_choice(self):
        env = gymnasium.make("cxlab/RCLLDispatch-v0", render_mode="rgb_array", **SHORT)
        env.reset(seed=1)
        picture = env.render()
        env.close()
        self.assertEqual((picture.shape[2], picture.dtype), (3, np.uint8))
        self.assertGreater(picture.std(), 10)

    def test_a_vector_of_processes_plays_the_games_that_one_environment_plays(self):
        def make():
            return gymnasium.make("cxlab/RCLLDispatch-v0", **SHORT)

        vector = gymnasium.vector.AsyncVectorEnv([make, make])
        _, info = vector.reset(seed=[3, 4])
        hashes = {}
        while len(hashes) < 2:
            *_, terminated, truncated, info = vector.step(info.get("preferred", np.zeros(2, dtype=int)))
            for number in np.flatnonzero(terminated | truncated):
                hashes.setdefault(number, info["journal_hash"][number])
        vector.close()
        env = make()
        for number, seed in ((0, 3), (1, 4)):
            _, info = env.reset(seed=seed)
            over = False
            while not over:
                *_, terminated, truncated, info = env.step(info["preferred"])
                over = terminated or truncated
            self.assertEqual(hashes[number], info["journal_hash"])
        env.close()


class Robots(unittest.TestCase):
    def test_pettingzoo_finds_nothing_wrong(self):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of observations that are zeros, and of names of agents
            env = RCLLRobotsEnv(**SHORT)
            api_test(env, num_cycles=50)
            env.close()
            env = RCLLRobotsParallelEnv(**SHORT)
            parallel_api_test(env, num_cycles=50)
            env.close()

    def test_seeds_are_kept(self):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            seed_test(lambda: RCLLRobotsEnv(**SHORT), num_cycles=20)
            parallel_seed_test(lambda: RCLLRobotsParallelEnv(**SHORT), num_cycles=20)

    def test_all_get_the_points_of_the_team_and_only_who_chooses_sees(self):
        env = RCLLRobotsEnv()
        env.reset(seed=1)
        total = dict.fromkeys(env.possible_agents, 0.0)
        for agent in env.agent_iter():
            seen, reward, terminated, truncated, _ = env.last()
            total[agent] += reward
            for other in env.agents:
                if other != agent and not terminated:
                    self.assertFalse(env.observe(other)["observation"].any())
            env.step(None if terminated or truncated else int(np.argmax(seen["observation"][HEAD:].reshape(16, -1)[:, 0])))
        env.close()
        self.assertEqual(set(total.values()), {float(play(preferred, 1)["teams"]["CYAN"]["points"])})

    def test_the_parallel_form_is_the_same_game(self):
        env = RCLLRobotsParallelEnv()
        seen, _ = env.reset(seed=1)
        total = 0.0
        while env.agents:
            actions = {agent: int(np.argmax(one["observation"][HEAD:].reshape(16, -1)[:, 0])) for agent, one in seen.items()}
            seen, rewards, *_ = env.step(actions)
            total += rewards["robot1"]
        env.close()
        self.assertEqual(total, play(preferred, 1)["teams"]["CYAN"]["points"])


class Turtles(unittest.TestCase):
    def drive(self, seed, policy, steps=200, **more):
        """Rewards, and the last answer of the environment."""
        env = gymnasium.make("cxlab/Turtlesim-v0", journal="decisions", steps=steps, **more)
        seen, _ = env.reset(seed=seed)
        rewards, first = [], seen
        while True:
            seen, reward, terminated, truncated, info = env.step(policy(seen))
            rewards.append(reward)
            if terminated or truncated:
                env.close()
                return first, seen, rewards, (terminated, truncated), info

    @staticmethod
    def to_goal(seen):
        _, _, ahead, left, _, _ = seen
        turn = np.arctan2(left, ahead)
        return np.array([np.cos(turn) if ahead > 0 else 0.0, turn], dtype=np.float32)

    def test_gymnasium_finds_nothing_wrong(self):
        env = gymnasium.make("cxlab/Turtlesim-v0").unwrapped
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_env(env)
        env.close()

    def test_who_drives_to_the_goal_gets_there_and_gains_the_way(self):
        for seed in range(5):
            first, last, rewards, ended, _ = self.drive(seed, self.to_goal)
            self.assertEqual(ended, (True, False))
            side = 11.0889
            self.assertLess(np.hypot(*last[:2]) * side, 0.3)
            self.assertAlmostEqual(sum(rewards), (np.hypot(*first[:2]) - np.hypot(*last[:2])) * side, places=3)

    def test_who_stands_still_is_cut_off(self):
        *_, rewards, ended, _ = self.drive(1, lambda _: np.zeros(2, np.float32), steps=30)
        self.assertEqual((len(rewards), ended, sum(rewards)), (30, (False, True), 0.0))

    def test_full_speed_is_two_metres_a_second(self):
        first, last, *_ = self.drive(3, lambda _: np.array([1, 0], np.float32), steps=3)
        self.assertAlmostEqual(np.hypot(*(last - first)[:2]) * 11.0889, 0.6, delta=0.07)

    def test_the_same_seed_and_actions_are_the_same_run(self):
        runs = [self.drive(seed, self.to_goal)[-1]["journal_hash"] for seed in (7, 7, 8)]
        self.assertEqual(runs[0], runs[1])
        self.assertNotEqual(runs[0], runs[2])


class Registered(unittest.TestCase):
    def test_importing_cxlab_learn_is_enough_before_and_after_gymnasium_or_by_the_name(self):
        for modules, module in (("gymnasium, cxlab.learn", ""), ("cxlab.learn, gymnasium", ""), ("gymnasium", "cxlab.learn:")):
            with self.subTest(modules):
                code = f"import {modules}; gymnasium.make('{module}cxlab/RCLLDispatch-v0', until=30.0).close()"
                done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
                self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main()
