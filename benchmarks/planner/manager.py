#!/usr/bin/env python3
"""The PDDL manager beside the Unified Planning Framework: check a step's condition at the start, take its effects, apply
them, on blocks that go round in towers. Both carry out the same steps and must end in the same state. Then what a question
costs that a rule asks: check_action_condition from CLIPS over the bus to the manager and back into a rule.

    python3 benchmarks/planner/manager.py BUILD_FOLDER [--blocks 20]

Needs unified-planning for the first part (pip install unified-planning).
"""

import argparse
import json
import pathlib
import resource
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


def with_upf(domain, problem, steps, keep_problem):
    """CPU microseconds a step, and the facts that are true afterwards. With `keep_problem` the state is that of a problem
    which is asked and changed, as a manager keeps it; else it is a chain of states, the cheapest way."""
    from unified_planning.environment import get_environment
    from unified_planning.io import PDDLReader
    from unified_planning.model import StartTiming
    from unified_planning.model.state import UPState
    from unified_planning.model.walkers import StateEvaluator

    get_environment().credits_stream = None
    model = PDDLReader().parse_problem(str(domain), str(problem))
    em = model.environment.expression_manager
    evaluator, state = StateEvaluator(model), UPState(model.explicit_initial_values, model)
    begin = time.process_time()
    for step in steps:
        name, *arguments = step.split()
        action = model.action(name)
        binding = {em.ParameterExp(p): em.ObjectExp(model.object(a)) for p, a in zip(action.parameters, arguments)}
        if keep_problem:
            state = UPState(model.initial_values, model)
        for interval, conditions in action.conditions.items():
            if interval.lower == StartTiming() and interval.upper == StartTiming():
                for condition in conditions:
                    assert evaluator.evaluate(condition.substitute(binding), state).is_true(), step
        changes = {}
        for _, effects in sorted(action.effects.items(), key=lambda item: item[0].is_from_end()):
            for effect in sorted(effects, key=lambda e: e.value.is_true()):
                if effect.fluent.type.is_bool_type():
                    changes[effect.fluent.substitute(binding)] = effect.value
        if keep_problem:
            for fluent, value in changes.items():
                model.set_initial_value(fluent, value)
        else:
            state = state.make_child(changes)
    seconds = time.process_time() - begin
    if keep_problem:
        state = UPState(model.initial_values, model)
    return 1e6 * seconds / len(steps), sum(state.get_value(fluent).is_true() for fluent in model.initial_values)


CONFIG = """clips_manager:
  ros__parameters:
    environments: ["main"]
    main: {plugins: ["executive", "ros_msgs", "files"]}
    executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 50}
    ros_msgs: {plugin: "cx::RosMsgsPlugin"}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["asker"], load: ["ask.clp"]}
"""
AGENT = """(defglobal ?*answers* = 0)
(defrule connect =>
  (ros-msgs-create-client "/pddl_manager/add_pddl_instance" "cx_pddl_interfaces/srv/AddPddlInstance")
  (ros-msgs-create-client "/pddl_manager/check_action_condition" "cx_pddl_interfaces/srv/CheckActionCondition")
  (bind ?request (ros-msgs-create-request "cx_pddl_interfaces/srv/AddPddlInstance"))
  (ros-msgs-set-field ?request "name" "bw")
  (ros-msgs-set-field ?request "directory" "FOLDER")
  (ros-msgs-set-field ?request "domain_file" "domain.pddl")
  (ros-msgs-set-field ?request "problem_file" "problem.pddl")
  (ros-msgs-async-send-request ?request "/pddl_manager/add_pddl_instance")
  (ros-msgs-destroy-message ?request))
(defrule ask "EACH questions a tick."
  (time ?t&:(> ?t 1.0))
  =>
  (loop-for-count EACH
    (bind ?action (ros-msgs-create-message "cx_pddl_interfaces/msg/Action"))
    (ros-msgs-set-field ?action "pddl_instance" "bw")
    (ros-msgs-set-field ?action "name" "pick-up")
    (ros-msgs-set-field ?action "args" (create$ "b1"))
    (bind ?request (ros-msgs-create-request "cx_pddl_interfaces/srv/CheckActionCondition"))
    (ros-msgs-set-field ?request "action" ?action)
    (ros-msgs-async-send-request ?request "/pddl_manager/check_action_condition")
    (ros-msgs-destroy-message ?request)
    (ros-msgs-destroy-message ?action)))
(defrule answered
  ?response <- (ros-msgs-response (service "/pddl_manager/check_action_condition") (msg-ptr ?message))
  =>
  (if (ros-msgs-get-field ?message "sat") then (bind ?*answers* (+ ?*answers* 1)))
  (ros-msgs-destroy-message ?message)
  (retract ?response))
(defrule count (time ?t&:(> ?t 60.0)) (not (counted)) => (assert (counted)) (println "answers " ?*answers*))
"""


def through_the_bus(cxlab, folder, each):
    """CPU seconds of a minute of an agent that asks `each` questions a tick, and how many were answered with yes."""
    folder = pathlib.Path(folder)
    (folder / "ask.clp").write_text(AGENT.replace("FOLDER", str(folder)).replace("EACH", str(each)))
    (folder / "config.yaml").write_text(CONFIG)
    (folder / "domain.pddl").write_text(DOMAIN.read_text())
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([cxlab, "env", folder / "config.yaml", "--with", "pddl_manager", "--package", f"asker={folder}", "--until", "61", "--out", "none"],
                          check=True, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, int(done.stderr.split("answers ")[1].split()[0])


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
        (none, _), (some, answers) = (through_the_bus(options.build / "cxlab", folder, each) for each in (0, 20))
        theirs = {way: with_upf(DOMAIN, problem, lines, way == "a problem kept") for way in ("a chain of states", "a problem kept")}
    print(f"{len(lines)} steps, {ours['facts']} facts afterwards; CPU time a step")
    print(f"cxlab                                          {ours['us_per_step']:9.2f} us")
    print(f"the check alone, asked by a rule over the bus  {1e6 * (some - none) / answers:9.2f} us   ({answers} questions)")
    for way, (microseconds, facts) in theirs.items():
        assert facts == ours["facts"], (way, facts, ours["facts"])
        print(f"Unified Planning Framework, {way:17}  {microseconds:9.2f} us   {microseconds / ours['us_per_step']:7.0f} x")


if __name__ == "__main__":
    main()
