"""The engine `cxlab` of the Unified Planning Framework (unified-planning 1.3): planner and plan validator.

    >>> import cxlab.up
    >>> from unified_planning.shortcuts import OneshotPlanner
    >>> with OneshotPlanner(name="cxlab") as planner:
    ...     result = planner.solve(problem, timeout=10)

Importing this module registers the engine. `python -m cxlab.up` prints the section of `up.ini` that does so without an
import.
"""

# mypy: disable-error-code="import-untyped,misc,no-any-return"
# The Framework has no types.

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import IO, Any

import unified_planning as up
from unified_planning.engines import Credits, Engine, LogLevel, LogMessage, PlanGenerationResult, ValidationResult
from unified_planning.engines import PlanGenerationResultStatus as Status
from unified_planning.engines import ValidationResultStatus as Validity
from unified_planning.engines.compilers.state_invariants_remover import StateInvariantsRemover
from unified_planning.engines.compilers.usertype_fluents_remover import UsertypeFluentsRemover
from unified_planning.engines.mixins import (
    AnytimePlannerMixin,
    CompilationKind,
    OneshotPlannerMixin,
    PlanValidatorMixin,
)
from unified_planning.engines.mixins.anytime_planner import AnytimeGuarantee
from unified_planning.engines.mixins.oneshot_planner import OptimalityGuarantee
from unified_planning.engines.plan_validator import SequentialPlanValidator, TimeTriggeredPlanValidator
from unified_planning.engines.results import FailedValidationReason
from unified_planning.environment import get_environment
from unified_planning.exceptions import UPException
from unified_planning.io import PDDLWriter
from unified_planning.model import (
    DurativeAction,
    Effect,
    EffectKind,
    EndTiming,
    FNode,
    InstantaneousAction,
    Problem,
    ProblemKind,
    StartTiming,
    UPState,
)
from unified_planning.model.walkers import StateEvaluator
from unified_planning.plans import ActionInstance, PlanKind, SequentialPlan, TimeTriggeredPlan

from . import planning
from .errors import CxlabError

__all__ = ["CxlabEngine", "register"]

_KIND = ProblemKind(
    {
        "ACTION_BASED",
        "SIMPLE_NUMERIC_PLANNING",
        "GENERAL_NUMERIC_PLANNING",
        "CONTINUOUS_TIME",
        "TIMED_EFFECTS",
        "DURATION_INEQUALITIES",
        "SELF_OVERLAPPING",
        "STATIC_FLUENTS_IN_DURATIONS",
        "INT_TYPE_DURATIONS",
        "REAL_TYPE_DURATIONS",
        "BOUNDED_TYPES",
        "NEGATIVE_CONDITIONS",
        "DISJUNCTIVE_CONDITIONS",
        "EQUALITIES",
        "EXISTENTIAL_CONDITIONS",
        "UNIVERSAL_CONDITIONS",
        "CONDITIONAL_EFFECTS",
        "INCREASE_EFFECTS",
        "DECREASE_EFFECTS",
        "STATIC_FLUENTS_IN_BOOLEAN_ASSIGNMENTS",
        "STATIC_FLUENTS_IN_NUMERIC_ASSIGNMENTS",
        "STATIC_FLUENTS_IN_OBJECT_ASSIGNMENTS",
        "FLUENTS_IN_BOOLEAN_ASSIGNMENTS",
        "FLUENTS_IN_NUMERIC_ASSIGNMENTS",
        "FLUENTS_IN_OBJECT_ASSIGNMENTS",
        "FORALL_EFFECTS",
        "FLAT_TYPING",
        "HIERARCHICAL_TYPING",
        "INT_FLUENTS",
        "REAL_FLUENTS",
        "OBJECT_FLUENTS",
        "ACTIONS_COST",
        "FINAL_VALUE",
        "MAKESPAN",
        "PLAN_LENGTH",
        "STATIC_FLUENTS_IN_ACTIONS_COST",
        "FLUENTS_IN_ACTIONS_COST",
        "INT_NUMBERS_IN_ACTIONS_COST",
        "REAL_NUMBERS_IN_ACTIONS_COST",
        "STATE_INVARIANTS",
    },
    version=3,
)
_NOT_WITH_TIME = ("STATE_INVARIANTS", "FLUENTS_IN_ACTIONS_COST")
"""Supported where all actions are instantaneous only: PDDL has no word for what the Framework means by them in time."""

