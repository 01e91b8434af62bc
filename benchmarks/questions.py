#!/usr/bin/env python3
"""CPU time and memory of questions about full games of both agents, in both tiers.

python3 benchmarks/questions.py CXLAB [FOLDER]   (FOLDER keeps the games for a second call)
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

GAMES = [("rules, timed", ["rcll/game", "--tier", "timed"]), ("rules, physics", ["rcll/game"]),
         ("plans, timed", ["rcll/planning", "--tier", "timed"]), ("plans, physics", ["rcll/planning"])]
QUESTIONS = [["facts", "RUN"], ["facts", "RUN", "--at", "10:00"], ["firings", "RUN"], ["rules", "RUN"], ["why", "RUN", "time-retract"],
             ["why-not", "RUN", "finalize-goals"], ["diff", "RUN", "RUN"], ["orders", "RUN"], ["waits", "RUN"], ["pieces", "RUN"],
             ["attach", "RUN", "-c", "back"], ["attach", "RUN", "-c", "back", "-c", "back", "-c", "back"]]


def measure(words):
    """Seconds of CPU, and MB of memory at most; of the process that plays again, too."""
    child = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    return child.returncode, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def main():
    cxlab, *folder = sys.argv[1:]
    folder = Path(folder[0] if folder else tempfile.mkdtemp(prefix="cxlab-questions-"))
    print(f"{'CPU in s, memory in MB':44}" + "".join(f"{name:>18}" for name, _ in GAMES))
    for number, (_, words) in enumerate(GAMES):
        if not (folder / str(number)).exists():
            subprocess.run([cxlab, "run", *words, "--quiet", "--out", folder / str(number)], check=True, stdout=subprocess.DEVNULL)
    for question in QUESTIONS:
        row = f"{' '.join(question):44}"
        for number in range(len(GAMES)):
            code, seconds, memory = measure([cxlab, *[str(folder / str(number)) if word == "RUN" else word for word in question]])
            row += f"{seconds:8.2f} s {memory:4.0f} MB" + (f" ({code})" if code else "")
        print(row, flush=True)


if __name__ == "__main__":
    main()
