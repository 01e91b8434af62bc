"""The PDDL manager beside the Unified Planning Framework: check a step's condition at the start, take its effects, apply
them, on blocks that go round in towers.

    python3 benchmarks/planner/manager.py BUILD_FOLDER [--blocks 20]

Needs unified-planning (pip install unified-planning). Both carry out the same steps and must end in the same state.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]
DOMAIN = SOURCE / "docs/examples/blocksworld/pddl/domain.pddl"


def problem_and_steps(count):
    """All blocks on the table; each is lifted and put down again, then stacked on the next and taken off."""
    names = [f"b{i}" for i in range(count)]
    facts = " ".join(f"(ontable {b}) (clear {b})" for b in names)
    problem = f"(define (problem p) (:domain blocksworld) (:objects {' '.join(names)} - block) (:init {facts} (handempty) (= (moves) 0)) (:goal (and)))"
    steps = []
    for a, b in zip(names, names[1:] + names[:1]):
        steps += [f"pick-up {a}", f"stack {a} {b}", f"unstack {a} {b}", f"put-down {a}"]
    return problem, steps


def with_upf(domain, problem, steps):
    """Microseconds a step, and the facts that are true afterwards."""
    from unified_planning.environment import get_environment
    from unified_planning.engines.sequential_simulator import UPState
    from unified_planning.io import PDDLReader
    from unified_planning.model import StartTiming, TimeInterval
    from unified_planning.model.walkers import StateEvaluator

    get_environment().credits_stream = None
    model = PDDLReader().parse_problem(str(domain), str(problem))
    em = model.environment.expression_manager
    begin = time.perf_counter()
    for step in steps:
        name, *arguments = step.split()
        action = model.action(name)
        binding = {p: em.ObjectExp(model.object(a)) for p, a in zip(action.parameters, arguments)}
        evaluator = StateEvaluator(model)
        state = UPState(model.initial_values)
        for interval, conditions in action.conditions.items():
            if interval.lower == StartTiming() and interval.upper == StartTiming():
                for condition in conditions:
                    assert evaluator.evaluate(condition, state, binding).is_true(), step
        for _, effects in sorted(action.effects.items(), key=lambda item: item[0].is_from_end()):
            for effect in sorted(effects, key=lambda e: e.value.is_true()):
                if not effect.fluent.type.is_bool_type():
                    continue
                model.set_initial_value(effect.fluent.substitute(binding), effect.value)
    seconds = time.perf_counter() - begin
    return 1e6 * seconds / len(steps), sum(value.is_true() for value in model.initial_values.values())


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--blocks", type=int, default=20)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        problem, steps = pathlib.Path(folder) / "problem.pddl", pathlib.Path(folder) / "steps.txt"
        text, lines = problem_and_steps(options.blocks)
        problem.write_text(text)
        steps.write_text("\n".join(lines) + "\n")
        program = options.build / "benchmarks/bench_pddl_manager"
        ours = json.loads(subprocess.run([program, DOMAIN, problem, steps, "200"], check=True, capture_output=True, text=True).stdout)
        theirs_us, theirs_facts = with_upf(DOMAIN, problem, lines)
    assert ours["facts"] == theirs_facts, (ours["facts"], theirs_facts)
    print(f"cxlab {ours['us_per_step']:.2f} us a step, Unified Planning Framework {theirs_us:.0f} us: {theirs_us / ours['us_per_step']:.0f} x, {theirs_facts} facts after {len(lines)} steps")


if __name__ == "__main__":
    main()
