#!/usr/bin/env python3
"""Plans every problem of a folder and prints what came of it.

    benchmarks/planner/plan_folder.py PROGRAM FOLDER [--timeout S] [--budget UNITS] [--first] [--best TSV]
                                      [--peer 'NAME=COMMAND'] [--up]

FOLDER has a domain.pddl (or domains/domain-N.pddl) and instances/*.pddl, or is a folder of such folders. Each problem is
planned by `cxlab plan --anytime` (`--first`: until the first plan) and every plan judged by `cxlab validate`.

--budget   plan with work units instead of wall time: the figures do not depend on who else uses the machine
--best     tab-separated lines `suite instance makespan ...`, where suite is the end of the folder's path; ratios to it
--peer     another planner: {domain}, {problem} and {plan} are replaced, the last is the file it writes. Repeatable
--up       also judge plans by the validator of the Unified Planning Framework, where it is installed and reads them
"""
import argparse
import json
import pathlib
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time


def problems(folder):
    """(suite, domain, problem) in the order of their names."""
    folder = pathlib.Path(folder)
    if not (folder / "instances").is_dir():
        for sub in sorted(path for path in folder.iterdir() if path.is_dir()):
            yield from problems(sub)
        return

    def key(path):
        return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", path.stem)]

    for problem in sorted((folder / "instances").glob("*.pddl"), key=key):
        domain = folder / "domain.pddl"
        if not domain.exists():
            domain = folder / "domains" / f"domain-{problem.stem.split('-')[-1]}.pddl"
        yield folder, domain, problem


def timed(command, limit):
    """(process or None, CPU s, wall s)"""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        done = None
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, time.monotonic() - began


def up_verdict(domain, problem, plan):
    """valid, INVALID, or why it cannot be asked."""
    try:
        from unified_planning.engines import PlanGenerationResultStatus  # noqa: F401: the package is there
        from unified_planning.io import PDDLReader
        from unified_planning.shortcuts import PlanValidator, get_environment
    except ImportError:
        return "not installed"
    get_environment().credits_stream = None
    try:
        reader = PDDLReader()
        task = reader.parse_problem(str(domain), str(problem))
        with PlanValidator(problem_kind=task.kind, plan_kind=None) as validator:
            return "valid" if validator.validate(task, reader.parse_plan(task, str(plan))) else "INVALID"
    except Exception as refusal:  # whatever it cannot read
        return f"cannot: {type(refusal).__name__}"


class Runner:
    def __init__(self, options):
        self.options = options
        self.scratch = pathlib.Path(tempfile.mkdtemp(prefix="cxlab-plans-"))
        self.best = {}
        if options.best:
            for line in pathlib.Path(options.best).read_text().splitlines():
                cells = line.split("\t")
                if line and not line.startswith("#") and len(cells) > 2 and cells[2] not in ("", "-"):
                    self.best[(cells[0].split("/")[-1], cells[1])] = float(cells[2])

    def judge(self, domain, problem, plan):
        done, _, _ = timed([self.options.program, "validate", str(domain), str(problem), str(plan)], 300)
        return done is not None and done.returncode == 0

    def ours(self, domain, problem):
        plan = self.scratch / f"{domain.parent.name}-{problem.stem}.plan"
        command = [self.options.program, "plan", str(domain), str(problem), "--json", "--out", str(plan)]
        if self.options.budget:
            command += ["--budget", str(self.options.budget)]
        else:
            command += ["--timeout", str(self.options.timeout), "--budget", str(10**15)]
        if not self.options.first:
            command.append("--anytime")
        done, cpu, wall = timed(command, 60 + 20 * (self.options.timeout or 60))
        row = {"cpu": cpu, "wall": wall, "makespan": None, "first": None, "status": "crashed"}
        if done is None or not done.stdout.strip():
            return row
        answer = json.loads(done.stdout)
        row.update(status=answer["status"], units=answer["units"])
        if answer["status"] == "plan":
            told = re.findall(r"makespan ([\d.]+) s(?:, metric \S+)?, after (\d+) units", done.stderr)
            row.update(makespan=answer["makespan_s"], bound=answer["lower_bound_s"], first=answer["first_plan_wall_s"], first_makespan=float(told[0][0]),
                       first_units=int(told[0][1]), valid=self.judge(domain, problem, plan), up=up_verdict(domain, problem, plan) if self.options.up else "")
        return row

    def peer(self, command, domain, problem):
        plan = self.scratch / "peer.plan"
        plan.unlink(missing_ok=True)
        parts = [part.format(domain=domain, problem=problem, plan=plan) for part in command.split()]
        done, cpu, _ = timed(parts, self.options.timeout)
        if not plan.exists():
            return "no plan"
        if not self.judge(domain, problem, plan):
            return "INVALID"
        text = subprocess.run([self.options.program, "validate", str(domain), str(problem), str(plan)], capture_output=True, text=True).stdout
        made = re.search(r"makespan ([\d.]+)", text)
        return f"{cpu:.2f} s / {made.group(1) if made else '?'}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("--timeout", type=float, default=1.0)
    parser.add_argument("--budget", type=int)
    parser.add_argument("--first", action="store_true")
    parser.add_argument("--best")
    parser.add_argument("--peer", action="append", default=[])
    parser.add_argument("--up", action="store_true")
    options = parser.parse_args()
    runner = Runner(options)
    peers = [peer.split("=", 1) for peer in options.peer]
    rows, quality, ratios = [], 0.0, []
    print("problem | first plan ms (units) | its makespan | makespan | bound | best known | ratio | CPU s | judged" + "".join(f" | {name}" for name, _ in peers))
    for folder, domain, problem in problems(options.folder):
        row = runner.ours(domain, problem)
        rows.append(row)
        best = runner.best.get((folder.name, problem.stem))
        name = f"{folder.name}/{problem.stem}"
        if row["makespan"] is None:
            print(f"{name} | {row['status']} |  |  |  | {best or ''} |  | {row['cpu']:.2f} |" + "".join(f" | {runner.peer(c, domain, problem)}" for _, c in peers), flush=True)
            continue
        share = best / row["makespan"] if best else 1.0
        quality += min(1.0, share)
        if best:
            ratios.append(row["makespan"] / best)
        judged = ("valid" if row["valid"] else "INVALID") + (f", UP {row['up']}" if row["up"] else "")
        print(f"{name} | {1000 * row['first']:.1f} ({row['first_units']}) | {row['first_makespan']:.3f} | {row['makespan']:.3f} | {row['bound']:.3f} | {best or ''} | "
              f"{row['makespan'] / best if best else float('nan'):.3f} | {row['cpu']:.2f} | {judged}" + "".join(f" | {runner.peer(c, domain, problem)}" for _, c in peers), flush=True)
    solved = [row for row in rows if row["makespan"] is not None]
    if solved:
        firsts = [1000 * row["first"] for row in solved]
        print(f"\nsolved {len(solved)} of {len(rows)}, invalid {sum(not row['valid'] for row in solved)}; first plan median {statistics.median(firsts):.1f} ms, worst {max(firsts):.1f} ms; "
              f"sum of makespans {sum(row['makespan'] for row in solved):.1f}" + (f", sum of quality {quality:.1f}, worst ratio {max(ratios):.3f}" if ratios else ""))
    sys.exit(0 if len(solved) == len(rows) else 1)


if __name__ == "__main__":
    main()
