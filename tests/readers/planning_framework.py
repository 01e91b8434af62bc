"""The engine `cxlab` of the Unified Planning Framework, judged by the Framework's own test cases and report. ./dev readers

The package of the Framework has 134 test cases, but lacks the PDDL files of some folders; those are in WITHOUT_FILES.
"""

import contextlib
import importlib
import io
import pathlib
import pkgutil
import subprocess
import sys
import tempfile
import unittest
import warnings
from fractions import Fraction

import up_test_cases
from unified_planning.engines import PlanGenerationResultStatus as Status
from unified_planning.engines import ValidationResultStatus as Validity
from unified_planning.environment import Environment
from unified_planning.exceptions import UPNoSuitableEngineAvailableException
from unified_planning.io import PDDLReader
from unified_planning.plans import ActionInstance, SequentialPlan, TimeTriggeredPlan
from unified_planning.shortcuts import *  # noqa: F403
from unified_planning.test import get_test_cases

FOLDER = pathlib.Path(up_test_cases.__file__).parent
sys.path.insert(0, str(FOLDER))  # report.py and utils.py of the Framework are read from there
warnings.simplefilter("ignore")
with contextlib.redirect_stdout(io.StringIO()):
    import report  # noqa: E402

import cxlab.up  # noqa: E402
from cxlab.up import CxlabEngine  # noqa: E402

WITHOUT_FILES = {"classical", "numeric", "temporal", "classical.depots", "classical.tpp", "numeric.depots", "numeric.farmlands",
                 "numeric.fn_counters", "numeric.plant_watering", "numeric.rovers", "temporal.depot"}
BUILT_IN_WITHOUT = WITHOUT_FILES | {"processes.constant_derivative"}  # calls a method that the Framework does not have
SUPPORTED = 75


def modules():
    """The modules with test cases, and those that cannot be read."""
    cases, unread = {}, {}
    for root in ("builtin", "performance"):
        package = importlib.import_module(root)
        for module in pkgutil.walk_packages(package.__path__, root + "."):
            try:
                found = importlib.import_module(module.name)
                if hasattr(found, "get_test_cases"):
                    cases.update({f"{module.name}:{name}": case for name, case in found.get_test_cases().items()})
            except Exception as error:  # noqa: BLE001
                unread[module.name] = error
    return cases, unread


CASES, UNREAD = modules()
CASES.update(get_test_cases())
OURS = {name: case for name, case in CASES.items() if CxlabEngine.supports(case.problem.kind)}


def judge(problem, plan):
    """What the validators of the Framework say, and what cxlab says."""
    words = []
    try:
        with PlanValidator(problem_kind=problem.kind, plan_kind=plan.kind) as validator:
            words.append(validator.validate(problem, plan).status)
    except UPNoSuitableEngineAvailableException:
        words.append("no validator")
    with PlanValidator(name="cxlab") as validator:
        words.append(validator.validate(problem, plan).status)
    return words