_MICROSECOND = Fraction(1, 10**6)
_EPSILON = Fraction(1, 1000)  # s, between happenings that interfere; the planner's own
_MOST_SEPARATIONS = 1000

Timed = list[tuple[Fraction, ActionInstance, Fraction | None]]


class _Unsupported(Exception):
    """Something of a problem that its kind does not tell."""


class CxlabEngine(Engine, OneshotPlannerMixin, AnytimePlannerMixin, PlanValidatorMixin):
    """Plans and validates with `cxlab plan` and `cxlab validate`.

    Parameters of the engine (`OneshotPlanner(name="cxlab", params={...})`):
        budget: work units; the same budget gives the same plan. Default: 60 million; none where `timeout` is given.
        patience: of an anytime search: end when no better plan is found for so many units.
        memory: address space of the planner, bytes.
    """

    def __init__(self, budget: int | None = None, patience: int | None = None, memory: int | None = None) -> None:
        Engine.__init__(self)
        OneshotPlannerMixin.__init__(self)
        AnytimePlannerMixin.__init__(self)
        PlanValidatorMixin.__init__(self)
        self._budget = budget
        self._patience = patience
        self._memory = memory

    @property
    def name(self) -> str:
        return "cxlab"

    @staticmethod
    def get_credits(**_: Any) -> Credits:
        return Credits(
            name="cxlab",
            author="the authors of cxlab",
            contact="",
            website="",
            license="see the package cxlab",
            short_description="The planner of cxlab: durative actions, numbers, events; one-shot, anytime, validator.",
            long_description="The planner of cxlab, a laboratory for rule-based robot agents: PDDL 2.1 with durations, "
            "numbers and timed effects. The same budget gives the same plan.",
        )

    @staticmethod
    def supported_kind() -> ProblemKind:
        return _KIND.clone()

    @staticmethod
    def supports(problem_kind: ProblemKind) -> bool:
        if not problem_kind <= _KIND:
            return False
        features = problem_kind.features
        if "CONTINUOUS_TIME" in features:
            return features.isdisjoint(_NOT_WITH_TIME)
        return "MAKESPAN" not in features

    @staticmethod
    def supports_plan(plan_kind: PlanKind) -> bool:
        return plan_kind in (PlanKind.SEQUENTIAL_PLAN, PlanKind.TIME_TRIGGERED_PLAN)

    @staticmethod
    def satisfies(optimality_guarantee: OptimalityGuarantee) -> bool:
        return optimality_guarantee == OptimalityGuarantee.SATISFICING

    @staticmethod
    def ensures(anytime_guarantee: AnytimeGuarantee) -> bool:
        return anytime_guarantee == AnytimeGuarantee.INCREASING_QUALITY

    def _solve_with_params(
        self,
        problem: up.model.AbstractProblem,
        heuristic: Callable[[up.model.State], float | None] | None = None,
        timeout: float | None = None,
        output_stream: IO[str] | None = None,
        warm_start_plan: up.plans.Plan | None = None,
        **_: Any,
    ) -> PlanGenerationResult:
        if heuristic is not None:
            warnings.warn("cxlab does not use the given heuristic", stacklevel=3)
        *_rest, last = self._results(problem, timeout, output_stream, warm_start_plan, anytime=False)
        return last

    def _solve(
        self,
        problem: up.model.AbstractProblem,
        heuristic: Callable[[up.model.State], float | None] | None = None,
        timeout: float | None = None,
        output_stream: IO[str] | None = None,
    ) -> PlanGenerationResult:
        return self._solve_with_params(problem, heuristic, timeout, output_stream)

    def _get_solutions_with_params(
        self,
        problem: up.model.AbstractProblem,
        timeout: float | None = None,
        output_stream: IO[str] | None = None,
        warm_start_plan: up.plans.Plan | None = None,
        **_: Any,
    ) -> Iterator[PlanGenerationResult]:
        return self._results(problem, timeout, output_stream, warm_start_plan, anytime=True)

    def _get_solutions(
        self, problem: up.model.AbstractProblem, timeout: float | None = None, output_stream: IO[str] | None = None
    ) -> Iterator[PlanGenerationResult]:
        return self._get_solutions_with_params(problem, timeout, output_stream)

    def _results(
        self,
        problem: up.model.AbstractProblem,
        timeout: float | None,
        output_stream: IO[str] | tuple[IO[str], IO[str]] | None,
        warm_start_plan: up.plans.Plan | None,
        anytime: bool,
    ) -> Iterator[PlanGenerationResult]:
        """The results of a search: one, or with `anytime` each better plan and then the answer."""
        assert isinstance(problem, Problem)
        if warm_start_plan is not None:
            warnings.warn("cxlab does not use the given plan to start from", stacklevel=4)
        began = time.monotonic()
        log: list[str] = []

        def message(line: str) -> None:
            log.append(line)
            if output_stream is not None:
                stream = output_stream[1] if isinstance(output_stream, tuple) else output_stream
                stream.write(line + "\n")

        def result(status: Status, plan: up.plans.Plan | None = None, reason: str = "") -> PlanGenerationResult:
            messages = [LogMessage(LogLevel.INFO, line) for line in (*log, *filter(None, [reason]))]
            metrics = {"engine_internal_time": str(time.monotonic() - began)}
            return PlanGenerationResult(status, plan, self.name, metrics, messages)

        try:
            task = _Task(problem)
            if task.impossible:
                yield result(Status.UNSOLVABLE_PROVEN, reason=task.impossible)
                return
            for apart in (False, True):  # again, with locks, if actions overlapped themselves and must not
                rest = None if timeout is None else timeout - (time.monotonic() - began)
                if rest is not None and rest <= 0:
                    yield result(Status.TIMEOUT, reason="the time ended before the search began")
                    return
                overlap = False
                for answer in self._answers(task, apart, rest, anytime, message):
                    plan = task.plan_of(answer) if answer else None
                    if plan is not None and task.overlaps_itself(plan):
                        overlap = True
                        break
                    if answer.status == "found" and not anytime:
                        continue
                    if answer.status != "found" or plan is not None:
                        yield result(task.status_of(answer, plan), plan, "" if plan is not None else _why_none(answer))
                if not overlap:
                    return
        except _Unsupported as reason:
            yield result(Status.UNSUPPORTED_PROBLEM, reason=str(reason))
        except planning.PddlError as error:
            status = Status.UNSUPPORTED_PROBLEM if error.code == 34 else Status.INTERNAL_ERROR
            yield result(status, reason=str(error))
        except CxlabError as error:
            yield result(Status.INTERNAL_ERROR, reason=str(error))

    def _answers(
        self, task: _Task, apart: bool, timeout: float | None, anytime: bool, message: Callable[[str], None]
    ) -> Iterator[planning.Plan]:
        domain, problem = task.pddl(apart)
        budget = self._budget
        if budget is None and timeout is not None:
            budget = 2**62
        limits: dict[str, Any] = {"timeout": timeout, "budget": budget, "memory": self._memory, "on_message": message}
        if anytime:
            yield from planning.plans(domain, problem, patience=self._patience, **limits)
        else:
            yield planning.plan(domain, problem, **limits)

    def _validate(self, problem: up.model.AbstractProblem, plan: up.plans.Plan) -> ValidationResult:
        assert isinstance(problem, Problem)

        def result(status: Validity, text: str, **more: Any) -> ValidationResult:
            return ValidationResult(status, self.name, [LogMessage(LogLevel.INFO, text)] if text else [], **more)

        def framework(why: str) -> ValidationResult:
            found = task.judged(plan)
            found.engine_name = self.name
            found.log_messages = [
                LogMessage(LogLevel.INFO, f"judged by the validator of the Framework: {why}"),
                *(found.log_messages or []),
            ]
            return found

        try:
            task = _Task(problem)
            text, steps = task.text_of(plan)
            if task.impossible:
                return result(Validity.INVALID, task.impossible, reason=FailedValidationReason.UNSATISFIED_GOALS)
            if task.rounded:
                return framework("PDDL has the numbers of this problem with fewer digits")
            verdict = planning.validate(*task.pddl(apart=False), planning._Text(text), epsilon=0, tolerance=0)
        except (_Unsupported, CxlabError, UPException) as reason:
            return result(Validity.UNKNOWN, str(reason))
        violation = verdict.violation
        if violation is None:
            if isinstance(plan, TimeTriggeredPlan) and task.overlaps_itself(plan):
                return result(
                    Validity.INVALID, "an action overlaps itself", reason=FailedValidationReason.MUTEX_CONFLICT
                )
            if isinstance(plan, TimeTriggeredPlan) and task.meets(plan):
                return result(
                    Validity.INVALID,
                    "two actions or events assign one fluent at the same time",
                    reason=FailedValidationReason.MUTEX_CONFLICT,
                )
            return result(Validity.VALID, "", metric_evaluations=task.metric_of(verdict))
        text = "; ".join(filter(None, [verdict.message, verdict.advice]))
        if violation["kind"] == "interference" or task.stricter:
            return framework(text)
        if "step" in violation:
            step = steps[violation["step"]]
            return result(
                Validity.INVALID, text, reason=FailedValidationReason.INAPPLICABLE_ACTION, inapplicable_action=step
            )
        return result(Validity.INVALID, text, reason=FailedValidationReason.UNSATISFIED_GOALS)


