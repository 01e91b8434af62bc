"""A trainer that speaks cx_rl_interfaces, and nothing else, plays games of rcll/rl: the rules serve their choices (cxlab_choices, trainer.clp)."""

import json
import os
import random
import tempfile
import unittest
from pathlib import Path

import cxlab

SHORT = {"servers": [], "world.exploration": False, "world.down": False, "world.production_s": 300, "world.overtime_s": 0}
LEVELS = ["-4", "-3", "-2", "-1", "1", "2", "3", "4"]


class Trainer:
    """Chooses by chance. With several robots it asks for another one as soon as an action was accepted."""

    def __init__(self, episode, seed=1, robots=1):
        self.episode, self.chance, self.robots = episode, random.Random(seed), robots
        self.at_work, self.rewards, self.taken, self.seen = {}, [], [], []
        self.most, self.infos = 0, set()

    def until(self, ready):
        while not ready():
            if self.episode.over:
                raise EOFError
            self.episode.step()

    def ask(self, service, **request):
        call = self.episode.call(f"/cx_rl_node/{service}", None, request)
        self.until(lambda: call.done)
        return call.response

    def goal(self, action, **goal):
        return self.episode.send_goal(f"/cx_rl_node/{action}", None, goal)

    def reset(self):
        goal = self.goal("reset_env")
        self.until(lambda: goal.done)
        return goal.result["confirmation"]

    def free_robot(self):
        goal = self.goal("get_free_robot")
        self.until(lambda: goal.done or self.ended())
        return goal

    def ended(self):
        """Takes the results that have come. True: one reports the end."""
        over = False
        for name in [name for name, goal in self.at_work.items() if goal.done]:
            result = self.at_work.pop(name).result
            self.rewards.append(result["reward"])
            self.infos.add(result["info"])
            over = over or result["info"] == "Done"
        return over

    def play(self, no_op=0.0):
        """One episode; the reward of its end is the last one."""
        while True:
            if len(self.at_work) >= self.robots:
                self.until(lambda: self.ended() or len(self.at_work) < self.robots)
            goal = self.free_robot()
            if goal.done and goal.result["success"]:
                self.select(goal.result["robot"], no_op)
            end = self.ask("get_episode_end")
            if end["episode_end"]:
                self.until(lambda: self.ended() or not self.at_work)
                self.rewards.append(end["reward"])
                return

    def select(self, robot, no_op):
        true = {f"{one['name']}({'#'.join(one['params'])})" for one in self.ask("get_current_observations")["observations"]}
        listed = self.ask("get_action_list_executable_for_robot", robot=robot)
        self.seen.append((robot, true, listed))
        if self.chance.random() < no_op:
            self.taken.append((robot, None))
            return
        action = self.chance.choice(listed["action_ids"])
        self.taken.append((robot, action))
        goal = self.goal("action_selection", action_id=action)
        self.until(lambda: goal.accepted is not None)
        self.at_work[action] = goal
        self.most = max(self.most, len(self.at_work))


def game(**more):
    return cxlab.Episode("rcll/rl", tier="timed", set=SHORT | more.pop("set", {}), journal="decisions", **more)


