#!/usr/bin/env python3
"""Plans every problem of a folder, beside other planners if wanted, and prints what came of it.

    benchmarks/planner/plan_folder.py PROGRAM FOLDER [--timeout S] [--budget UNITS] [--first] [--best TSV] [--only REGEX]
                                      [--field PYTHON [--with lpg,aries,...]] [--core N]

FOLDER has a domain.pddl (or domains/domain-N.pddl) and instances/*.pddl, or is a folder of such folders. Each problem is
planned by `cxlab plan --anytime` (`--first`: until the first plan) and every plan judged by `cxlab validate`.

  --timeout  seconds: wall time for ours, CPU time for the others (and four times as much wall time)
  --budget   plan with work units instead: the figures do not depend on who else uses the machine
  --best     tab-separated lines `suite instance makespan ...`, where suite is the end of the folder's path
  --field    a Python interpreter with the packages of requirements.txt. Its validators judge our plans, too: VAL, that of
             Kairos and that of the Unified Planning Framework
  --with     planners of the field: lpg, aries, tamer, kairos. Their plans are judged by ours and by VAL. A planner that failed
             twice in a row in a folder is not asked for its larger problems
  --core     all planners run on this core alone

A cell is: CPU s to the first plan (to 10 ms) / its makespan / the best makespan; or why there is none. Quality is the best
known makespan (of the table and of all planners here) divided by a planner's, summed.
"""
import argparse
import collections
import json
import pathlib
import re
import statistics
import sys
import tempfile

from field import Field, makespan, read_steps
from processes import run

PATIENCE = 2  # failures in a row


def problems(folder):
    """(folder, domain, problem) in the order of their names."""
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


def best_known(file):
    best = {}
    for line in pathlib.Path(file).read_text().splitlines():
        cells = line.split("\t")
        if line and not line.startswith("#") and len(cells) > 2 and cells[2] not in ("", "-"):
            best[(cells[0].split("/")[-1], cells[1])] = float(cells[2])
    return best


def ours(options, field, scratch, domain, problem):
    plan, log = scratch / "ours.plan", scratch / "ours.log"
    plan.unlink(missing_ok=True)
    command = [options.program, "plan", domain, problem, "--json", "--out", plan]
    command += ["--budget", str(options.budget)] if options.budget else ["--timeout", f"{options.timeout:g}", "--budget", str(10**15)]
    command += [] if options.first else ["--anytime"]
    ended = run(command, log, float("inf"), 600 + 4 * options.timeout, lambda: b"plan: " in log.read_bytes(), options.core)
    row = {"cpu": ended.cpu, "wall": ended.wall}
    said = log.read_text()
    if "{" not in said:
        return row | {"why": "did not end" if not ended.in_time else f"exit code {ended.code}", "said": said.strip()[-160:]}
    answer = json.loads(said[said.index("{"):])
    if answer["status"] != "plan":
        return row | {"why": answer["status"], "units": answer["units"]}
    first = re.search(r"makespan ([\d.]+) s(?:, \S+ [-\d.e+]+)?, after (\d+) units", said)
    row |= {"first": ended.first_cpu, "first_wall": answer.get("first_plan_wall_s"), "first_makespan": float(first.group(1)), "units": answer["units"],
            "makespan": makespan(read_steps(plan.read_text())), "bound": answer.get("lower_bound_s")}
    if field:
        row["judged"] = field.judge(domain, problem, plan)
    else:
        judged = run([options.program, "validate", domain, problem, plan], log, 300, 1200)
        row["judged"] = {"ours": "valid" if judged.code == 0 else "INVALID"}
    if "INVALID" in (row["judged"]["ours"], row["judged"].get("val")):
        row["why"] = "INVALID"
    return row


def cell(row):
    if row.get("why"):
        return row["why"]
    first = f"{row['first']:.2f}" if row["first"] is not None else "?"
    return f"{first} / {row['first_makespan']:.3f} / {row['makespan']:.3f}"


def verdicts(judged):
    return ", ".join(f"{name} {word}" for name, word in judged.items())