class _Task:
    """A problem of the Framework as one of PDDL, and plans of PDDL as plans of the Framework.

    What PDDL has no word for is rewritten: object fluents and state invariants by compilers of the Framework; bounds of
    numbers become conditions; an assignment of a condition's value becomes two conditional effects.
    """

    def __init__(self, problem: Problem) -> None:
        self.original = problem
        self.timed = problem.kind.has_continuous_time()
        self.impossible = ""  # why no plan exists, where that is plain to see
        self.rounded = False  # PDDL has some number of the problem with fewer digits
        self.stricter = False  # PDDL may forbid a plan that the Framework allows
        self._back: list[Callable[[ActionInstance], ActionInstance | None]] = []
        self._compile()
        self._rewrite()

    def pddl(self, apart: bool) -> tuple[str, str]:
        """Domain and problem. `apart`: no action overlaps itself."""
        problem = self._apart() if apart else self.problem
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            self._writer = PDDLWriter(problem)
            texts = self._writer.get_domain(), self._writer.get_problem()
        self.rounded = any("exactly" in str(warning.message) for warning in caught)
        self._inexact = self.rounded or any(operator in text for text in texts for operator in ("(/ ", "(* "))
        return texts

    def plan_of(self, answer: planning.Plan) -> up.plans.Plan | None:
        """The plan in the terms of the original problem; None if the Framework's validator would not accept it."""
        steps = sorted(answer.steps, key=lambda step: step.start)
        if not self.timed:
            plan: up.plans.Plan = SequentialPlan([self._instance(step) for step in steps], self.original.environment)
        else:
            timed = self._timed(answer)
            if timed is None:
                return None
            plan = TimeTriggeredPlan(timed, self.original.environment)
            if (
                self.original.epsilon is not None
                and (plan.extract_epsilon(self.original) or math.inf) < self.original.epsilon
            ):
                return None
        for back in reversed(self._back):
            plan = plan.replace_action_instances(back)
        return plan if not self._in_doubt or self.judged(plan) else None

    def status_of(self, answer: planning.Plan, plan: up.plans.Plan | None) -> Status:
        if plan is not None:
            if answer.status == "found":
                return Status.INTERMEDIATE
            best = (
                self.original.quality_metrics
                and answer.metric_bound is not None
                and answer.metric == answer.metric_bound
            )
            return (
                Status.SOLVED_OPTIMALLY if best and not self.timed and not self._in_doubt else Status.SOLVED_SATISFICING
            )
        if answer.status == "unsolvable" and not self.timed and not self._in_doubt:
            return Status.UNSOLVABLE_PROVEN
        return {"budget": Status.TIMEOUT, "memory": Status.MEMOUT}.get(answer.status, Status.UNSOLVABLE_INCOMPLETELY)

    def overlaps_itself(self, plan: up.plans.Plan) -> bool:
        """Whether an action runs twice at one time with the same arguments, in a problem that forbids it."""
        if self.original.self_overlapping or not isinstance(plan, TimeTriggeredPlan):
            return False
        busy: dict[tuple[str, tuple[FNode, ...]], Fraction] = {}
        for start, instance, duration in sorted(plan.timed_actions, key=lambda timed: timed[0]):
            if duration is None:
                continue
            key = instance.action.name, instance.actual_parameters
            if start < busy.get(key, start):
                return True
            busy[key] = start + duration
        return False

    def judged(self, plan: up.plans.Plan) -> ValidationResult:
        """What the validator of the Framework says of a plan of the original problem."""
        validator = TimeTriggeredPlanValidator() if isinstance(plan, TimeTriggeredPlan) else SequentialPlanValidator()
        return validator.validate(self.original, plan)

    def meets(self, plan: TimeTriggeredPlan) -> bool:
        """Whether two actions or events assign one fluent at the same time."""
        timed: Timed = [
            (start, ActionInstance(self._compiled.action(instance.action.name), instance.actual_parameters), duration)
            for start, instance, duration in plan.timed_actions
        ]
        return _met(_times(timed), self._assigned(timed), self._events()) is not None

    def text_of(self, plan: up.plans.Plan) -> tuple[str, list[ActionInstance]]:
        """A plan of the original problem as a plan file, and its actions in the order of the lines."""
        self.pddl(apart=False)  # the names
        if isinstance(plan, TimeTriggeredPlan):
            timed: Timed = list(plan.timed_actions)
        elif isinstance(plan, SequentialPlan):
            timed = [(Fraction(i), instance, None) for i, instance in enumerate(plan.actions)]
        else:
            raise _Unsupported(f"found a plan of kind {plan.kind.name}")
        lines = []
        for start, instance, duration in timed:
            words = [instance.action.name, *(str(argument.object().name) for argument in instance.actual_parameters)]
            action = self.problem.action(words[0])
            names = [
                self._writer.get_pddl_name(action),
                *(self._writer.get_pddl_name(self.problem.object(word)) for word in words[1:]),
            ]
            lines.append(f"{_decimal(start)}: ({' '.join(names)}) [{_decimal(duration or Fraction(0))}]\n")
        return "".join(lines), [instance for _, instance, _ in timed]

    def metric_of(self, verdict: planning.Verdict) -> dict[Any, Any] | None:
        metrics = self.original.quality_metrics
        if not metrics or metrics[0].is_minimize_makespan() or verdict.metric is None:
            return None
        value = Fraction(str(verdict.metric))
        return {metrics[0]: int(value) if value.denominator == 1 else value}

    @property
    def _in_doubt(self) -> bool:
        """Whether PDDL and the Framework may judge a plan differently."""
        return self._inexact or self.stricter

    def _compile(self) -> None:
        problem = self.original
        for feature, compiler, kind in (
            ("STATE_INVARIANTS", StateInvariantsRemover, CompilationKind.STATE_INVARIANTS_REMOVING),
            ("OBJECT_FLUENTS", UsertypeFluentsRemover, CompilationKind.USERTYPE_FLUENTS_REMOVING),
        ):
            if feature not in problem.kind.features:
                continue
            done = compiler().compile(problem, kind)
            assert isinstance(done.problem, Problem) and done.map_back_action_instance is not None
            problem = done.problem
            self._back.append(done.map_back_action_instance)
        self._compiled = problem
        self.problem = problem.clone()

    def _rewrite(self) -> None:
        problem = self.problem
        for action in problem.actions:
            if isinstance(action, InstantaneousAction):
                effects = list(action.effects)
                action.clear_effects()
                for effect in self._rewritten(effects, action.add_precondition):
                    action._add_effect_instance(effect)
            elif isinstance(action, DurativeAction):
                self._close_duration(action)
                timed = {timing: list(effects) for timing, effects in action.effects.items()}
                action.clear_effects()
                for timing, effects in timed.items():
                    for effect in self._rewritten(
                        effects, lambda condition, timing=timing, action=action: action.add_condition(timing, condition)
                    ):
                        action._add_effect_instance(timing, effect)
        self._rewrite_timed_effects()
        goals = [goal.simplify() for goal in problem.goals]
        problem.clear_goals()
        for goal in goals:
            if goal.is_false():
                self.impossible = "a goal is false in every state"
            elif not goal.is_true():
                problem.add_goal(goal)
        for fluent, value in problem.initial_values.items():
            if _bounds(fluent) != (None, None) and not _within(fluent, value):
                self.impossible = f"the first value of {fluent} is out of its bounds"
        self._rewrite_metric()

    def _close_duration(self, action: DurativeAction) -> None:
        """PDDL has no open bounds: they move by a microsecond, the planner's grain of time."""
        bounds, manager = action.duration, action.environment.expression_manager
        if bounds.is_left_open() or bounds.is_right_open():
            grain = manager.Real(_MICROSECOND)
            lower = manager.Plus(bounds.lower, grain).simplify() if bounds.is_left_open() else bounds.lower
            upper = manager.Minus(bounds.upper, grain).simplify() if bounds.is_right_open() else bounds.upper
            action.set_closed_duration_interval(lower, upper)

    def _rewrite_metric(self) -> None:
        """Costs of actions as a number of the last state."""
        problem = self.problem
        if len(problem.quality_metrics) > 1:
            raise _Unsupported("found more than one quality metric")
        for metric in problem.quality_metrics:
            if isinstance(metric, up.model.metrics.MinimizeActionCosts):
                costs = {action: metric.get_action_cost(action) for action in problem.actions}
            elif isinstance(metric, up.model.metrics.MinimizeSequentialPlanLength):
                costs = {action: problem.environment.expression_manager.Int(1) for action in problem.actions}
            else:
                return
            problem.clear_quality_metrics()
            spent = self._fluent("spent", problem.environment.type_manager.RealType(), 0)
            for action, cost in costs.items():
                if cost is not None and isinstance(action, DurativeAction):
                    action.add_increase_effect(EndTiming(), spent(), cost)
                elif cost is not None:
                    action.add_increase_effect(spent(), cost)
            problem.add_quality_metric(
                up.model.metrics.MinimizeExpressionOnFinalState(spent(), environment=problem.environment)
            )

    def _fluent(
        self, name: str, kind: up.model.Type, value: Any, parameters: Any = None, problem: Problem | None = None
    ) -> up.model.Fluent:
        """A fluent that the original problem does not have."""
        problem = problem or self.problem
        while problem.has_name(name):
            name += "_"
        fluent = up.model.Fluent(name, kind, parameters, problem.environment)
        problem.add_fluent(fluent, default_initial_value=value)
        return fluent

    def _rewritten(self, effects: list[Effect], require: Callable[[FNode], Any]) -> Iterator[Effect]:
        """Yield effects of one moment without assignments of conditions; `require` gets conditions that keep bounds."""
        numeric: dict[Any, int] = {}
        for effect in effects:
            manager = effect.environment.expression_manager
            if effect.fluent.type.is_bool_type() and not effect.value.is_bool_constant():
                for condition, value in ((effect.value, True), (manager.Not(effect.value), False)):
                    both = manager.And(effect.condition, condition).simplify()
                    if not both.is_false():
                        yield Effect(effect.fluent, manager.Bool(value), both, effect.kind, effect.forall)
                continue
            yield effect
            if effect.fluent.type.is_bool_type():
                continue
            fluent = effect.fluent.fluent()
            numeric[fluent] = numeric.get(fluent, 0) + 1
            if numeric[fluent] > 1 or effect.is_forall():
                self.stricter = True  # they may meet at one number
            lower, upper = _bounds(effect.fluent)
            value = {
                EffectKind.ASSIGN: effect.value,
                EffectKind.INCREASE: manager.Plus(effect.fluent, effect.value),
                EffectKind.DECREASE: manager.Minus(effect.fluent, effect.value),
            }[effect.kind]
            sign = _sign(effect)
            conditions = [
                condition
                for bound, needed, condition in (
                    (lower, sign <= 0, manager.LE(lower, value) if lower is not None else None),
                    (upper, sign >= 0, manager.LE(value, upper) if upper is not None else None),
                )
                if bound is not None and needed
            ]
            if not conditions:
                continue
            kept = manager.And(conditions)
            if effect.is_conditional():
                kept = manager.Or(manager.Not(effect.condition), kept)
            if effect.is_forall():
                kept = manager.Forall(kept, *effect.forall)
            kept = kept.simplify()
            if not kept.is_true():
                require(kept)

    def _rewrite_timed_effects(self) -> None:
        problem = self.problem
        timed = {timing: list(effects) for timing, effects in problem.timed_effects.items()}
        problem.clear_timed_effects()
        for timing, effects in timed.items():
            for effect in (one for each in effects for one in each.expand_effect(problem)):
                value = effect.value.simplify()
                if not effect.condition.simplify().is_true() or not effect.is_assignment() or not value.is_constant():
                    raise _Unsupported(f"found a timed effect that is no assignment of a constant: {effect}")
                if not effect.fluent.type.is_bool_type() and not _within(effect.fluent, value):
                    self.impossible = f"at {timing} the value of {effect.fluent} leaves its bounds"
                problem.add_timed_effect(timing, effect.fluent, value)

    def _apart(self) -> Problem:
        """The problem with a lock for each durative action and its arguments."""
        problem = self.problem.clone()
        for action in list(problem.actions):
            if not isinstance(action, DurativeAction):
                continue
            boolean = problem.environment.type_manager.BoolType()
            this = self._fluent(f"running_{action.name}", boolean, False, list(action.parameters), problem)(
                *action.parameters
            )
            action.add_condition(StartTiming(), problem.environment.expression_manager.Not(this))
            action.add_effect(StartTiming(), this, True)
            action.add_effect(EndTiming(), this, False)
        return problem

    def _instance(self, step: planning.PlanStep) -> ActionInstance:
        action = self._writer.get_item_named(step.action)
        manager = self.problem.environment.expression_manager
        arguments = tuple(manager.ObjectExp(self._writer.get_item_named(name)) for name in step.arguments)
        return ActionInstance(self._compiled.action(action.name), arguments)

    def _timed(self, answer: planning.Plan) -> Timed | None:
        """The steps with exact durations, and apart where two of them give one fact its value at one time."""
        evaluator, state = StateEvaluator(self.problem), UPState(self.problem.explicit_initial_values, self.problem)
        timed: Timed = []
        for step in answer.steps:
            instance = self._instance(step)
            duration = None
            if isinstance(instance.action, DurativeAction):
                duration = _exact_duration(
                    instance, _micros(step.duration), lambda bound: evaluator.evaluate(bound, state).constant_value()
                )
            timed.append((_micros(step.start), instance, duration))
        return _separated(timed, answer.orderings, self._assigned(timed), self._events())

    def _assigned(self, timed: Timed) -> list[set[FNode]]:
        """What each start (2 i) and end (2 i + 1) of the steps assigns."""
        assigned: list[set[FNode]] = []
        for _, instance, _ in timed:
            values = dict(zip(instance.action.parameters, instance.actual_parameters, strict=True))
            at: tuple[set[FNode], set[FNode]] = (set(), set())
            timed_action = isinstance(instance.action, DurativeAction)
            moments = instance.action.effects.items() if timed_action else [(StartTiming(), instance.action.effects)]
            for timing, effects in moments:
                for effect in (one for each in effects for one in each.expand_effect(self._compiled)):
                    if effect.is_assignment():
                        at[0 if timing.is_from_start() else 1].add(effect.fluent.substitute(values))
            assigned += at
        return assigned

    def _events(self) -> dict[Fraction, set[FNode]]:
        events: dict[Fraction, set[FNode]] = {}
        for timing, effects in self.problem.timed_effects.items():
            events.setdefault(Fraction(timing.delay), set()).update(effect.fluent for effect in effects)
        return events


