"""Choices of rules that Python makes (cxlab.learn): numpy alone."""

import argparse
import importlib.util
import json
import os
import subprocess
import tempfile
import threading
import unittest
import warnings
from pathlib import Path

import cxlab
import numpy as np
from cxlab import UsageError, _cxlab
from cxlab.learn import Choice, ChoiceGame, LinearPolicy, play, play_all, shipped_policy
from cxlab.learn.choices import play_on
from cxlab.learn.features import KINDS, OPTION, SITUATION
from cxlab.learn.games import OPTIONS, SIZE, Games, at_interval, mask_of, observation_of, shown_options
from cxlab.learn.policy import preferred, term_values

SHORT = 120.0  # s of a game


def choices(seed, policy=preferred, until=SHORT, **more):
    """All choices of a game, by default a short one, and its result."""
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
        self.assertEqual({choice.kind for choice in self.seen}, {"begin-order", "take-job"})
        for choice in self.seen:
            self.assertEqual(choice.features.shape, (len(choice.options), len(OPTION[choice.kind])))
            self.assertEqual(choice.situation.shape, (len(SITUATION[choice.kind]),))
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
        shares = [choice.situation[SITUATION[choice.kind].index("time")] for choice in self.seen]
        for now, share in zip(times, shares, strict=True):
            self.assertAlmostEqual(share * 1200, now, delta=0.2)

    def test_the_same_choices_are_the_same_run_and_others_another_one(self):
        again = choices(1, journal="decisions")[1]
        self.assertEqual(again["journal_hash"], self.result["journal_hash"])
        last = choices(1, lambda choice: len(choice.options) - 1, journal="decisions")[1]
        self.assertNotEqual(last["journal_hash"], self.result["journal_hash"])

    def test_who_never_begins_an_order_delivers_nothing(self):
        self.assertEqual(play(lambda choice: len(choice.options) - 1, 1, until=600.0)["teams"]["CYAN"]["by_kind"]["cap"], 0)


class ManyAtOnce(unittest.TestCase):
    def test_games_that_threads_play_on_are_those_that_are_played_alone(self):
        alone = [choices(seed, journal="decisions")[1]["journal_hash"] for seed in (1, 2, 3)]
        for threads in (1, 2, 5):
            games = [ChoiceGame(seed=seed, tier="timed", until=SHORT, journal="decisions") for seed in (1, 2, 3)]
            playing = list(games)
            while playing:
                play_on(playing, threads)
                before = [game.now for game in playing]
                choice_of = {game: game.next() for game in playing}
                self.assertEqual([game.now for game in playing], before, "next plays nothing any more")
                playing = [game for game in playing if choice_of[game] is not None]
                for game in playing:
                    game.choose(choice_of[game].preferred)
            self.assertEqual([game.close()["journal_hash"] for game in games], alone)

    def test_a_game_twice_or_a_closed_one_is_refused(self):
        game = ChoiceGame(seed=1, tier="timed", until=SHORT)
        with self.assertRaisesRegex(UsageError, "in use"):
            play_on([game, game], 2)
        self.assertEqual(game.next().kind, choices(1)[0][0].kind)
        game.close()
        with self.assertRaisesRegex(UsageError, "closed"):
            play_on([game], 2)


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
        with self.assertRaisesRegex(ValueError, "no feature 'prodcts' after the \\*; expected preferred, .*, products"):
            LinearPolicy({"begin-order": {"none*prodcts": 1.0}})