class OverServices(unittest.TestCase):
    def play(self, seed=1, robots=1, no_op=0.0, **more):
        with game(seed=seed, **more) as episode:
            trainer = Trainer(episode, seed, robots)
            self.assertEqual(trainer.reset(), "Reset completed")
            trainer.play(no_op)
            trainer.ask("end_training")
            episode.run()
        return trainer, episode.result

    def test_the_spaces_have_every_name_that_is_observed(self):
        with game() as episode:
            trainer = Trainer(episode)
            episode.step(until=1)
            self.assertEqual(trainer.ask("get_predefined_observables"), {"observables": []})
            self.assertEqual(trainer.ask("get_predefined_actions"), {"actions": []})
            actions = trainer.ask("get_observable_actions")
            self.assertEqual((actions["action_names"], list(actions["param_counts"]), actions["param_types"]), (["choose"], [1], ["option"]))
            predicates = trainer.ask("get_observable_predicates")
            objects = {kind: trainer.ask("get_observable_objects", type=kind)["objects"] for kind in predicates["param_types"]}
            self.assertEqual(objects["level"], LEVELS)
            self.assertEqual(objects["kind"], ["begin-order", "take-job"])
            self.assertEqual([len(objects[kind]) for kind in ("situation-feature", "option", "option-feature")], [8, 16, 21])
            self.assertEqual(trainer.ask("get_observable_objects", type="nothing")["objects"], [])

    def test_a_whole_game_is_played_and_its_rewards_are_its_points(self):
        for robots, no_op in ((1, 0.0), (4, 0.0), (4, 0.3)):
            with self.subTest(robots=robots, no_op=no_op):
                trainer, result = self.play(robots=robots, no_op=no_op)
                self.assertEqual(sum(trainer.rewards), result["teams"]["CYAN"]["points"])
                self.assertGreater(len(trainer.taken), 20)
                self.assertEqual(trainer.most > 1, robots > 1)
                self.assertLessEqual(trainer.infos, {"", "Done"}, "what was offered could be chosen")
                self.assertEqual({robot for robot, _ in trainer.taken}, {"team", "robot1", "robot2", "robot3"})
                self.assertEqual(result["status"], "stopped")
                self.assertEqual(result["warnings"], [])

    def test_what_is_observed_is_the_choice_that_is_offered(self):
        trainer, _ = self.play()
        for robot, true, listed in trainer.seen:
            kind = "begin-order" if robot == "team" else "take-job"
            self.assertEqual([one for one in true if one.startswith("asked")], [f"asked({kind})"])
            places = [action["params"][0] for action in listed["actions"]]
            self.assertEqual({action["name"] for action in listed["actions"]}, {"choose"})
            self.assertEqual(len(set(listed["action_ids"])), len(places))
            shown = {one[7:].split("#")[0] for one in true if one.startswith("option")}
            self.assertEqual(shown, set(places))  # all options of these choices may be chosen
            self.assertEqual(sum(one.endswith("#1#4)") and one.startswith("option") for one in true), 1, "one is preferred")

    def test_what_is_selected_is_done(self):
        with game() as episode:
            trainer = Trainer(episode, robots=4)
            trainer.reset()
            while (robot := trainer.free_robot().result["robot"]) != "team":
                trainer.select(robot, 0.0)
                trainer.ended()
            self.assertLessEqual(trainer.infos, {""}, "no choice is offered that was made in the same tick")
            (choice,) = episode.fact_list("(choice (kind begin-order))")
            identity = trainer.ask("get_action_list_executable_for_robot", robot=robot)["action_ids"][0]
            self.assertEqual(identity, f"{choice['id']}-1")
            goal = trainer.goal("action_selection", action_id=identity)
            trainer.until(lambda: episode.fact_list(f"(order (id {choice['items'][0]}) (state STARTED))"))
            trainer.until(lambda: goal.done)
            self.assertEqual((goal.result["action_id"], goal.result["info"]), (identity, ""))

    def test_no_op_leaves_a_robot_idle(self):
        with game() as episode:
            trainer = Trainer(episode, robots=4)
            trainer.reset()
            while (robot := trainer.free_robot().result["robot"]) == "team":
                trainer.select(robot, 0.0)
            began = episode.now
            episode.step(until=began + 0.8)
            self.assertEqual(len(episode.fact_list(f'(choice (who "{robot}"))')), 1)
            trainer.until(lambda: episode.fact_list(f'(waits (robot "{robot}"))'))
            self.assertAlmostEqual(episode.now, began + 1, delta=0.3)
            self.assertEqual(episode.fact_list(f'(job (robot "{robot}"))'), [])

    def test_an_action_that_cannot_be_chosen_is_aborted(self):
        with game() as episode:
            trainer = Trainer(episode)
            trainer.reset()
            for wrong in ("99-1", "1-99", "1-0", "nonsense", "", "-", "1-x"):
                with self.subTest(wrong):
                    goal = trainer.goal("action_selection", action_id=wrong)
                    trainer.until(lambda goal=goal: goal.done)
                    self.assertEqual((goal.result["info"], goal.result["reward"]), ("Aborted", 0))
            self.assertEqual(episode.fact_list("choice-made"), [])

    def test_a_robot_that_is_not_wanted_any_more_is_no_answer(self):
        with game(set={"world.setup_s": 20, "world.robots": 0}) as episode:
            trainer = Trainer(episode)
            goal = trainer.goal("get_free_robot")
            episode.step(until=11)
            self.assertEqual([one["feedback"] for one in goal.feedback], ["no robot has a choice yet"] * 2)
            goal.cancel()
            trainer.until(lambda: goal.done)
            self.assertFalse(goal.succeeded)
            self.assertEqual(episode.fact_list("robot-wanted"), [])

    def test_another_episode_is_another_run(self):
        with game() as episode:
            trainer = Trainer(episode)
            trainer.reset()
            with self.assertRaises(EOFError):
                trainer.reset()
            self.assertEqual(episode.close()["status"], "stopped")

    def test_without_a_trainer_the_rules_play(self):
        with game(seed=3) as episode:
            points = episode.run()["teams"]["CYAN"]["points"]
        self.assertGreater(points, 30)

    def test_the_same_seed_is_the_same_run_and_it_replays(self):
        with tempfile.TemporaryDirectory() as folder:
            runs = [self.play(seed=5, robots=4, out=Path(folder) / name) for name in ("one", "two")]
            self.assertEqual(runs[0][0].taken, runs[1][0].taken)
            self.assertEqual(runs[0][1]["journal_hash"], runs[1][1]["journal_hash"])
            from subprocess import run

            replayed = run([os.environ["CXLAB"], "replay", Path(folder) / "one"], capture_output=True, text=True)
            self.assertEqual(replayed.returncode, 0, replayed.stderr)
        self.assertNotEqual(self.play(seed=6, robots=4)[0].taken, runs[0][0].taken)