def _separated(
    timed: Timed, orderings: Any, assigned: list[set[FNode]], events: dict[Fraction, set[FNode]]
) -> Timed | None:
    """The plan, with happenings that assign one fluent at the same time moved apart; None if that cannot be.

    The Framework forbids what PDDL allows: two actions give a fact the same value at one instant.
    """
    edges: list[tuple[int, int, Fraction]] = []  # from, to, distance; -1 is time 0
    for ordering in orderings:
        tail, head = _point(ordering["from"]), _point(ordering["to"])
        if tail >= 0 and head >= 0 and tail // 2 == head // 2:
            continue  # a duration, with fewer digits than it has here
        edges.append((tail, head, _micros(ordering["least_s"])))
        if "most_s" in ordering:
            edges.append((head, tail, -_micros(ordering["most_s"])))
    for i, (_, _, duration) in enumerate(timed):
        edges += [(2 * i, 2 * i + 1, duration or Fraction(0)), (2 * i + 1, 2 * i, -(duration or Fraction(0)))]
    times = _times(timed)
    for _ in range(_MOST_SEPARATIONS):
        pair = _met(times, assigned, events)
        if pair is None:
            return [(times[2 * i], instance, duration) for i, (_, instance, duration) in enumerate(timed)]
        first, second = pair
        ways = [[*edges, (first, second, _EPSILON)], [*edges, (second, first, _EPSILON)]]
        if second < 0:  # an event: its time is fixed
            at = times[first]
            ways = [[*edges, (-1, first, at + _EPSILON)], [*edges, (first, -1, _EPSILON - at)]]
        for way in ways:
            found = _earliest(len(times), way)
            if found is not None:
                edges, times = way, found
                break
        else:
            return None
    return None


