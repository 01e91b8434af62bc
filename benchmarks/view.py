#!/usr/bin/env python3
"""CPU time of answers of cxlab view about full timed games of both agents, going back and forth in time.

python3 benchmarks/view.py CXLAB [FOLDER]   (FOLDER keeps the games for a second call)
"""

import http.client
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

GAMES = [("rules", ["rcll/game", "--tier", "timed"]), ("plans", ["rcll/planning", "--tier", "timed"])]
TIMES = [600, 100, 1100, 1150, 300]
QUESTIONS = [{"ask": "facts", "brief": True}, {"ask": "facts"}, {"ask": "agenda"}, {"ask": "why", "what": "time-retract"}, {"ask": "why_not", "what": "finalize-goals"},
             {"ask": "rules"}, {"ask": "firings", "limit": 300}, {"ask": "source", "rule": "finalize-goals"}]
TICKS = os.sysconf("SC_CLK_TCK")


def of_all(pid):
    """Seconds of CPU of a process and of those below it."""
    words = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return sum(map(int, words[11:15])) / TICKS + sum(of_all(child) for child in children)


def main():
    cxlab, *folder = sys.argv[1:]
    folder = Path(folder[0] if folder else tempfile.mkdtemp(prefix="cxlab-view-"))
    for name, words in GAMES:
        run = folder / name
        if not run.exists():
            subprocess.run([cxlab, "run", *words, "--quiet", "--out", run], check=True, stdout=subprocess.DEVNULL)
        server = subprocess.Popen([cxlab, "view", run], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        port, token = re.search(r":(\d+)/\?token=(\w+)", server.stdout.readline()).groups()

        def send(path, body=None):
            line = http.client.HTTPConnection("127.0.0.1", int(port))
            line.request("POST" if body else "GET", f"/run/{name}/{path}", json.dumps(body) if body else None,
                         {"Authorization": "Bearer " + token, "Content-Type": "application/json"})
            answer = line.getresponse()
            content = answer.read()
            assert answer.status == 200, content[:300]
            return len(content)

        def measure(what, call):
            before, began = of_all(server.pid), time.monotonic()
            size = call()
            cpu, wall = of_all(server.pid) - before, time.monotonic() - began
            print(f"{name}  {what:44} {cpu:6.2f} s of CPU {wall:6.2f} s {size / 1000:8.1f} kB", flush=True)
            return cpu

        measure("begin: the first question", lambda: send("ask", {"ask": "where"}))
        for question in QUESTIONS:
            worst = 0
            for t in TIMES:
                before = of_all(server.pid)
                size = send("ask", {**question, "t": t})
                worst = max(worst, of_all(server.pid) - before)
            again = of_all(server.pid)
            send("ask", {**question, "t": TIMES[-1]})
            again = of_all(server.pid) - again
            print(f"{name}  {' '.join(map(str, question.values())):44} {worst:6.2f} s of CPU at most, {again:.2f} once more, {size / 1000:8.1f} kB", flush=True)
        measure("one firing back, and facts", lambda: send("go", {"back": 1}) + send("ask", {"ask": "facts", "brief": True}))
        measure("one firing on, and facts", lambda: send("go", {"step": 1}) + send("ask", {"ask": "facts", "brief": True}))
        measure("the page", lambda: send("") + send("data.json") + send("scene.bin"))
        server.terminate()
        server.wait()


if __name__ == "__main__":
    main()
