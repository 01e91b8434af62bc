"""What it costs to step a game from Python tick by tick: PYTHONPATH=build/release/python python3 benchmarks/python_steps.py [REPEATS]

Plays the same game with `cxlab run` and with one call of `Episode.step` for each tick, in processes of their own and in turn.
Prints CPU seconds, the least of the repeats, so that other work on the machine counts little: of the program; of Python from
loading the scenario to the end; of its whole process, which also starts the interpreter. Checks that both played the same game.
"""

import json
import os
import resource
import subprocess
import sys

import cxlab

REPEATS = int(sys.argv[1]) if len(sys.argv) > 1 else 5
STEPS = """
import cxlab, json, time
begin = time.process_time()
with cxlab.Episode("rcll/game", seed=1, tier={tier!r}, until={until}) as episode:
    while not episode.step()[2]:
        pass
print(json.dumps(episode.close() | {{"cpu_s": time.process_time() - begin}}))
"""


def cpu_of(command):
    """CPU seconds of a process, and the result that it prints."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, json.loads(said)


for tier, until in (("timed", 1200), ("physics", 300)):
    game = ["--seed", "1", "--tier", tier, "--until", str(until), "--out", "none", "--quiet", "--json"]
    by_program = [os.fspath(cxlab.program()), "run", "rcll/game", *game]
    by_python = [sys.executable, "-c", STEPS.format(tier=tier, until=until)]
    program, game_s, process = [], [], []
    for _ in range(REPEATS):
        spent, then = cpu_of(by_program)
        program.append(spent)
        spent, now = cpu_of(by_python)
        process.append(spent)
        game_s.append(now["cpu_s"])
        assert then["journal_hash"] == now["journal_hash"]
    base = min(program)
    print(
        f"{tier:8} {now['ticks']:6} ticks  program {base:.3f} s  "
        f"game from Python {min(game_s):.3f} s ({min(game_s) / base:.2f} x)  "
        f"whole process {min(process):.3f} s ({min(process) / base:.2f} x)"
    )
