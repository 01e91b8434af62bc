#!/usr/bin/env python3
"""Compares what happens in a run of a shipped scenario with the list kept beside this file.

    golden.py check  PROGRAM NAME     plays the scenario NAME and compares; exit code 1 and a diff where they differ
    golden.py update PROGRAM [NAME]   plays and writes the lists; a commit that changes one says why

The lists are short on purpose. The list of a game has a stretch with a product on its way, a delivery and a fault, which a
person can follow beside the rules. Checks of whole games are in tests/scenarios/rcll/game_invariants.py.

A line is one event, "seconds what": events of referee and skills of a game, commands and fired rules of a world without
a referee. Numbers with a fraction (poses, durations) are left out, and times may differ by 0.05 s. They come from functions
of the C library that can differ in the last bit from machine to machine.
"""
import collections
import difflib
import json
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SCENARIOS = HERE.parents[2] / "scenarios"
# Name: scenario, arguments, kinds of records, window in seconds.
GAME, AGENT = {"referee", "skill", "decision", "error"}, {"control", "fire", "decision", "error"}
FAULTS = "faults=[{kind: machine_breaks, machine: C-RS1, at: 300}, {kind: machine_down, machine: C-CS1, at: 400, seconds: 40}, \
{kind: piece_dropped, robot: robot1, at: 500}, {kind: skill_fails, skill: drive_to, at: 600}]"
RUNS = {
    "rcll_game": ("rcll/game.yaml", ["--tier", "timed"], GAME, (300, 360)),
    "rcll_faults": ("rcll/game.yaml", ["--tier", "timed", "--seed", "2", "--set", "world.rules=rulebook", "--set", FAULTS], GAME,
                    (295, 345)),
    "rcll_two_teams": ("rcll/two_teams.yaml", ["--tier", "timed", "--seed", "3"], GAME, (665, 705)),
    "rcll_planning": ("rcll/planning.yaml", ["--tier", "timed"], GAME, (365, 405)),
    "turtlesim_boundary": ("turtlesim/boundary.yaml", [], AGENT, (0, 1e9)),
    "turtlesim_boundary_late": ("turtlesim/boundary_late.yaml", [], AGENT, (0, 1e9)),
    "turtlesim_figures": ("turtlesim/figures.yaml", [], AGENT, (0, 1e9)),
    "turtlesim_hypotheses": ("turtlesim/hypotheses.yaml", [], AGENT, (0, 1e9)),
}
TOLERANCE_S = 0.05
OFTEN = 20          # an event of an agent that comes more often stands in the list once
MOST_LINES = 60     # of a diff
LEFT_OUT = {"facts", "fact", "position", "units"}


def what(record):
    """The event in words, without the numbers that may differ from machine to machine."""
    def word(value):
        return f'"{value}"' if isinstance(value, str) and (" " in value or not value) else json.dumps(value).strip('"')
    stream, data = record["stream"].split("/")[-1], dict(record["data"])
    event = data.pop("event", data.pop("what", record["kind"]))
    slots = [f"{slot}={value}" for slot, value in data.pop("slots", {}).items()]  # of a fact, as CLIPS writes them
    words = [f"{key}={word(value)}" for key, value in data.items()
             if key not in LEFT_OUT and value != stream and not isinstance(value, float)]
    return " ".join([stream, event, *words, *slots])


def play(program, name):
    """[(seconds, what)] of a run."""
    scenario, arguments, kinds, (begin, end) = RUNS[name]
    with tempfile.TemporaryDirectory(prefix="cxlab-golden-") as folder:
        done = subprocess.run([program, "run", str(SCENARIOS / scenario), *arguments, "--journal", "full", "--quiet", "--force",
                               "--out", folder], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{scenario}: exit code {done.returncode}\n{done.stderr}")
        records = [json.loads(line) for line in (pathlib.Path(folder) / "journal.jsonl").open()]
    records = [r for r in records if r["kind"] in kinds and begin <= r["t"] / 1e9 < end]
    # In the order of time; within a tick by stream.
    records.sort(key=lambda r: (r["t"], r["stream"], r["n"]))
    events = [(r["t"] / 1e9, what(r)) for r in records]
    if kinds is not AGENT:
        return events
    counts, seen, kept = collections.Counter(w for _, w in events), set(), []
    for t, w in events:
        if counts[w] <= OFTEN:
            kept.append((t, w))
        elif w not in seen:
            kept.append((t, w + " (and often after that)"))
        seen.add(w)
    return kept


def lines(events):
    return [f"{t:.2f} {w}" for t, w in events]


def read(name):
    split = [line.split(" ", 1) for line in (HERE / f"{name}.txt").read_text().splitlines()]
    return [(float(t), w) for t, w in split]


def differences(wanted, found):
    """A diff of the two lists of events; times within the tolerance count as equal."""
    matcher = difflib.SequenceMatcher(None, [w for _, w in wanted], [w for _, w in found], autojunk=False)
    out = []
    for tag, a, a_end, b, b_end in matcher.get_opcodes():
        if tag == "equal":
            for (t, w), (u, _) in zip(wanted[a:a_end], found[b:b_end]):
                if abs(t - u) > TOLERANCE_S:
                    out += [f"-{t:.2f} {w}", f"+{u:.2f} {w}"]
        else:
            out += [f"-{line}" for line in lines(wanted[a:a_end])] + [f"+{line}" for line in lines(found[b:b_end])]
    return out


def main():
    command, program, *names = sys.argv[1:]
    if command == "update":
        for name in names or RUNS:
            (HERE / f"{name}.txt").write_text("".join(line + "\n" for line in lines(play(program, name))))
        return
    diff = differences(read(names[0]), found := play(program, names[0]))
    if not diff:
        print(f"{len(found)} events as expected")
        return
    print(f"{names[0]}: other events than in {names[0]}.txt (- expected, + found):")
    print("\n".join(diff[:MOST_LINES]))
    if len(diff) > MOST_LINES:
        print(f"... and {len(diff) - MOST_LINES} more lines")
    print("If the change is wanted: golden.py update, and say why in the commit (docs/internals/tests-of-cxlab.md)")
    sys.exit(1)


if __name__ == "__main__":
    main()