class WhatIf(unittest.TestCase):
    """A game branches in a copy of the process."""

    @staticmethod
    def to_the_end(game, policy):
        while (choice := game.next()) is not None:
            game.choose(policy(choice))
        return game.close()["journal_hash"]

    def test_a_branch_is_the_game_with_the_same_choices_and_the_game_itself_stays_where_it_is(self):
        plain = choices(1, journal="decisions")[1]["journal_hash"]
        with ChoiceGame(seed=1, tier="timed", until=SHORT, journal="decisions") as game:
            for _ in range(8):
                choice = game.next()
                last = len(choice.options) - 1

                def go_on(option):
                    game.choose(option)
                    return self.to_the_end(game, preferred)

                self.assertEqual(game.what_if(lambda preferred=choice.preferred: go_on(preferred)), plain)
                other = game.what_if(lambda last=last: go_on(last))
                self.assertNotEqual(other, plain)
                game.choose(choice.preferred)
            at, taken = choice.now, last

            def passes_by_at_that_time(choice):
                return taken if choice.now == at else choice.preferred

            self.assertEqual(self.to_the_end(game, preferred), plain)
        self.assertEqual(choices(1, passes_by_at_that_time, journal="decisions")[1]["journal_hash"], other)

    def test_what_a_branch_raises_comes_here(self):
        with ChoiceGame(seed=1, tier="timed", until=SHORT) as game:
            game.next()
            with self.assertRaisesRegex(UsageError, "option 99 "):
                game.what_if(lambda: game.choose(99))
            with self.assertRaises(ZeroDivisionError):
                game.what_if(lambda: 1 / 0)
            with self.assertRaisesRegex(RuntimeError, "without an answer"):
                game.what_if(lambda: os._exit(1))
            self.assertEqual(game.what_if(lambda: 7), 7)

    def test_a_branch_beside_other_threads_warns_of_nothing(self):
        over = threading.Event()
        other = threading.Thread(target=over.wait)
        other.start()
        with ChoiceGame(seed=1, tier="timed", until=SHORT) as game, warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            game.next()
            self.assertEqual(game.what_if(lambda: threading.active_count()), 1)
            self.assertEqual(warned, [])
        over.set()
        other.join()

    def test_a_game_with_a_folder_does_not_branch(self):
        with tempfile.TemporaryDirectory() as folder, ChoiceGame(seed=1, tier="timed", until=SHORT, out=Path(folder, "run")) as game:
            game.next()
            with self.assertRaisesRegex(UsageError, "without `out`"):
                game.what_if(lambda: 0)


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

    def test_a_term_is_a_feature_or_the_product_of_two(self):
        for choice in choices(1)[0][:20]:
            last, products = OPTION[choice.kind][1], choice.situation[SITUATION[choice.kind].index("products")]
            terms = ["preferred", f"{last}*products", f"{last}*points", "points*points"]
            points = choice.features[:, OPTION[choice.kind].index("points")]
            nothing = np.arange(len(choice.options)) == len(choice.options) - 1
            expected = [choice.features[:, 0], nothing * products, nothing * points, points**2]
            np.testing.assert_allclose(term_values(choice, terms), np.array(expected).T)
            policy = LinearPolicy({choice.kind: dict(zip(terms, (1.0, 2.0, 4.0, 8.0), strict=True))})
            np.testing.assert_allclose(policy.scores(choice), np.array(expected).T @ [1.0, 2.0, 4.0, 8.0])

    def test_rules_with_other_features_are_an_error(self):
        choice = choices(1)[0][0]
        with self.assertRaisesRegex(ValueError, f"found 3 features of '{choice.kind}', expected .*: preferred, "):
            term_values(choice._replace(features=choice.features[:, :3]), ["preferred"])

    def test_of_a_kind_without_weights_the_option_of_the_rules_is_taken(self):
        for choice in choices(1)[0][:20]:
            self.assertEqual(LinearPolicy({})(choice), choice.preferred)
            self.assertEqual(LinearPolicy.greedy()(choice._replace(kind="open-door")), choice.preferred)

    def test_a_policy_comes_back_from_its_text(self):
        policy = LinearPolicy({kind: {names[2]: 1.5, f"{names[1]}*idle": -2.0} for kind, names in OPTION.items()})
        self.assertEqual(json.loads(policy.to_json()), policy.weights)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "weights.json")
            file.write_text(policy.to_json())
            self.assertEqual(LinearPolicy.load(file).weights, policy.weights)

    def test_points_are_the_same_in_any_number_of_processes(self):
        policies = [LinearPolicy.greedy(), shipped_policy()]
        one = play_all(policies, [5, 6], until=SHORT)
        self.assertEqual(one.shape, (2, 2))
        np.testing.assert_array_equal(play_all(policies, [5, 6], processes=2, until=SHORT), one)

    def test_the_shipped_policy_chooses_otherwise_than_the_rules(self):
        policy = shipped_policy()
        seen = [choice for seed in range(1, 4) for choice in choices(seed, policy, until=None)[0]]
        self.assertTrue(any(policy(choice) != choice.preferred for choice in seen))


def choice_of_orders(*features, situation=(0.5,) * len(SITUATION["begin-order"]), now=100.0):
    """A choice between orders with these features by name, and none."""
    names = OPTION["begin-order"]
    rows = np.array([[by_name.get(name, 0.0) for name in names] for by_name in (*features, {"none": 1.0})])
    options = [f"begin order {number}" for number in range(len(features))] + ["begin no order"]
    return Choice("begin-order", "", options, np.ones(len(rows), bool), 0, np.array(situation), rows, now)


