#!/usr/bin/env python3
"""Plans with an engine of the Unified Planning Framework.

    up_engine.py ENGINE DOMAIN PROBLEM PLAN [--timeout S] [--anytime]

ENGINE is a name that the framework knows (aries, lpg, tamer, ...) or MODULE:CLASS. The plan is written to PLAN, one line a
step: `0.000: (action a b) [5.000]`; with --anytime each better one to PLAN.1, PLAN.2 ...

Exit codes: 0 a plan; 10 proved unsolvable; 12 ended without plan or proof; 22 memory; 23 time ended; 34 the framework or
the engine does not support the problem; 2 no such engine; 5 something is not installed; 4 the engine failed. The last line
on standard error says why.
"""
import argparse
import difflib
import fractions
import importlib
import os
import sys

# The package of an engine where it is not up-NAME, and what else it needs.
PACKAGES = {"lpg": "up-lpg 'setuptools<81'", "lpg-anytime": "up-lpg 'setuptools<81'", "fast-downward": "up-fast-downward",
            "fast-downward-opt": "up-fast-downward", "symk-opt": "up-symk", "enhsp-opt": "up-enhsp", "enhsp-any": "up-enhsp"}
ENGINES = ["aries", "enhsp", "fast-downward", "fmap", "lpg", "lpg-anytime", "nextflap", "pyperplan", "symk", "tamer"]


def end(code, why):
    sys.stdout.flush()
    print(why, file=sys.stderr, flush=True)
    os._exit(code)  # engines leave threads and servers behind


def packages(name):
    """What pip installs for an engine, or None for names that are not known: no package name is made up."""
    return PACKAGES.get(name, "up-" + name) if name in ENGINES or name in PACKAGES else None


def refuse_unknown(name):
    near = difflib.get_close_matches(name, [*ENGINES, *PACKAGES], 1)
    end(2, f"engine {name}: unknown to the Unified Planning Framework; " + (f"did you mean {near[0]}? " if near else "") + "it knows " + ", ".join(sorted({*ENGINES, *PACKAGES})))


def factory_with(name, up):
    """The framework's factory and the engine's name in it."""
    factory = up.environment.get_environment().factory
    if ":" in name:
        module, _, class_name = name.partition(":")
        try:
            factory.add_engine(name, module, class_name)
        except (ImportError, AttributeError) as missing:
            end(5, f"engine {name}: {missing}; is it installed for {sys.executable}?")
    elif name not in factory.engines:
        if not packages(name):
            refuse_unknown(name)
        end(5, f"engine {name}: not installed: {sys.executable} -m pip install {packages(name)}")
    return factory


def read(domain, problem, up, whole_numbers):
    """The task; with `whole_numbers` functions count in integers, which some engines ask for."""
    environment = up.environment.get_environment()
    types = environment.type_manager
    real = types.RealType
    if whole_numbers:
        types.RealType = lambda lower_bound=None, upper_bound=None: types.IntType()
    try:
        return up.io.PDDLReader(environment).parse_problem(domain, problem)
    finally:
        types.RealType = real


def steps(plan, task, up):
    """(start, action, duration or None) of any kind of plan; sequences get a hundredth of a second a step."""
    if hasattr(plan, "timed_actions"):
        return [(start, action, duration) for start, action, duration in plan.timed_actions]
    if not hasattr(plan, "actions"):
        plan = plan.convert_to(up.plans.PlanKind.SEQUENTIAL_PLAN, task)
    return [(fractions.Fraction(i, 100), action, None) for i, action in enumerate(plan.actions)]


def write(plan, task, up, file):
    with open(file + ".part", "w") as out:
        for start, action, duration in steps(plan, task, up):
            call = " ".join([action.action.name, *map(str, action.actual_parameters)])
            print(f"{float(start):.6f}: ({call})" + ("" if duration is None else f" [{float(duration):.6f}]"), file=out)
    os.replace(file + ".part", file)  # whole or not at all


def task_for(engine, options, up):
    """The task in the form of which the engine supports most, and what it does not support. It is tried all the same: the
    plan is judged by others, and engines often do more than they say."""
    forms, unread = [], ""
    for whole_numbers in (False, True):
        try:
            task = read(options.domain, options.problem, up, whole_numbers)
            forms.append((len(lacking := sorted(task.kind.features - engine.supported_kind().features)), whole_numbers, task, lacking))
        except Exception as error:  # of many kinds
            unread = unread or f"the Unified Planning Framework cannot read the problem: {type(error).__name__}: {error}"
    if not forms:
        end(34, " ".join(unread.split()))
    return min(forms, key=lambda form: form[:2])[2:]


def refuse(engine, lacking, detail=""):
    """An answer other than a plan counts only if the engine supports the problem."""
    if lacking:
        end(34, " ".join(f"engine {engine} does not support the problem: {', '.join(lacking).lower().replace('_', ' ')}{detail}".split()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("engine", "domain", "problem", "plan"):
        parser.add_argument(name)
    parser.add_argument("--timeout", type=float, help="seconds")
    parser.add_argument("--anytime", action="store_true")
    options = parser.parse_args()
    try:
        up = importlib.import_module("unified_planning")
        for part in ("environment", "engines", "io", "plans"):
            importlib.import_module("unified_planning." + part)
    except ImportError as missing:
        if not packages(options.engine) and ":" not in options.engine:
            refuse_unknown(options.engine)
        needed = " ".join(filter(None, ["unified-planning", packages(options.engine)]))  # the package of MODULE:CLASS is not known
        end(5, f"engine {options.engine}: {missing}: {sys.executable} -m pip install {needed}")
    factory = factory_with(options.engine, up)
    factory.environment.credits_stream = None
    task, lacking = task_for(factory.engine(options.engine), options, up)
    status = up.engines.PlanGenerationResultStatus
    codes = {status.UNSOLVABLE_PROVEN: (10, "unsolvable"), status.UNSOLVABLE_INCOMPLETELY: (12, "ended without a plan"), status.TIMEOUT: (23, "time ended"),
             status.MEMOUT: (22, "out of memory"), status.UNSUPPORTED_PROBLEM: (34, "does not support the problem"), status.INTERNAL_ERROR: (4, "failed")}
    try:
        if options.anytime:
            found, last = 0, None
            with factory.AnytimePlanner(name=options.engine) as planner:
                planner.skip_checks = True
                for last in planner.get_solutions(task, timeout=options.timeout):
                    if last.plan is not None:
                        found += 1
                        write(last.plan, task, up, f"{options.plan}.{found}")
            if found:
                end(0, f"{found} plans")
        else:
            with factory.OneshotPlanner(name=options.engine) as planner:
                planner.skip_checks = True
                last = planner.solve(task, timeout=options.timeout)
            if last.plan is not None:
                write(last.plan, task, up, options.plan)
                end(0, "a plan")
    except Exception as error:  # of many kinds
        refuse(options.engine, lacking, f" ({type(error).__name__}: {error})")
        end(4, " ".join(f"engine {options.engine} failed: {type(error).__name__}: {error}".split()))
    if not (last and last.status == status.TIMEOUT):
        refuse(options.engine, lacking)
    code, word = codes.get(last.status, (12, "ended without a plan")) if last else (12, "ended without a plan")
    said = " ".join(message.message for message in last.log_messages or [])[-200:].strip() if last else ""
    end(code, " ".join(f"engine {options.engine}: {word}{': ' + said if said and code == 4 else ''}".split()))


if __name__ == "__main__":
    main()