class TheFramework(unittest.TestCase):
    """Its own cases, by its own report."""

    def report(self, mode, *arguments):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            errors = mode(["cxlab"], OURS, *arguments)
        self.assertEqual(errors, [], out.getvalue())
        return out.getvalue()

    def test_all_cases_that_the_package_has_are_read(self):
        self.assertEqual({name.split(".", 1)[1] for name in UNREAD if name.startswith("builtin.")}, BUILT_IN_WITHOUT)
        self.assertEqual({name.split(".", 1)[1] for name in UNREAD if name.startswith("performance.")}, WITHOUT_FILES | {"numeric.sailing"})
        self.assertEqual((len(CASES), len(OURS)), (134, SUPPORTED))

    def test_one_shot(self):
        text = self.report(report.report_oneshot, 30, False)
        for word in ("INCOMPLETELY", "TIMEOUT", "WARN", "Err"):
            self.assertNotIn(word, text)

    def test_anytime(self):
        self.report(report.report_anytime, 1, False)

    def test_validation(self):
        text = self.report(report.report_validation, False)
        self.assertGreater(text.count("OK(Valid)") + text.count("OK(Invalid)"), 120)

    def test_every_plan_is_judged_by_both(self):
        for name, case in OURS.items():
            with self.subTest(name), OneshotPlanner(name="cxlab") as planner:
                result = planner.solve(case.problem, timeout=30)
                self.assertEqual(result.plan is not None, case.solvable, result)
                if result.plan is not None:
                    self.assertEqual(judge(case.problem, result.plan), [Validity.VALID, Validity.VALID], result.plan)
                    optimum = case.optimum is not None and result.status == Status.SOLVED_OPTIMALLY
                    if optimum:
                        with PlanValidator(problem_kind=case.problem.kind, plan_kind=result.plan.kind) as validator:
                            self.assertEqual(list(validator.validate(case.problem, result.plan).metric_evaluations.values()), [case.optimum])

    def test_an_anytime_search_reaches_the_optimum(self):
        tried = 0
        for name, case in OURS.items():
            if case.optimum is None:
                continue
            with self.subTest(name), AnytimePlanner(name="cxlab", params={"budget": 400000}) as planner:
                *_, last = planner.get_solutions(case.problem)
                with PlanValidator(problem_kind=case.problem.kind, plan_kind=last.plan.kind) as validator:
                    values = validator.validate(case.problem, last.plan).metric_evaluations.values()
                self.assertEqual(list(values), [case.optimum])
                tried += 1
        self.assertGreaterEqual(tried, 3)

    def test_pddl_files_of_the_framework(self):
        folder = pathlib.Path(sys.modules["unified_planning.test"].__file__).parent / "pddl"
        solved = 0
        for domain in sorted(folder.glob("*/domain.pddl")):
            problem = PDDLReader().parse_problem(str(domain), str(domain.with_name("problem.pddl")))
            if not CxlabEngine.supports(problem.kind):
                continue
            with self.subTest(domain.parent.name), OneshotPlanner(name="cxlab") as planner:
                result = planner.solve(problem, timeout=60)
                self.assertIn(result.status, (Status.SOLVED_SATISFICING, Status.SOLVED_OPTIMALLY), result.log_messages)
                self.assertEqual(judge(problem, result.plan), [Validity.VALID, Validity.VALID])
                solved += 1
        self.assertGreaterEqual(solved, 8)


class Registration(unittest.TestCase):
    def test_an_import_registers_the_engine_once(self):
        factory = get_environment().factory
        self.assertIn("cxlab", factory.engines)
        cxlab.up.register()
        self.assertEqual(factory.preference_list.count("cxlab"), 1)
        environment = Environment()
        self.assertNotIn("cxlab", environment.factory.engines)
        cxlab.up.register(environment)
        self.assertIn("cxlab", environment.factory.engines)

    def test_a_section_of_up_ini_registers_it_without_an_import(self):
        with tempfile.TemporaryDirectory() as folder:
            section = subprocess.run([sys.executable, "-m", "cxlab.up"], capture_output=True, text=True, check=True).stdout
            pathlib.Path(folder, "up.ini").write_text(section)
            script = pathlib.Path(folder, "script.py")
            script.write_text("from unified_planning.shortcuts import *\nget_environment().credits_stream = None\nwith OneshotPlanner(name='cxlab') as p: print(p.name)\n"
                              "print(get_environment().factory.preference_list.count('cxlab'))\n")
            done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stdout.splitlines(), ["cxlab", "1"])

    def test_the_framework_chooses_it_where_nothing_else_fits(self):
        case = CASES["test:matchcellar"]
        with OneshotPlanner(problem_kind=case.problem.kind) as planner:
            self.assertEqual(planner.name, "cxlab")
        self.assertIn("oversubscription[cxlab]", get_environment().factory.engines)