NOTES = "(defrule note (declare (salience 100)) (choice-made (choice ?id) (option ?option)) => (assert (noted ?id ?option)))"


def noted(episode, env=None):
    """The options of all choices that were made so far, in order."""
    return [option for _, option in sorted(fact["implied"] for fact in episode.fact_list("(noted $?)", env=env))]


class WithAModel(unittest.TestCase):
    """Mode EXECUTION: nobody trains, and the rules ask the node of a model that was trained before."""

    def chosen(self, **server):
        with game(set={"servers": [{"node": "cx_rl_node", "rl_mode": "EXECUTION", **server}]}) as episode:
            episode.build(NOTES)
            while not episode.over:
                episode.step(until=episode.now + 10)
            self.assertEqual(episode.eval("?*ANSWERED*"), "TRUE")
            options = noted(episode)
            self.assertEqual(len(options), int(episode.eval("?*last-choice*")) - len(episode.fact_list("choice")))
            return options, episode.close()

    def test_the_model_chooses_by_what_is_observed(self):
        with game() as episode:
            trainer = Trainer(episode)
            trainer.reset()
            trainer.select(trainer.free_robot().result["robot"], 1.0)
            _, first, listed = trainer.seen[0]
        self.assertGreater(len(listed["action_ids"]), 1)
        alone, _ = self.chosen()
        self.assertGreater(len(alone), 5)
        self.assertEqual(set(alone), {1})  # the first action, where a table knows nothing
        with tempfile.TemporaryDirectory() as folder:
            model = Path(folder, "model.json")
            model.write_text(json.dumps({" ".join(sorted(first)): {"choose(2)": 1.0}}))
            taught, _ = self.chosen(model=str(model))
        self.assertEqual((taught[0], set(taught[1:])), (2, {1}))


# An agent that can restart its world: it opens one of twenty doors, three times.
DOORS = """(deffacts beginning (training (kinds open-door) (situation 3) (features 1)) (at-a-wall))
(defrule ask
  ?wall <- (at-a-wall)
  (time ?now)
  =>
  (retract ?wall)
  (bind ?options (create$))
  (bind ?allowed (create$))
  (bind ?features (create$))
  (loop-for-count (?i 1 20)
    (bind ?options ?options (str-cat "door " ?i))
    (bind ?allowed ?allowed (neq ?i 3))
    (bind ?features ?features (/ ?i -20.0)))
  (assert (choice (id (new-choice)) (kind open-door) (who "r1") (items ?options) (options ?options) (allowed ?allowed) (preferred 18)
                  (situation 0.6 -1.0 0.1) (features ?features) (since ?now))))
(defrule open
  ?choice <- (choice (id ?id))
  (choice-made (choice ?id) (option ?option))
  ?training <- (training (points ?points))
  =>
  (retract ?choice)
  (assert (opened ?id ?option) (at-a-wall))
  (modify ?training (points (+ ?points 1)) (over (= ?points 2))))
(defrule again
  ?wanted <- (reset-wanted)
  ?training <- (training)
  =>
  (retract ?wanted)
  (delayed-do-for-all-facts ((?c choice)) TRUE (retract ?c))
  (delayed-do-for-all-facts ((?o opened)) TRUE (retract ?o))
  (modify ?training (points 0) (over FALSE))
  (assert (at-a-wall)))
"""
CONFIG = """/**:
  ros__parameters:
    environments: [main, model]
    main: {plugins: [executive, ros_msgs, reset, free_robot, selection, files]}
    model: {plugins: [executive, ros_msgs, model_files]}
    executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 10}
    ros_msgs: {plugin: "cx::RosMsgsPlugin"}
    reset: {plugin: "cx::CXCxRlInterfacesResetEnvPlugin"}
    free_robot: {plugin: "cx::CXCxRlInterfacesGetFreeRobotPlugin"}
    selection: {plugin: "cx::CXCxRlInterfacesActionSelectionPlugin"}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: [doors, cxlab_choices], load: [clips/choices.clp, clips/trainer.clp, doors.clp]}
    model_files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: [doors], load: [model.clp]}
"""