def _point(end: Any) -> int:
    """An end of an ordering: 2 i for the start of step i, 2 i + 1 for its end, -1 for time 0."""
    return -1 if end == "origin" else 2 * int(end["step"]) + (end["at"] == "end")


def _times(timed: Timed) -> list[Fraction]:
    return [time for start, _, duration in timed for time in (start, start + (duration or 0))]


def _met(
    times: list[Fraction], assigned: list[set[FNode]], events: dict[Fraction, set[FNode]]
) -> tuple[int, int] | None:
    """Two happenings that assign one fluent at one time; the second is -1 if it is an event."""
    seen: dict[tuple[Fraction, FNode], int] = {(at, fluent): -1 for at, fluents in events.items() for fluent in fluents}
    for point, fluents in enumerate(assigned):
        for fluent in fluents:
            other = seen.setdefault((times[point], fluent), point)
            if other != point and (other < 0 or other // 2 != point // 2):
                return point, other
    return None


def _earliest(points: int, edges: list[tuple[int, int, Fraction]]) -> list[Fraction] | None:
    """The earliest times that keep all distances; None if there are none."""
    times = [Fraction(0)] * (points + 1)  # the last is time 0, which index -1 names
    for _ in range(points + 2):
        moved = False
        for tail, head, distance in edges:
            if times[head] < times[tail] + distance:
                if head == -1:
                    return None
                times[head] = times[tail] + distance
                moved = True
        if not moved:
            return times[:-1]
    return None


def _exact_duration(instance: ActionInstance, rounded: Fraction, value: Callable[[FNode], Any]) -> Fraction:
    """The duration that a rounded one stands for: within its bounds, which the Framework compares exactly."""
    arguments = dict(zip(instance.action.parameters, instance.actual_parameters, strict=True))
    bounds = instance.action.duration
    lower, upper = (Fraction(value(bound.substitute(arguments))) for bound in (bounds.lower, bounds.upper))
    inside = min(_MICROSECOND, (upper - lower) / 2)
    least, most = lower + inside * bounds.is_left_open(), upper - inside * bounds.is_right_open()
    return min(max(rounded, least), most)


def _bounds(fluent: FNode) -> tuple[Any, Any]:
    kind = fluent.fluent().type
    return (kind.lower_bound, kind.upper_bound) if kind.is_int_type() or kind.is_real_type() else (None, None)


def _within(fluent: FNode, value: FNode) -> bool:
    lower, upper = _bounds(fluent)
    number = value.constant_value()
    return (lower is None or lower <= number) and (upper is None or number <= upper)


def _sign(effect: Effect) -> int:
    """Whether a number only grows (1) or shrinks (-1); 0: it may do either."""
    if effect.is_assignment() or not effect.value.is_constant() or effect.value.constant_value() == 0:
        return 0
    return (1 if effect.value.constant_value() > 0 else -1) * (1 if effect.is_increase() else -1)


def _micros(seconds: float) -> Fraction:
    return Fraction(round(seconds * 10**6), 10**6)


def _decimal(value: Fraction) -> str:
    """Nanoseconds, which is what the validator counts in."""
    whole = round(value * 10**9)
    return f"{whole // 10**9}.{whole % 10**9:09d}"


def _why_none(answer: planning.Plan) -> str:
    if answer:
        return "a plan was found that the Framework does not accept: it compares times and numbers exactly"
    return answer.out_of_reach or answer.reason


def register(environment: up.environment.Environment | None = None) -> None:
    """Add the engine to an environment of the Framework; to the global one, where none is given."""
    factory = get_environment(environment).factory
    if "cxlab" not in factory.engines:
        factory.add_engine("cxlab", __name__, "CxlabEngine")


if __name__ == "__main__":
    print("[engine cxlab]\nmodule_name: cxlab.up\nclass_name: CxlabEngine")
else:
    register()