class Meaning(unittest.TestCase):
    """Where PDDL and the Framework differ."""

    def solve(self, problem, *, status=Status.SOLVED_SATISFICING, **parameters):
        with OneshotPlanner(name="cxlab", params=parameters) as planner:
            self.assertTrue(planner.supports(problem.kind), problem.kind)
            result = planner.solve(problem, timeout=20)
        self.assertEqual(result.status, status, result.log_messages)
        if result.plan is not None:
            self.assertEqual(judge(problem, result.plan), [Validity.VALID, Validity.VALID])
        return result.plan

    def problem(self, *fluents, **values):
        problem = Problem("p")
        for fluent in fluents:
            problem.add_fluent(fluent, default_initial_value=values.get(fluent.name, False if fluent.type.is_bool_type() else 0))
        return problem

    def test_durations_are_exact(self):
        done = Fluent("done")
        problem = self.problem(done)
        for lower, upper, of in ((Fraction(1, 3), Fraction(1, 3), "closed"), (Fraction(1, 3), Fraction(2, 3), "open"), (Fraction(1, 3), 2, "left_open")):
            problem.clear_actions()
            action = DurativeAction("act")
            getattr(action, f"set_{of}_duration_interval")(lower, upper)
            action.add_effect(EndTiming(), done, True)
            problem.add_action(action)
            problem.clear_goals()
            problem.add_goal(done)
            plan = self.solve(problem)
            (_, _, duration), = plan.timed_actions
            if of == "closed":
                self.assertEqual(duration, Fraction(1, 3))
            else:
                self.assertGreater(duration, Fraction(1, 3))

    def test_an_open_interval_of_no_width_has_no_duration(self):
        done, least, most = Fluent("done"), Fluent("least", RealType()), Fluent("most", RealType())
        problem = self.problem(done, least, most, least=1, most=1)
        action = DurativeAction("act")
        action.set_open_duration_interval(least, most)
        action.add_effect(EndTiming(), done, True)
        problem.add_action(action)
        problem.add_goal(done)
        self.solve(problem, status=Status.UNSOLVABLE_INCOMPLETELY)

    def test_two_actions_that_give_one_fact_its_value_do_not_end_together(self):
        shared, x, y = Fluent("shared"), Fluent("x"), Fluent("y")
        problem = self.problem(shared, x, y)
        for name, fluent in (("a", x), ("b", y)):
            action = DurativeAction(name)
            action.set_fixed_duration(2)
            action.add_effect(EndTiming(), shared, True)
            action.add_effect(EndTiming(), fluent, True)
            problem.add_action(action)
            problem.add_goal(fluent)
        plan = self.solve(problem)
        starts = [start for start, _, _ in plan.timed_actions]
        self.assertGreaterEqual(abs(starts[0] - starts[1]), Fraction(1, 1000))
        problem.add_timed_effect(GlobalStartTiming(2), shared, True)
        self.solve(problem)
        together = TimeTriggeredPlan([(Fraction(0), ActionInstance(action), Fraction(2)) for action in problem.actions])
        self.assertEqual(judge(problem, together), [Validity.INVALID, Validity.INVALID])

    def test_an_action_does_not_overlap_itself_unless_it_may(self):
        count, met = Fluent("count", IntType()), Fluent("met")
        problem = self.problem(count, met)
        work, meet = DurativeAction("work"), DurativeAction("meet")
        work.set_fixed_duration(2)
        work.add_increase_effect(StartTiming(), count, 1)
        work.add_decrease_effect(EndTiming(), count, 1)
        meet.set_fixed_duration(1)
        meet.add_condition(StartTiming(), GE(count, 2))
        meet.add_effect(EndTiming(), met, True)
        problem.add_actions([work, meet])
        problem.add_goal(met)
        self.solve(problem, status=Status.UNSOLVABLE_INCOMPLETELY)
        problem.self_overlapping = True
        plan = self.solve(problem)
        problem.self_overlapping = False
        with PlanValidator(name="cxlab") as validator:
            self.assertEqual(validator.validate(problem, plan).status, Validity.INVALID)

    def test_numbers_keep_their_bounds(self):
        place = UserType("Place")
        level = Fluent("level", IntType(0, 10), place=place)
        problem = self.problem(level)
        first, second = Object("first", place), Object("second", place)
        problem.add_objects([first, second])
        problem.set_initial_value(level(first), 8)
        pour = InstantaneousAction("pour", out=place, into=place)
        pour.add_decrease_effect(level(pour.parameter("out")), 3)
        pour.add_increase_effect(level(pour.parameter("into")), 3)
        fill = InstantaneousAction("fill", into=place)
        fill.add_increase_effect(level(fill.parameter("into")), 4)
        problem.add_actions([pour, fill])
        problem.add_goal(Equals(level(second), 10))
        self.solve(problem)
        problem.clear_goals()
        problem.add_goal(GT(level(second), 10))
        self.solve(problem, status=Status.UNSOLVABLE_INCOMPLETELY)
        over = SequentialPlan([ActionInstance(fill, (ObjectExp(first),))])
        self.assertEqual(judge(problem, over), [Validity.INVALID, Validity.INVALID])

    def test_proofs_are_given_where_both_mean_the_same(self):
        x, y = Fluent("x"), Fluent("y")
        problem = self.problem(x, y)
        action = InstantaneousAction("act")
        action.add_precondition(y)
        action.add_effect(x, True)
        problem.add_action(action)
        problem.add_goal(x)
        self.solve(problem, status=Status.UNSOLVABLE_PROVEN)
        problem.clear_goals()
        problem.add_goal(FALSE())
        self.solve(problem, status=Status.UNSOLVABLE_PROVEN)
        third = Fluent("third", RealType())
        problem = self.problem(third)
        action = InstantaneousAction("act")
        action.add_increase_effect(third, Fraction(1, 3))
        problem.add_action(action)
        problem.add_goal(Equals(third, 1))  # 0.3333333333 three times is not 1: no proof
        self.solve(problem, status=Status.UNSOLVABLE_INCOMPLETELY)

    def test_an_assignment_of_a_condition_is_written(self):
        source, copy = Fluent("source"), Fluent("copy")
        for action in (InstantaneousAction("act"), DurativeAction("act")):
            problem = self.problem(source, copy, source=True)
            at = () if isinstance(action, InstantaneousAction) else (EndTiming(),)
            if at:
                action.set_fixed_duration(1)
            action.add_effect(*at, copy, source)
            action.add_effect(*at, source, Not(source))
            problem.add_action(action)
            problem.add_goal(And(copy, Not(source)))
            self.assertIsNotNone(self.solve(problem))

    def test_names_of_every_kind(self):
        kind = UserType("Big Type")
        at, At = Fluent("at", BoolType(), x=kind), Fluent("At", BoolType(), duration=kind)
        problem = self.problem(at, At)
        objects = [Object(name, kind) for name in ("1", "object", "Foo", "foo", "over all", "ä", "either")]
        problem.add_objects(objects)
        action = DurativeAction("do it", duration=kind)
        action.set_closed_duration_interval(1, 2)
        action.add_effect(EndTiming(), at(action.parameter("duration")), True)
        action.add_effect(EndTiming(), At(action.parameter("duration")), True)
        problem.add_action(action)
        for one in objects:
            problem.add_goal(And(at(one), At(one)))
        self.assertEqual(len(self.solve(problem).timed_actions), len(objects))

    def test_costs_may_depend_on_the_state_and_be_called_anything(self):
        price, total, goal = Fluent("price", IntType()), Fluent("total-cost", IntType()), Fluent("goal")
        problem = self.problem(price, total, goal, price=5)
        buy, haggle = InstantaneousAction("buy"), InstantaneousAction("haggle")
        buy.add_effect(goal, True)
        buy.add_increase_effect(total, 7)
        haggle.add_precondition(GE(price, 4))
        haggle.add_decrease_effect(price, 4)
        problem.add_actions([buy, haggle])
        problem.add_goal(goal)
        problem.add_quality_metric(MinimizeActionCosts({buy: price + 0, haggle: Int(1)}))
        self.solve(problem)
        with AnytimePlanner(name="cxlab", params={"budget": 200000}) as planner:
            results = list(planner.get_solutions(problem))
        self.assertEqual({result.status for result in results[:-1]}, {Status.INTERMEDIATE})
        self.assertEqual([action.action.name for action in results[-1].plan.actions], ["haggle", "buy"])

    def test_what_the_kind_does_not_tell_is_refused(self):
        number = Fluent("number", IntType())
        problem = self.problem(number)
        problem.add_increase_effect(GlobalStartTiming(3), number, 2)
        problem.add_goal(GE(number, 2))
        self.solve(problem, status=Status.UNSUPPORTED_PROBLEM)
        problem = self.problem(number, number=2**60)
        problem.add_goal(GE(number, 2**60 + 2))
        self.solve(problem, status=Status.UNSUPPORTED_PROBLEM)

    def test_limits_end_a_search(self):
        case = CASES["performance.numeric.block_grouping:block_grouping_20_25_4_6"]
        with OneshotPlanner(name="cxlab", params={"budget": 10}) as planner:
            self.assertEqual(planner.solve(case.problem).status, Status.TIMEOUT)
        with OneshotPlanner(name="cxlab") as planner:
            self.assertEqual(planner.solve(case.problem, timeout=1e-3).status, Status.TIMEOUT)
            out = io.StringIO()
            planner.solve(CASES["test:basic"].problem, output_stream=out)
            self.assertIn("plan: 1 steps", out.getvalue())

    def test_features_that_are_right_only_without_time(self):
        self.assertFalse(CxlabEngine.supports(ProblemKind({"ACTION_BASED", "CONTINUOUS_TIME", "STATE_INVARIANTS"}, version=3)))
        self.assertTrue(CxlabEngine.supports(ProblemKind({"ACTION_BASED", "STATE_INVARIANTS"}, version=3)))
        for feature in ("HIERARCHICAL", "TIMED_GOALS", "INTERMEDIATE_CONDITIONS_AND_EFFECTS", "PROCESSES", "SIMULATED_EFFECTS", "FLUENTS_IN_DURATIONS"):
            self.assertFalse(CxlabEngine.supports(ProblemKind({"ACTION_BASED", feature}, version=3)), feature)


if __name__ == "__main__":
    unittest.main()