class Totals:
    """Of one planner."""

    def __init__(self, name):
        self.name, self.rows = name, []

    def add(self, row, best):
        self.rows.append((row, best))

    def __str__(self):
        solved = [(row, best) for row, best in self.rows if not row.get("why")]
        why = collections.Counter(row["why"] for row, _ in self.rows if row.get("why"))
        text = f"{self.name}: solved {len(solved)} of {len(self.rows)}"
        text += "".join(f", {word} {count}" for word, count in sorted(why.items()))
        if not solved:
            return text
        firsts = [row["first"] for row, _ in solved if row["first"] is not None]
        ratios = [row["makespan"] / best for row, best in solved if best]
        text += f"; first plan, CPU: median {statistics.median(firsts):.2f} s, worst {max(firsts):.2f} s" if firsts else ""
        text += f"; sum of makespans {sum(row['makespan'] for row, _ in solved):.1f}"
        if ratios:
            text += f"; quality {sum(min(1, 1 / ratio) for ratio in ratios):.1f}, longest / best known {max(ratios):.3f}"
        text += f"; CPU {sum(row['cpu'] for row, _ in self.rows):.0f} s, wall {sum(row['wall'] for row, _ in self.rows):.0f} s"
        judges = collections.Counter((name, word.split(":")[0]) for row, _ in solved for name, word in row["judged"].items())
        return text + "; judged: " + ", ".join(f"{name} {word} {count}" for (name, word), count in sorted(judges.items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda name: str(pathlib.Path(name).resolve()))
    parser.add_argument("folder")
    parser.add_argument("--timeout", type=float, default=1.0)
    parser.add_argument("--budget", type=int)
    parser.add_argument("--first", action="store_true")
    parser.add_argument("--best")
    parser.add_argument("--only", default="", help="problems whose folder/name this is found in")
    parser.add_argument("--field")
    parser.add_argument("--with", dest="peers", default="", type=str)
    parser.add_argument("--core", type=int)
    options = parser.parse_args()
    peers = [name for name in options.peers.split(",") if name]
    if peers and not options.field:
        parser.error("--with needs --field, the interpreter that has the planners")
    scratch = tempfile.TemporaryDirectory(prefix="cxlab-plans-")
    work = pathlib.Path(scratch.name)
    field = Field(options.field, options.program, work) if options.field else None
    table = best_known(options.best) if options.best else {}
    totals = {name: Totals(name) for name in ["cxlab", *peers]}
    failures = collections.Counter()
    print(" | ".join(["problem", "cxlab", "bound", "best known", "judged", *peers]), flush=True)
    for folder, domain, problem in problems(options.folder):
        name = f"{folder.name}/{problem.stem}"
        if not re.search(options.only, name):
            continue
        rows = {"cxlab": ours(options, field, work, domain, problem)}
        for peer in peers:
            if failures[peer, folder] >= PATIENCE:
                rows[peer] = {"why": "skipped", "cpu": 0, "wall": 0}
                continue
            rows[peer] = field.solve(peer, domain, problem, options.timeout, options.first, options.core)
            failures[peer, folder] = failures[peer, folder] + 1 if rows[peer].get("why") else 0
        made = [row["makespan"] for row in rows.values() if not row.get("why")]
        known = table.get((folder.name, problem.stem))
        best = min(made + ([known] if known else []), default=None)
        for planner, row in rows.items():
            totals[planner].add(row, best)
        row = rows["cxlab"]
        bound = f"{row['bound']:.3f}" if row.get("bound") is not None else ""
        print(" | ".join([name, cell(row), bound, f"{best:.3f}" if best else "", verdicts(row.get("judged", {})), *(cell(rows[peer]) for peer in peers)]), flush=True)
        for planner, failed in rows.items():
            if failed.get("said"):
                print(f"  {planner}: {failed['said']}", file=sys.stderr, flush=True)
    print("\n" + "\n".join(map(str, totals.values())))
    sys.exit(0 if totals["cxlab"].rows and not any(row.get("why") for row, _ in totals["cxlab"].rows) else 1)


if __name__ == "__main__":
    main()