class Trainer(unittest.TestCase):
    """python/examples/train_dispatcher.py"""

    @classmethod
    def setUpClass(cls):
        file = Path(os.environ["CXLAB_SOURCE_DIR"], "python/examples/train_dispatcher.py")
        spec = importlib.util.spec_from_file_location("train_dispatcher", file)
        cls.trainer = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(cls.trainer)

    def game(self, seed, worth_of_points):
        """Samples in which an order is worth what this function says of its feature `worth`, against none."""
        random = np.random.default_rng(seed)
        samples = []
        for worth in random.uniform(0, 1, 40):
            order, none = choice_of_orders({"worth": worth}).features.tolist()
            noise = float(random.normal(0, 20))
            samples.append({"situation": [0.5] * len(SITUATION["begin-order"]), "taken": none, "other": order, "gain": worth_of_points(worth) + noise})
        return {"seed": seed, "points": 0.0, "samples": samples}

    def test_a_policy_takes_what_branches_have_shown_to_be_worth_more(self):
        policy = self.trainer.fitted(self.game(seed, lambda worth: 100 * worth - 50) for seed in range(20))
        taken = [policy(choice_of_orders({"worth": worth})._replace(preferred=1)) for worth in (0.1, 0.3, 0.7, 0.9)]
        self.assertEqual(taken, [1, 1, 0, 0])
        self.assertEqual(policy(choice_of_orders({"worth": 0.7}, {"worth": 0.9})), 1)

    def test_the_option_of_the_rules_is_left_only_for_more_than_the_margin(self):
        for points in (1.0, 15.0):
            policy = self.trainer.fitted(self.game(seed, lambda _, points=points: points) for seed in range(200))
            choice = choice_of_orders({"worth": 0.5}, {"preferred": 0.0})
            choice.features[2, OPTION["begin-order"].index("preferred")] = 1.0
            scores = policy.scores(choice)
            self.assertEqual(scores[0] > scores[2], points > self.trainer.MARGIN, points)

    def test_a_game_is_the_same_each_time_and_says_what_the_other_option_brings(self):
        self.trainer.BRANCHES, before = (0.3, 0.0), self.trainer.BRANCHES
        self.addCleanup(setattr, self.trainer, "BRANCHES", before)
        task = (self.trainer.START.weights, 1_000_003, 1, "rcll/external")
        game = self.trainer.game_with_branches(task)
        self.assertEqual(self.trainer.game_with_branches(task), game)
        self.assertEqual(game["points"], play(preferred, 1_000_003)["teams"]["CYAN"]["points"])
        self.assertTrue(game["samples"])
        for sample in game["samples"]:
            self.assertEqual(sample["taken"][OPTION["begin-order"].index("preferred")], 1.0)
            self.assertNotEqual(sample["taken"], sample["other"])

    def test_orders_that_were_passed_by_are_passed_by_for_a_while_and_others_are_not(self):
        first = choice_of_orders({"worth": 0.9})
        policy = self.trainer.PassingBy(LinearPolicy({"begin-order": {"worth": 1.0, "none": 0.1}}), first)
        later = choice_of_orders({"worth": 0.9}, {"worth": 0.5}, now=first.now + self.trainer.HELD - 0.1)
        self.assertEqual(policy(first), 1)
        self.assertEqual(policy(later), 1)
        self.assertEqual(policy(later._replace(now=first.now + self.trainer.HELD)), 0)
        self.assertEqual(policy(later._replace(kind="begin-step")), later.preferred)

    def test_a_training_goes_on_after_the_last_whole_game_and_refuses_other_arguments(self):
        with tempfile.TemporaryDirectory() as folder:
            arguments = argparse.Namespace(out=folder, games=3, checking=2, seed=1, scenario="rcll/external")
            self.trainer.Training(arguments)
            with Path(folder, "samples.jsonl").open("a") as out:
                for seed in (1_000_001, 1_000_000):
                    out.write(json.dumps(self.game(seed, lambda worth: 10 * worth)) + "\n")
                out.write('{"seed": 1000002, "po')
            training = self.trainer.Training(arguments)
            self.assertEqual(sorted(training.played), [1_000_000, 1_000_001])
            self.assertEqual(len(Path(folder, "samples.jsonl").read_text().splitlines()), 2)
            in_order = self.trainer.fitted(self.game(seed, lambda worth: 10 * worth) for seed in (1_000_000, 1_000_001))
            self.assertEqual(training.policy(2).weights, in_order.weights)
            arguments.games = 4
            with self.assertRaisesRegex(SystemExit, "--games 3 --checking 2 --seed 1; use those"):
                self.trainer.Training(arguments)


