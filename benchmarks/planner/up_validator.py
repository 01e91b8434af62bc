#!/usr/bin/env python3
"""Judges a plan with the validator of the Unified Planning Framework: up_validator.py DOMAIN PROBLEM PLAN

Prints `valid`, `INVALID` or `cannot: WHY`. Needs unified-planning.
"""
import sys


def verdict(domain, problem, plan):
    from unified_planning.io import PDDLReader
    from unified_planning.shortcuts import PlanValidator, get_environment
    get_environment().credits_stream = None
    try:
        reader = PDDLReader()
        task = reader.parse_problem(domain, problem)
        steps = reader.parse_plan(task, plan)
        with PlanValidator(problem_kind=task.kind, plan_kind=steps.kind) as validator:
            return "valid" if validator.validate(task, steps) else "INVALID"
    except Exception as refusal:  # of many kinds: whatever it cannot read
        return f"cannot: {type(refusal).__name__}: {' '.join(str(refusal).split())[:80]}"


if __name__ == "__main__":
    print(verdict(*sys.argv[1:4]))