# A node with a model: it answers with no-op, with something that is no option, and then with option 5.
MODEL = """(defglobal ?*asked* = 0)
(deffunction /cx_rl_node/get_status-service-callback (?service ?request ?response) (ros-msgs-set-field ?response "mode" "EXECUTION"))
(deffunction /cx_rl_node/exec_action_selection-service-callback (?service ?request ?response)
  (bind ?*asked* (+ ?*asked* 1))
  (bind ?ids (ros-msgs-get-field ?request "action_ids"))
  (ros-msgs-set-field ?response "action_id" (switch ?*asked* (case 1 then "") (case 2 then "2-3") (default (nth$ 4 ?ids)))))
(defrule serve
  (wanted)
  =>
  (ros-msgs-create-service "/cx_rl_node/get_status" "cx_rl_interfaces/srv/GetStatus")
  (ros-msgs-create-service "/cx_rl_node/exec_action_selection" "cx_rl_interfaces/srv/ExecActionSelection"))
"""


class OfAnotherAgent(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = Path(folder.name)
        (path / "doors").mkdir()
        (path / "doors/doors.clp").write_text(DOORS)
        (path / "doors/model.clp").write_text(MODEL)
        (path / "doors.yaml").write_text(CONFIG)
        (path / "scenario.yaml").write_text("schema: 1\nduration_s: 1000\nagents: [{config: doors.yaml, packages: {doors: doors}}]\n")
        self.episode = cxlab.Episode(path / "scenario.yaml")
        self.addCleanup(self.episode.close)
        self.trainer = Trainer(self.episode)

    def facts(self, pattern):
        return self.episode.fact_list(pattern, env="main")

    def test_a_node_that_comes_late_with_a_model_is_asked(self):
        self.episode.build(NOTES, env="main")
        self.episode.step(until=3)
        self.assertEqual(noted(self.episode, "main"), [])
        self.episode.assert_("(wanted)", env="model")
        self.episode.step(until=8)
        options = noted(self.episode, "main")
        self.assertEqual((options[:2], set(options[2:])), ([20, 20], {5}))
        self.assertGreater(len(options), 5)

    def test_its_world_begins_again_for_each_episode(self):
        for number in range(3):
            self.trainer.rewards.clear()
            self.assertEqual(self.trainer.reset(), "Reset completed")
            self.assertEqual(self.facts("opened"), [])
            self.trainer.play()
            self.assertEqual(len(self.facts("opened")), 3, number)
            self.assertEqual(sum(self.trainer.rewards), 3)
        # In the middle of an episode as well.
        self.trainer.reset()
        self.trainer.select("r1", 0.0)
        self.trainer.reset()
        self.assertEqual(self.facts("training")[0]["points"], 0)
        self.assertEqual(self.facts("at-work"), [])

    def test_a_choice_that_is_withdrawn_does_not_end_the_episode(self):
        self.trainer.reset()
        robot = self.trainer.free_robot().result["robot"]
        self.episode.eval("(do-for-all-facts ((?c choice)) TRUE (retract ?c))", env="main")
        self.episode.step(until=self.episode.now + 0.2)
        self.assertEqual(self.facts("offered"), [])
        listed = self.trainer.ask("get_action_list_executable_for_robot", robot=robot)
        self.assertEqual([(action["name"], action["params"]) for action in listed["actions"]], [("choose", ["1"])])
        goal = self.trainer.goal("action_selection", action_id=listed["action_ids"][0])
        self.trainer.until(lambda: goal.done)
        self.assertEqual((goal.result["info"], self.trainer.ask("get_episode_end")["episode_end"]), ("Aborted", False))

    def test_of_many_options_the_first_ones_the_preferred_one_and_the_last_one_are_shown(self):
        self.trainer.reset()
        robot = self.trainer.free_robot().result["robot"]
        listed = self.trainer.ask("get_action_list_executable_for_robot", robot=robot)
        options = {action["params"][0]: identity.split("-")[1] for action, identity in zip(listed["actions"], listed["action_ids"])}
        self.assertEqual(options, {str(n): str(n) for n in range(1, 15) if n != 3} | {"15": "18", "16": "20"})
        observed = self.trainer.ask("get_current_observations")["observations"]
        levels = {one["params"][0]: int(one["params"][2]) for one in observed if one["name"] == "option"}
        self.assertEqual((levels["3"], levels["15"], levels["16"], "1" in levels), (-1, -4, -4, False))
        self.assertEqual([one["params"] for one in observed if one["name"] == "situation"], [["1", "2"], ["2", "-4"]])


if __name__ == "__main__":
    unittest.main()