class AtAFixedInterval(unittest.TestCase):
    """The rules ask for an order each time the interval has passed, also where only none can begin."""

    def asked(self, interval, **more):
        seen, result = choices(1, set=at_interval(interval, more))
        return [choice for choice in seen if choice.kind == "begin-order"], result

    def test_each_interval_is_asked_for_once(self):
        for interval in (1.0, 2.5):
            orders, _ = self.asked(interval)
            np.testing.assert_allclose(np.diff([choice.now for choice in orders]), interval, atol=1e-6)
            self.assertEqual({len(choice.options) > 1 for choice in orders}, {True, False})
            for choice in orders:
                self.assertEqual((choice.options[-1], choice.features.shape), ("begin no order", (len(choice.options), len(OPTION["begin-order"]))))
                self.assertTrue(choice.allowed.all())

    def test_the_game_is_the_one_without_interval_where_only_none_can_begin(self):
        orders, result = self.asked(1.0)
        seen, plain = choices(1)
        real = [(choice.now, choice.options, choice.features.tolist()) for choice in orders if len(choice.options) > 1]
        self.assertEqual(real, [(choice.now, choice.options, choice.features.tolist()) for choice in seen if choice.kind == "begin-order"])
        self.assertEqual(result["teams"], plain["teams"])

    def test_an_environment_has_it_as_an_argument_beside_other_settings(self):
        games = Games("rcll/external", ahead=False, until=SHORT, interval=2.0, set={"world.robots": 2})
        self.addCleanup(games.close)
        games.begin(1, None)
        times = []
        while games.choice is not None:
            if games.choice.kind == "begin-order":
                times.append(games.choice.now)
            games.answer(-1)
        np.testing.assert_allclose(np.diff(times), 2.0, atol=1e-6)

    def test_an_interval_is_more_than_nothing(self):
        for wrong in (0, -1.0, float("nan")):
            with self.subTest(wrong), self.assertRaisesRegex(UsageError, f"interval: found {wrong}, expected more than 0 s"):
                Games("rcll/external", interval=wrong)
        self.assertEqual(at_interval(2, {"a": 1, "agents[0].params": {"x.y": 3}}),
                         {"a": 1, "agents[0].params": {"clips_manager.choices.interval": 2.0, "x.y": 3}})


class Observations(unittest.TestCase):
    def test_parts_lie_where_the_documentation_says(self):
        for choice in choices(1)[0][:20]:
            seen = observation_of(choice)
            self.assertEqual(seen.shape, (SIZE,))
            self.assertEqual(seen.dtype, np.float32)
            self.assertEqual(KINDS[int(np.argmax(seen[:3]))], choice.kind)
            np.testing.assert_allclose(seen[3:11], choice.situation, rtol=1e-6)
            options = seen[11:].reshape(OPTIONS, -1)
            count, width = choice.features.shape
            np.testing.assert_allclose(options[:count, :width], choice.features, rtol=1e-6)
            self.assertFalse(options[count:].any())
            self.assertEqual(mask_of(choice).tolist(), [True] * count + [False] * (OPTIONS - count))

    def test_steps_of_the_planning_agent_are_choices_as_well(self):
        external = {"agents[0].params": {"clips_manager.strategy.dispatch": "external"}}
        games = Games("rcll/planning", ahead=False, until=80, set=external)
        self.addCleanup(games.close)
        games.begin(1, None)
        moving = set()
        while (choice := games.choice) is not None:
            by_name = dict(zip(OPTION[choice.kind], choice.features.T, strict=True))
            situation = dict(zip(SITUATION[choice.kind], choice.situation, strict=True))
            self.assertEqual((choice.kind, choice.preferred, choice.options[-1]), ("begin-step", 0, "wait"))
            self.assertEqual(by_name["preferred"].tolist(), [1.0] + [0.0] * (len(choice.options) - 1))
            self.assertEqual(by_name["wait"].tolist(), [0.0] * (len(choice.options) - 1) + [1.0])
            for text, *kinds in zip(choice.options, *choice.features.T[5:11], strict=True):  # one column an action
                self.assertEqual([name for name, kind in zip(OPTION["begin-step"][5:11], kinds, strict=True) if kind], [text.split()[0]] * (text != "wait"))
            self.assertAlmostEqual(situation["time"], choice.now / 1200, places=3)
            moving.add(round(situation["running"] * 10))
            seen = observation_of(choice)
            self.assertEqual(seen[:3].tolist(), [0, 0, 1])
            np.testing.assert_allclose(seen[3:7], choice.situation, rtol=1e-6)
            self.assertFalse(seen[7:11].any())
            self.assertEqual(LinearPolicy({"begin-step": {"preferred*not_begun": 1.0}})(choice), 0)
            games.answer(choice.preferred)
        self.assertEqual(min(moving), 0)
        self.assertGreater(len(moving), 1)

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

    def test_a_game_in_which_nothing_can_be_learned_is_refused(self):
        for scenario, team, file in (("rcll/external", "PINK", "team"), ("rcll/game", "CYAN", "scenario")):
            games = Games(scenario, team=team, ahead=False, tier="timed", until=SHORT)
            self.addCleanup(games.close)
            with self.subTest(scenario), self.assertRaises(cxlab.CxlabError) as raised:
                games.begin(1, None)
            self.assertEqual(raised.exception.file, file)


if __name__ == "__main__":
    unittest.main()
