"""Choices of rules that Python makes (cxlab.learn): numpy alone."""

import json
import os
import subprocess
import tempfile
import threading
import unittest
from pathlib import Path

import cxlab
import numpy as np
from cxlab import UsageError, _cxlab
from cxlab.learn import ChoiceGame, LinearPolicy, play, play_all, shipped_policy
from cxlab.learn.features import KINDS, OPTION, SITUATION
from cxlab.learn.games import OPTIONS, SIZE, Games, mask_of, observation_of, shown_options
from cxlab.learn.policy import preferred

SHORT = 120.0  # s of a game


def choices(seed, policy=preferred, until=SHORT, **more):
    """All choices of a game, a short one if nothing else is said, and its result."""
    seen = []
    with ChoiceGame(seed=seed, tier="timed", until=until, **more) as game:
        while choice := game.next():
            seen.append(choice)
            game.choose(policy(choice))
        return seen, game.close()


class OfTheRules(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.seen, cls.result = choices(1, journal="decisions")

    def test_both_kinds_come_with_features_by_their_names_between_minus_one_and_one(self):
        self.assertEqual({choice.kind for choice in self.seen}, set(KINDS))
        for choice in self.seen:
            self.assertEqual(choice.features.shape, (len(choice.options), len(OPTION[choice.kind])))
            self.assertEqual(choice.situation.shape, (len(SITUATION),))
            self.assertLessEqual(np.abs(choice.features).max(), 1)
            self.assertLessEqual(np.abs(choice.situation).max(), 1)

    def test_the_preferred_option_is_the_one_with_that_feature_and_may_be_chosen(self):
        for choice in self.seen:
            at = OPTION[choice.kind].index("preferred")
            np.testing.assert_array_equal(np.flatnonzero(choice.features[:, at]), [choice.preferred])
            self.assertTrue(choice.allowed[choice.preferred])

    def test_the_last_option_is_to_do_nothing(self):
        for choice in self.seen:
            np.testing.assert_array_equal(np.flatnonzero(choice.features[:, 1]), [len(choice.options) - 1])

    def test_jobs_are_asked_for_a_robot_and_orders_for_the_team(self):
        for choice in self.seen:
            self.assertRegex(choice.who, "^robot[123]$" if choice.kind == "take-job" else "^$")

    def test_time_passes(self):
        times = [choice.now for choice in self.seen]
        self.assertEqual(times, sorted(times))
        shares = [choice.situation[SITUATION.index("time")] for choice in self.seen]
        for now, share in zip(times, shares, strict=True):
            self.assertAlmostEqual(share * 1200, now, delta=0.2)

    def test_the_same_choices_are_the_same_run_and_others_another_one(self):
        again = choices(1, journal="decisions")[1]
        self.assertEqual(again["journal_hash"], self.result["journal_hash"])
        last = choices(1, lambda choice: len(choice.options) - 1, journal="decisions")[1]
        self.assertNotEqual(last["journal_hash"], self.result["journal_hash"])

    def test_who_never_begins_an_order_delivers_nothing(self):
        self.assertEqual(play(lambda choice: len(choice.options) - 1, 1, until=600.0)["teams"]["CYAN"]["by_kind"]["cap"], 0)


class OnDisk(unittest.TestCase):
    def test_the_run_replays_without_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            run = Path(folder, "run")
            choices(3, lambda choice: 0, out=run, journal="full")
            done = subprocess.run([os.environ["CXLAB"], "replay", run], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


class Wrong(unittest.TestCase):
    def test_a_game_that_is_closed_or_has_failed_says_so(self):
        game = ChoiceGame("rcll/external", until=1.0)
        game.close()
        with self.assertRaisesRegex(cxlab.UsageError, "closed"):
            game.next()
        with self.assertRaises(cxlab.CxlabError) as caught, ChoiceGame("turtlesim/boundary", tier="physics", until=1.0) as failing:
            failing.close()
        self.assertNotIn("closed", str(caught.exception))

    def test_another_thread_has_to_wait(self):
        game = ChoiceGame("rcll/game", tier="timed", topic="/nobody", until=300.0)
        playing = threading.Thread(target=game.next)
        playing.start()
        seen = []
        while playing.is_alive() and not seen:
            try:
                game.now  # noqa: B018 - it raises while the other one plays
            except cxlab.UsageError as error:
                seen.append(str(error))
        playing.join()
        self.assertTrue(seen and "in use" in seen[0], seen)
        game.close()

    def test_an_option_that_is_not_there_names_how_many_there_are(self):
        with ChoiceGame(seed=1, tier="timed", until=SHORT) as game:
            choice = game.next()
            for option in (-1, len(choice.options)):
                with self.assertRaisesRegex(UsageError, rf"option {option} .*of {len(choice.options)}"):
                    game.choose(option)
            game.choose(choice.preferred)
            with self.assertRaisesRegex(UsageError, "next"):
                game.choose(0)

    def test_weights_of_an_unknown_feature_name_the_known_ones(self):
        with self.assertRaisesRegex(ValueError, "no feature 'weigth'; expected preferred, wait"):
            LinearPolicy({"take-job": {"weigth": 1.0}})
        with self.assertRaisesRegex(ValueError, "'jobs': expected one of begin-order, take-job"):
            LinearPolicy({"jobs": {}})


class Training(unittest.TestCase):
    """What cxlab.rl.CXEnv is made of, without Gymnasium: the blocks of docs/examples/rl."""

    def begin(self, package=None, **more):
        example = Path(os.environ["CXLAB_SOURCE_DIR"], "docs/examples/rl")
        params = {"policy": "external", "robots": 1, "no_op": "false", "max_steps": 1000, "max_episodes": 100}
        asked = {
            "scenario": "", "assignments": [], "configs": [os.fspath(example / "example.yaml")], "packages": [f"example={package or example}"],
            "params": [f"cx_rl_node.{key}={value}" for key, value in params.items()], "seed": 1, "until": None, "journal": "none", "out": "",
            "force": False, "node": "/cx_rl_node",
        }  # fmt: skip
        return _cxlab.Training(**(asked | more))

    def test_choices_have_their_rewards_until_the_tower_stands(self):
        training = self.begin()
        number, robot, observation, mask, reward, outcome, now = training.next()
        observables, actions = training.spaces()
        self.assertEqual((number, robot, reward, outcome), (1, "robot1", 0.0, ""))
        self.assertEqual({name for name, bit in zip(observables, observation, strict=True) if bit}, {"on(c#a)", "on(a#table)", "on(b#table)"})
        self.assertEqual({name for name, bit in zip(actions, mask, strict=True) if bit}, {"move(c#b)", "move(c#table)", "move(b#c)"})
        for count, (move, wanted) in enumerate((("move(c#table)", -1), ("move(b#c)", -1), ("move(a#b)", 19)), start=2):
            training.choose(actions.index(move))
            decision = training.next()
            self.assertEqual((decision[0], decision[4]), (count, wanted))
            self.assertGreater(decision[6], now)
        self.assertEqual((decision[1], decision[5]), ("", "end"))
        self.assertFalse(training.closed)
        training.close()
        self.assertTrue(training.closed)
        with self.assertRaisesRegex(UsageError, "closed"):
            training.next()

    def test_the_end_of_a_training_is_none_and_choices_need_a_decision(self):
        training = self.begin(until=1.3)
        self.assertEqual(training.next()[0], 1)
        move = training.spaces()[1].index("move(c#table)")
        training.choose(move)
        with self.assertRaisesRegex(UsageError, "found no open decision"):
            training.choose(move)
        self.assertIsNone(training.next())
        self.assertEqual(training.close()["sim_time_s"], 1.3)

    def test_rules_that_fail_raise_also_when_the_training_is_closed(self):
        with tempfile.TemporaryDirectory() as folder:
            rules = Path(os.environ["CXLAB_SOURCE_DIR"], "docs/examples/rl/blocks.clp").read_text()
            Path(folder, "blocks.clp").write_text(rules + "(defrule fails (time ?t&:(> ?t 1.0)) => (+ (nth$ 1 (create$ a)) 1))\n")
            training = self.begin(folder)
            for act in (training.next, training.close):
                with self.assertRaises(cxlab.RunError):
                    act()
            self.assertTrue(training.closed)


class Policies(unittest.TestCase):
    def test_greedy_chooses_what_the_rules_prefer(self):
        for choice in OfTheRules.seen if hasattr(OfTheRules, "seen") else choices(1)[0]:
            self.assertEqual(LinearPolicy.greedy()(choice), choice.preferred)

    def test_the_largest_sum_of_those_that_are_allowed_is_taken(self):
        choice = choices(1)[0][0]._replace(
            kind="take-job", allowed=np.array([True, False, True]),
            features=np.eye(3, len(OPTION["take-job"])),
        )  # fmt: skip
        names = OPTION["take-job"]
        policy = LinearPolicy({"take-job": {names[0]: 1.0, names[1]: 3.0, names[2]: 2.0}})
        self.assertEqual(policy(choice), 2)

    def test_a_policy_comes_back_from_its_vector_and_its_text(self):
        vector = np.arange(sum(len(names) for names in OPTION.values()), dtype=float)
        policy = LinearPolicy.of_vector(vector)
        np.testing.assert_array_equal(policy.vector(), vector)
        self.assertEqual(json.loads(policy.to_json()), policy.weights)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "weights.json")
            file.write_text(policy.to_json())
            np.testing.assert_array_equal(LinearPolicy.load(file).vector(), vector)

    def test_points_are_the_same_in_any_number_of_processes(self):
        policies = [LinearPolicy.greedy(), shipped_policy()]
        one = play_all(policies, [5, 6], until=SHORT)
        self.assertEqual(one.shape, (2, 2))
        np.testing.assert_array_equal(play_all(policies, [5, 6], processes=2, until=SHORT), one)

    def test_the_shipped_policy_chooses_otherwise_than_the_rules(self):
        policy = shipped_policy()
        seen = [choice for seed in range(1, 4) for choice in choices(seed, policy, until=None)[0]]
        self.assertTrue(any(policy(choice) != choice.preferred for choice in seen))


class Observations(unittest.TestCase):
    def test_parts_lie_where_the_documentation_says(self):
        for choice in choices(1)[0][:20]:
            seen = observation_of(choice)
            self.assertEqual(seen.shape, (SIZE,))
            self.assertEqual(seen.dtype, np.float32)
            self.assertEqual(KINDS[int(np.argmax(seen[:2]))], choice.kind)
            np.testing.assert_allclose(seen[2:10], choice.situation, rtol=1e-6)
            options = seen[10:].reshape(OPTIONS, -1)
            count, width = choice.features.shape
            np.testing.assert_allclose(options[:count, :width], choice.features, rtol=1e-6)
            self.assertFalse(options[count:].any())
            self.assertEqual(mask_of(choice).tolist(), [True] * count + [False] * (OPTIONS - count))

    def test_of_many_options_the_preferred_and_the_last_one_are_always_shown(self):
        choice = choices(1)[0][0]
        many = choice._replace(options=["x"] * 40, preferred=30)
        self.assertEqual(shown_options(many).tolist(), [*range(OPTIONS - 2), 30, 39])
        self.assertEqual(shown_options(many._replace(preferred=3)).tolist(), [*range(OPTIONS - 1), 39])

    def test_after_the_end_action_0_alone_is_allowed(self):
        self.assertEqual(np.flatnonzero(mask_of(None)).tolist(), [0])
        self.assertFalse(observation_of(None).any())


class OneAfterTheOther(unittest.TestCase):
    def play(self, games, seed, following):
        games.begin(seed, following)
        total = 0
        while games.choice is not None:
            games.answer(int(shown_options(games.choice).tolist().index(games.choice.preferred)))
            total += games.points()
        return total, games.result()["journal_hash"], games.result()["teams"]["CYAN"]["points"]

    def test_a_game_that_was_made_ready_is_the_one_that_would_have_been_loaded(self):
        ways = []
        for ahead, following in ((True, (8, 9, None)), (True, (8, 99, None)), (False, (8, 9, None))):
            games = Games("rcll/external", team="CYAN", ahead=ahead, tier="timed", until=SHORT, journal="decisions")
            ways.append([self.play(games, seed, then) for seed, then in zip((7, 8, 9), following, strict=True)])
            games.close()
        self.assertEqual(ways[0], ways[1])
        self.assertEqual(ways[0], ways[2])
        for total, _, points in ways[0]:
            self.assertEqual(total, points)

    def test_an_action_that_the_mask_forbids_takes_the_option_of_the_rules(self):
        games = Games("rcll/external", team="CYAN", ahead=False, tier="timed", until=SHORT, journal="decisions")
        hashes = []
        for action in (OPTIONS - 1, OPTIONS, -1, None):
            games.begin(4, None)
            while games.choice is not None:
                forbidden = action if action is not None else games.choice.preferred
                self.assertEqual(games.answer(forbidden), action is None)
            hashes.append(games.result()["journal_hash"])
        games.close()
        self.assertEqual(len(set(hashes)), 1)


if __name__ == "__main__":
    unittest.main()
