"""Episodes that Python plays: steps, acts between ticks, the bus, seats, and hostile use."""

import _thread
import copy
import gc
import importlib.util
import json
import os
import pickle
import subprocess
import tempfile
import threading
import time
import unittest
import warnings
from pathlib import Path

import cxlab

PROGRAM = os.fspath(cxlab.program())
HAS_NUMPY = importlib.util.find_spec("numpy") is not None
GAME = {"scenario": "rcll/game", "tier": "timed"}


def program(*arguments):
    return subprocess.run([PROGRAM, *map(os.fspath, arguments)], capture_output=True, text=True, check=False)


class EpisodeTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def assert_replays(self, run):
        """Rules and physics, each by itself, and the whole run come to the same hashes."""
        replayed = program("replay", run)
        self.assertEqual(replayed.returncode, 0, replayed.stderr)
        again = program("rerun", run, "--out", self.folder / f"again-{run.name}")
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)


class Names(unittest.TestCase):
    def test_completion_offers_what_is_there(self):
        self.assertEqual(dir(cxlab), sorted(cxlab.__all__))
        for name in dir(cxlab):
            self.assertIsNotNone(getattr(cxlab, name))
        with self.assertRaisesRegex(AttributeError, "no attribute 'episode_'"):
            _ = cxlab.episode_


class Steps(EpisodeTest):
    def test_an_episode_in_ticks_is_byte_for_byte_the_run_of_the_program(self):
        ran = program("run", "rcll/game", "--seed", "7", "--tier", "timed", "--until", "300", "--out", self.folder / "a")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        with cxlab.Episode(**GAME, seed=7, until=300, out=self.folder / "b") as episode:
            while not episode.step().over:
                pass
        for name in ("journal.jsonl", "inputs.bin", "scene.bin"):
            self.assertEqual((self.folder / "a" / name).read_bytes(), (self.folder / "b" / name).read_bytes(), name)
        self.assertTrue(episode.result["deterministic"])
        self.assertEqual(json.loads((self.folder / "b/result.json").read_text()), episode.result)
        self.assertTrue((self.folder / "b/index.html").exists())

    def test_a_step_ends_at_a_time_or_after_ticks(self):
        with cxlab.Episode(**GAME) as episode:
            self.assertLess(episode.now, 0)
            self.assertEqual(episode.step(), (0.0, 1, False))
            self.assertEqual(episode.step(ticks=3).ticks, 3)
            self.assertEqual(episode.step(until=5.0).now, episode.now)
            self.assertLessEqual(episode.now, 5.0)
            self.assertEqual(episode.step(until=1.0).ticks, 0)
            self.assertEqual(episode.step(ticks=0).ticks, 0)
            self.assertEqual(episode.step(ticks=5000).ticks, 5000)  # longer than it keeps the lock of the interpreter
            self.assertEqual(episode.result["status"], "running")
        self.assertEqual(episode.result["status"], "stopped")

    def test_times_are_written_as_for_a_run(self):
        with cxlab.Episode(**GAME, until="0:12") as episode:
            self.assertEqual(episode.step(until="0:05").now, episode.step(until=5).now)
            episode.step(until=1e9)
        self.assertEqual(episode.now, 12)

    def test_an_episode_has_no_copy_that_would_close_it(self):
        with cxlab.Episode(**GAME) as episode:
            for copied in (copy.copy, copy.deepcopy, pickle.dumps):
                with self.subTest(copied), self.assertRaisesRegex(TypeError, "cxlab.rerun"):
                    copied(episode)
            self.assertEqual(episode.step().ticks, 1)

    def test_overrides_change_the_scenario(self):
        with cxlab.Episode(**GAME, seed=3, set={"world.team": "MAGENTA", "duration_s": 2}) as episode:
            result = episode.run()
        self.assertEqual((result["seed"], result["tier"], result["sim_time_s"]), (3, "timed", 2))
        self.assertEqual(result["status"], "completed")

    def test_agents_replaces_configurations(self):
        config = self.folder / "nothing.yaml"
        config.write_text("clips_manager:\n  ros__parameters:\n    environments: [mine]\n    mine: {plugins: [executive]}\n    executive: {plugin: 'cx::ExecutivePlugin'}\n")
        with cxlab.Episode(**GAME, agents=[config]) as episode:
            self.assertEqual(episode.environments, ["mine"])

    def test_many_episodes_of_a_process_do_not_know_of_each_other(self):
        def hashes(seed):
            with cxlab.Episode(**GAME, seed=seed, until=60) as episode:
                return episode.run()["journal_hash"]

        alone = [hashes(seed) for seed in (1, 2, 3)]
        beside = [cxlab.Episode(**GAME, seed=seed, until=60) for seed in (1, 2, 3)]
        for t in range(0, 61, 5):
            for episode in beside:
                episode.step(until=t)
        self.assertEqual([episode.close()["journal_hash"] for episode in beside], alone)
        self.assertEqual(len(set(alone)), 3)

        in_threads = [None] * 3
        threads = [
            threading.Thread(target=lambda i=i: in_threads.__setitem__(i, hashes(i + 1))) for i in range(3)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(in_threads, alone)

    def test_other_threads_run_while_ticks_run(self):
        counted = 0
        with cxlab.Episode("rcll/game", tier="physics") as episode:
            stepping = threading.Thread(target=lambda: episode.step(until=8))
            stepping.start()
            while stepping.is_alive():
                counted += 1
                time.sleep(0.001)
        self.assertGreater(counted, 20)

    def test_ctrl_c_ends_a_step_and_leaves_the_run_in_order(self):
        episode = cxlab.Episode("rcll/game", tier="physics", out=self.folder / "run")
        threading.Timer(0.5, _thread.interrupt_main).start()
        with self.assertRaises(KeyboardInterrupt):
            episode.step(until=1e9)
        self.assertFalse(episode.over)
        self.assertEqual(episode.step().ticks, 1)
        self.assertEqual(episode.close()["status"], "stopped")
        self.assertEqual(program("replay", self.folder / "run").returncode, 0)


class Acts(EpisodeTest):
    def test_what_a_program_does_is_in_the_log_and_the_answers(self):
        run = self.folder / "run"
        with cxlab.Episode(**GAME, out=run, until=40) as episode:
            episode.build("(deftemplate hint (slot x))")  # before the first tick
            episode.build("(deftemplate seen (slot x))")
            episode.build("(defrule see (hint (x ?x)) => (assert (seen (x ?x))))")
            episode.step(until=20)
            first = episode.assert_("(hint (x 3))")
            self.assertEqual(episode.assert_("(hint (x 3))"), first)
            self.assertEqual(episode.fact_list("seen"), [])
            episode.step(until=25)
            self.assertEqual(episode.fact_list("seen"), [{"x": 3}])
            self.assertEqual(episode.eval("(+ 1 (fact-index (nth$ 1 (find-fact ((?f seen)) TRUE))))")[0].isdigit(), True)
            episode.retract(first)
            self.assertEqual(episode.fact_list("(hint (x ?))"), [])
            episode.run()
            episode_result = episode.result
        self.assertFalse(episode_result["deterministic"])
        self.assert_replays(run)
        self.assertIn("the program at 20.000 s: (hint (x 3))", program("why", run, "(seen)", "--at", "24").stdout)
        self.assertIn("assert (hint (x 3))", json.dumps(json.loads(program("facts", run, "--at", "24", "hint", "--json").stdout)))
        self.assertNotIn("(hint", program("facts", run, "--at", "30", "hint").stdout)

    def test_what_is_done_after_the_last_tick_replays(self):
        with cxlab.Episode(**GAME, out=self.folder / "run", until=3) as episode:
            episode.step(until=10)
            self.assertTrue(episode.over)
            episode.eval("(printout t late crlf)")
            episode.build("(deftemplate late)")
        self.assert_replays(self.folder / "run")

    def test_a_run_on_another_course_is_refused(self):
        with cxlab.Episode(**GAME, out=self.folder / "run", until=3) as episode:
            episode.step(until=1)
            episode.eval("(+ 1 2)")
            episode.run()
        otherwise = program("rerun", self.folder / "run", "--at", "2", "--assert", "(x)", "--out", self.folder / "b")
        self.assertEqual(otherwise.returncode, 2)
        self.assertIn("program", otherwise.stderr)

    def test_an_environment_has_its_name_among_several(self):
        with cxlab.Episode("rcll/two_teams", tier="timed") as episode:
            episode.step()
            self.assertEqual(episode.environments, ["cyan/agent", "magenta/agent"])
            episode.build("(deftemplate hint (slot x))", env="magenta/agent")
            episode.assert_("(hint (x 3))", env="magenta/agent")
            episode.step()
            self.assertEqual(episode.fact_list("hint", env="magenta/agent"), [{"x": 3}])
            with self.assertRaisesRegex(cxlab.InputError, "no template 'hint'"):
                episode.fact_list("hint", env="cyan/agent")
            with self.assertRaises(cxlab.UsageError) as caught:
                episode.eval("1", env="agent")
            self.assertIn("'agent', expected one of cyan/agent, magenta/agent, which share that name", str(caught.exception))
            with self.assertRaisesRegex(cxlab.UsageError, "found none, expected one of cyan/agent, magenta/agent"):
                episode.fact_list("hint")

    def test_what_rules_print_is_in_the_log_of_python_at_its_level(self):
        prints = '(defrule say => (printout warn "careful" crlf) (printout info "by the way" crlf))'
        for level, wanted in (("INFO", ["careful", "by the way"]), ("WARNING", ["careful"])):
            with self.subTest(level), self.assertLogs("cxlab", level) as logged, cxlab.Episode(**GAME) as episode:
                episode.build(prints)
                episode.step()
            said = [record.getMessage() for record in logged.records if record.getMessage().startswith("0.000 agent: ")]
            self.assertEqual(said, [f"0.000 agent: {text}" for text in wanted])

    def test_mistakes_name_what_is_wrong(self):
        rows = [
            (lambda e: e.fact_list("machin"), cxlab.InputError, "there is no template 'machin', did you mean 'machine'?"),
            (lambda e: e.fact_list("(machine (nam 3))"), cxlab.InputError, "did you mean 'name'?"),
            (lambda e: e.fact_list("(machine"), cxlab.InputError, "parenthes"),
            (lambda e: e.assert_("(machine (nam x))"), cxlab.InputError, "nam"),
            (lambda e: e.assert_("(machin (name x))"), cxlab.InputError, "no deftemplate 'machin', did you mean 'machine'?"),
            (lambda e: e.assert_("(machine"), cxlab.InputError, ""),
            (lambda e: e.assert_(""), cxlab.InputError, ""),
            (lambda e: e.assert_("a\0b"), cxlab.UsageError, "U+0000"),
            (lambda e: e.eval("(nonsense 1)"), cxlab.RunError, "nonsense"),
            (lambda e: e.eval("(lenght$ 1)"), cxlab.RunError, "did you mean 'length$'?"),
            (lambda e: e.build("(defrule"), cxlab.CxlabError, ""),
            (lambda e: e.retract(999999), cxlab.InputError, "there is no fact f-999999"),
            (lambda e: e.retract(-1), cxlab.InputError, "there is no fact"),
            (lambda e: e.eval("1", env="agnt"), cxlab.UsageError, "did you mean 'agent'?"),
            (lambda e: e.publish("/nothing", None, {}), cxlab.UsageError, "give its type"),
            (lambda e: e.publish("/game_stat", None, {}), cxlab.UsageError, "did you mean '/game_state'?"),
            (lambda e: e.publish("/x", "std_msgs/msg/String", {"dat": "x"}), cxlab.CxlabError, "dat"),
            (lambda e: e.publish("/x", "std_msgs/msg/String", {"data": object()}), cxlab.UsageError, "type object"),
            (lambda e: e.publish("/game_state", "std_msgs/msg/String", {}), cxlab.UsageError, "rcll_interfaces/msg/GameState, which is on the bus"),
            (lambda e: e.publish("/game_state", "rcll_interfaces/msg/GameStat", {}), cxlab.CxlabError, "nearest is 'rcll_interfaces/msg/GameState'"),
            (lambda e: e.read("/game_state", "std_msgs/msg/String"), cxlab.UsageError, "rcll_interfaces/msg/GameState, which is on the bus"),
            (lambda e: e.publish("/game state", "std_msgs/msg/String", {}), cxlab.UsageError, "the name "),
            (lambda e: e.call("/clips_manager/create_env", "std_srvs/srv/Empty", {}), cxlab.UsageError, "which is on the bus"),
            (lambda e: e.send_goal("/robot1/drive_to", "example_interfaces/action/Fibonacci", {}), cxlab.UsageError, "which is on the bus"),
            (lambda e: (e.publish("/new", "std_msgs/msg/String", {}), e.publish("/new", "std_msgs/msg/Bool", {})), cxlab.UsageError, "std_msgs/msg/String"),
            (lambda e: e.step(until=float("nan")), cxlab.UsageError, "nan"),
            (lambda e: e.step(until="soon"), cxlab.UsageError, "5:12.4"),
            (lambda e: e.facts("machine", frames="numpy"), cxlab.UsageError, "expected one of pandas"),
            (lambda e: e.render(0, 0), cxlab.CxlabError, ""),
            (lambda e: e.render(64, 64, camera="nowhere"), cxlab.CxlabError, ""),
        ]
        with cxlab.Episode(**GAME) as episode:
            episode.step()
            for number, (act, kind, says) in enumerate(rows):
                with self.subTest(number), self.assertRaises(kind) as caught:
                    act(episode)
                self.assertIn(says, str(caught.exception))
            self.assertEqual(episode.step().ticks, 1)

    def test_bad_scenarios_are_exceptions_with_file_and_line(self):
        broken = self.folder / "broken.yaml"
        broken.write_text("schema: 1\nworld: {kind: rcll}\nnonsense: 3\n")
        with self.assertRaises(cxlab.InputError) as caught:
            cxlab.Episode(broken)
        self.assertEqual((caught.exception.file, caught.exception.line, caught.exception.code), (str(broken), 3, 3))
        with self.assertRaises(cxlab.InputError) as caught:
            cxlab.Episode("rcll/game", set={"world.teem": 1})
        self.assertIn("world.teem", str(caught.exception))
        with self.assertRaises(cxlab.UsageError):
            cxlab.Episode("rcll/game", journal="everything")
        for option, wrong, text in (("seed", -3, "seed: found '-3'"), ("tier", "quick", "tier: found 'quick'"), ("set", {"world.team": "PINK"}, "set world.team: found 'PINK'")):
            with self.subTest(option), self.assertRaises(cxlab.InputError) as caught:
                cxlab.Episode("rcll/game", **{option: wrong})
            self.assertTrue(str(caught.exception).startswith(text), caught.exception)
        for until in (-1, float("nan"), "soon"):
            with self.subTest(until), self.assertRaisesRegex(cxlab.UsageError, "until: "):
                cxlab.Episode("rcll/game", until=until)
        with self.assertRaisesRegex(cxlab.UsageError, "set: found a list"):
            cxlab.Episode("rcll/game", set=[("seed", 1)])
        (self.folder / "full").mkdir()
        (self.folder / "full/file").touch()
        with self.assertRaises(cxlab.UsageError):
            cxlab.Episode(**GAME, out=self.folder / "full")

    def test_a_run_that_fails_raises_and_can_be_closed(self):
        with cxlab.Episode(**GAME, out=self.folder / "run") as episode:
            episode.build("(defrule bad => (+ (nth$ 1 (create$ a)) 1))")
            with self.assertRaises(cxlab.RunError) as caught:
                episode.step(until=5)
            self.assertEqual(caught.exception.code, 4)
            self.assertTrue(episode.over)
        self.assertEqual(episode.result["status"], "failed")
        self.assertEqual(episode.result["reason"]["message"], caught.exception.message)


class Pilot(cxlab.Seat):
    """Drives a turtle, and does `at_one` when the first second is over."""

    def __init__(self, name="pilot", at_one=None):
        super().__init__(name)
        self.at_one = at_one
        self.heard = []

    def begin(self):
        self.bus.read("/star/pose", "turtlesim/msg/Pose", self.heard.append)

    def decide(self, now):
        self.bus.publish("/square/cmd_vel", "geometry_msgs/msg/Twist", {"linear": {"x": 0.5}})
        if now > 1 and self.at_one:
            self.at_one(self)

    def next_due(self):
        return self.bus.now + 0.1


TURTLES = {"scenario": "turtlesim/figures", "set": {"expect": []}}


class Seats(EpisodeTest):
    def test_a_seat_hears_and_drives_and_the_run_replays_without_it(self):
        pilot = Pilot()
        result = cxlab.Episode(**TURTLES, seats=[pilot], out=self.folder / "run", until=5).run()
        alone = cxlab.Episode(**TURTLES, until=5).run()
        self.assertGreater(len(pilot.heard), 100)
        self.assertEqual(set(pilot.heard[0]), {"x", "y", "theta", "linear_velocity", "angular_velocity"})
        self.assertFalse(result["deterministic"])
        self.assertNotEqual(result["turtles"], alone["turtles"])
        self.assert_replays(self.folder / "run")

    def test_what_a_seat_raises_ends_the_run_and_is_raised(self):
        def fail(seat):
            raise LookupError("no way")

        episode = cxlab.Episode(**TURTLES, seats=[Pilot(at_one=fail)], out=self.folder / "run")
        with self.assertRaises(LookupError):
            episode.step(until=10)
        result = episode.close()
        self.assertEqual((result["status"], result["reason"]["code"]), ("failed", "python"))
        self.assertEqual(result["reason"]["message"], "seat pilot: its program raised LookupError: no way")
        self.assertLess(result["sim_time_s"], 1.2)

    def test_what_a_seat_raises_may_have_any_text(self):
        def fail(seat):
            raise ValueError("bad \udc80")

        episode = cxlab.Episode(**TURTLES, seats=[Pilot(at_one=fail)])
        with self.assertRaisesRegex(ValueError, "bad"):
            episode.step(until=10)
        self.assertIn(r"ValueError: bad \udc80", episode.close()["reason"]["message"])

    def test_a_picture_of_a_canvas_has_a_least_size(self):
        with cxlab.Episode("turtlesim/figures") as episode:
            episode.step()
            for size in ((0, 0), (15, 15), (300, 3), (-1, 100), (5000, 5000)):
                with self.subTest(size), self.assertRaisesRegex(cxlab.UsageError, "expected 16 x 16 to 4096 x 4096"):
                    episode.render(*size)
            self.assertEqual(episode.render(16, 16).shape, (16, 16, 3))

    def test_a_reader_that_raises_ends_the_run(self):
        class Deaf(Pilot):
            def begin(self):
                self.bus.read("/star/pose", "turtlesim/msg/Pose", self.refuse)

            def refuse(self, pose):
                raise ZeroDivisionError

        with self.assertRaises(ZeroDivisionError), cxlab.Episode(**TURTLES, seats=[Deaf()]) as episode:
            episode.step(until=10)

    def test_a_seat_cannot_break_the_interpreter(self):
        def step(seat):
            seat.episode.step()

        def close(seat):
            seat.episode.close()

        def forget(seat):
            del seat.episode
            gc.collect()
            raise KeyError("forgotten")

        for act, kind in ((step, cxlab.UsageError), (close, cxlab.UsageError), (forget, KeyError)):
            with self.subTest(act.__name__):
                pilot = Pilot(at_one=act)
                pilot.episode = cxlab.Episode(**TURTLES, seats=[pilot])
                with warnings.catch_warnings(), self.assertRaises(kind):
                    warnings.simplefilter("ignore", ResourceWarning)
                    pilot.episode.step(until=10)
                gc.collect()
                if hasattr(pilot, "episode"):
                    pilot.episode.close()
                with self.assertRaises(cxlab.UsageError):
                    pilot.bus.publish("/x", "std_msgs/msg/String", {})

    def test_seats_that_are_none_are_refused(self):
        class Nameless(cxlab.Seat):
            def __init__(self):
                self.name = 3

        class Timeless(Pilot):
            def next_due(self):
                return "soon"

        class Unborn(Pilot):
            def begin(self):
                raise OSError("not today")

        for seat, kind in (
            (object(), cxlab.UsageError),
            (Nameless(), cxlab.UsageError),
            (Pilot("no name"), cxlab.UsageError),
            (Unborn(), OSError),
        ):
            with self.subTest(seat), self.assertRaises(kind):
                cxlab.Episode(**TURTLES, seats=[seat])
        with self.assertRaises(cxlab.CxlabError), cxlab.Episode(**TURTLES, seats=[Timeless()]) as episode:
            episode.step(until=1)


class Bus(EpisodeTest):
    def test_a_program_reads_publishes_calls_and_sends_goals(self):
        with cxlab.Episode(**TURTLES, out=self.folder / "run", until=8) as episode:
            episode.step(until=1)
            self.assertEqual(episode.topics["/star/pose"].type, "turtlesim/msg/Pose")
            self.assertIn("/spawn", episode.services)
            self.assertEqual(episode.read("/star/pose"), [])
            spawned = episode.call("/spawn", None, {"x": 1.0, "y": 2.0, "name": "t9"})
            self.assertIsNone(spawned.response)
            self.assertEqual(repr(spawned), "<cxlab.Call, waiting>")
            goal = episode.send_goal("/nobody/rotate", "turtlesim/action/RotateAbsolute", {"theta": 1.0})
            episode.step(until=2)
            self.assertEqual(spawned.response, {"name": "t9"})
            self.assertIn("/t9/cmd_vel", episode.topics)
            turn = episode.send_goal("/t9/rotate_absolute", None, {"theta": 1.0})
            episode.publish("/square/cmd_vel", None, {"linear": {"x": 1}})
            episode.step(until=3)
            times = [t for t, _ in episode.read("/star/pose")]
            self.assertGreater(len(times), 50)
            self.assertEqual(times, sorted(times))
            episode.step(until=8)
            self.assertIsNone(goal.accepted)
            self.assertTrue(turn.accepted)
        # What came stays when the episode is closed.
        self.assertEqual(spawned.response, {"name": "t9"})
        self.assertTrue(turn.done and turn.succeeded)
        self.assertEqual([repr(one) for one in (spawned, turn, goal)], ["<cxlab.Call, answered>", "<cxlab.Goal, succeeded>", "<cxlab.Goal, waiting>"])
        self.assertEqual(set(turn.result), {"delta"})
        self.assertGreater(len(turn.feedback), 0)
        self.assertEqual(json.loads((self.folder / "run/manifest.json").read_text())["seats"], ["python"])
        self.assert_replays(self.folder / "run")


    def test_numbers_of_64_bit_come_whole_and_an_unknown_type_is_refused_again(self):
        with cxlab.Episode(**GAME) as episode:
            for kind, largest in (("UInt64", 2**64 - 1), ("Int64", -(2**63)), ("UInt8", 255)):
                topic = f"/{kind.lower()}"
                self.assertEqual(episode.read(topic, f"std_msgs/msg/{kind}"), [])
                episode.publish(topic, f"std_msgs/msg/{kind}", {"data": largest})
                episode.step(ticks=2)
                self.assertEqual([message for _, message in episode.read(topic)], [{"data": largest}])
            for _ in range(2):
                with self.assertRaisesRegex(cxlab.InputError, "nearest is 'std_msgs/msg/String'"):
                    episode.read("/words", "std_msgs/msg/Strin")


class Hostile(EpisodeTest):
    def test_a_closed_episode_refuses_everything(self):
        episode = cxlab.Episode(**GAME)
        call = episode.call("/nothing", "std_srvs/srv/Trigger", {})
        first = episode.close()
        self.assertIs(episode.close(), first)
        self.assertTrue(episode.closed and episode.over)
        self.assertIsNone(call.response)
        for act in (
            episode.step,
            lambda: episode.fact_list(),
            lambda: episode.assert_("(a)"),
            lambda: episode.eval("1"),
            lambda: episode.environments,
            lambda: episode.topics,
            lambda: episode.publish("/x", "std_msgs/msg/String", {}),
            lambda: episode.read("/x", "std_msgs/msg/String"),
            lambda: episode.scene(),
            lambda: episode.render(),
        ):
            with self.assertRaisesRegex(cxlab.UsageError, "the episode is closed"):
                act()

    def test_two_threads_cannot_play_one_episode(self):
        with cxlab.Episode("rcll/game", tier="physics") as episode:
            stepping = threading.Thread(target=lambda: episode.step(until=8))
            stepping.start()
            refused = 0
            while stepping.is_alive():
                try:
                    episode.fact_list("machine")
                except cxlab.UsageError:
                    refused += 1
                time.sleep(0.001)
            self.assertGreater(refused, 0)
            self.assertGreater(episode.now, 0)

    def test_an_episode_may_go_from_thread_to_thread(self):
        episode = cxlab.Episode(**GAME, until=10)
        results = []
        for work in (
            lambda: episode.step(until=5),
            lambda: results.append(episode.eval("(+ 1 1)")),
            lambda: results.append(episode.close()["status"]),
        ):
            thread = threading.Thread(target=work)
            thread.start()
            thread.join()
        self.assertEqual(results, ["2", "stopped"])

    def test_an_episode_that_nobody_closes_warns_and_is_closed(self):
        episode = cxlab.Episode(**GAME, out=self.folder / "run")
        episode.step()
        with self.assertWarns(ResourceWarning):
            del episode
            gc.collect()
        self.assertEqual(json.loads((self.folder / "run/result.json").read_text())["status"], "stopped")

    def test_pictures_without_opengl_name_the_remedy(self):
        with cxlab.Episode(**GAME) as episode:
            os.environ["CXLAB_GL"] = "nonsense"
            self.addCleanup(os.environ.pop, "CXLAB_GL", None)
            with self.assertRaises(cxlab.CxlabError) as caught:
                episode.render()
            self.assertIn("CXLAB_GL", str(caught.exception))


@unittest.skipUnless(HAS_NUMPY, "needs NumPy")
class Seen(EpisodeTest):
    def test_scene_is_arrays(self):
        import numpy as np

        with cxlab.Episode(**GAME) as episode:
            episode.step(until=60)
            scene = episode.scene()
        length = len(scene["id"])
        self.assertEqual({len(column) for column in scene.values()}, {length})
        self.assertEqual(scene["x"].dtype, np.float64)
        robots = scene["kind"] == "robot"
        self.assertEqual(sorted(scene["name"][robots]), ["robot1", "robot2", "robot3"])
        self.assertTrue((np.abs(scene["yaw"]) <= np.pi).all())
        self.assertTrue(set(scene["carried_by"]) - {0} <= set(scene["id"]))

    def test_a_picture_is_an_array(self):
        import numpy as np

        with cxlab.Episode(**GAME) as episode:
            episode.step(until=60)
            try:
                picture = episode.render(320, 200)
            except cxlab.MachineError as error:
                self.assertIn("libosmesa6", str(error))
                self.skipTest("no OpenGL")
            episode.step(until=70)
            later = episode.render(320, 200)
        self.assertEqual((picture.shape, picture.dtype), ((200, 320, 3), np.uint8))
        self.assertGreater(picture.std(), 5)
        self.assertFalse((picture == later).all())


if __name__ == "__main__":
    unittest.main()
