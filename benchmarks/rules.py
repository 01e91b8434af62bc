#!/usr/bin/env python3
"""Message -> fact -> rule -> command: cxlab beside plain CLIPS in C and beside clipspy.

    python3 -m venv build/clipspy && build/clipspy/bin/pip install clipspy==1.0.6
    build/clipspy/bin/python benchmarks/rules.py build/release/benchmarks/bench_rules [--cycles N] [--rounds N]

The same rule in all three. In C and in Python its functions return constants: they have no messages, no bus and no journal.
Everything is run in turns; CPU time, medians are printed. clipspy gets slower as an environment goes on, because nothing
collects its garbage: what is measured is the first 2,000 cycles of a fresh one.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import time

import clips

TEMPLATE = "(deftemplate ros-msgs-message (slot topic (type STRING)) (slot msg-ptr (type INTEGER)))"
RULE = """(defrule command
  ?f <- (ros-msgs-message (topic "pose") (msg-ptr ?m))
  =>
  (retract ?f)
  (bind ?x (ros-msgs-get-field ?m "x"))
  (bind ?y (ros-msgs-get-field ?m "y"))
  (bind ?w (ros-msgs-get-field ?m "w"))
  (bind ?c (ros-msgs-create-message "geometry_msgs/msg/Vector3"))
  (ros-msgs-set-field ?c "x" (+ ?x ?w))
  (ros-msgs-set-field ?c "y" ?y)
  (ros-msgs-publish ?c "command")
  (ros-msgs-destroy-message ?c)
  (ros-msgs-destroy-message ?m))"""


class Agent:
    """The rule in clipspy. Handles are integers: it cannot make external addresses."""

    def __init__(self):
        self.env = clips.Environment()
        for name, function in {
            "ros-msgs-create-message": lambda kind: 2,
            "ros-msgs-destroy-message": lambda message: None,
            "ros-msgs-get-field": lambda message, field: 0.5,
            "ros-msgs-set-field": lambda message, field, value: None,
            "ros-msgs-publish": lambda message, topic: None,
        }.items():
            self.env.define_function(function, name)
        self.env.build(TEMPLATE)
        self.env.build(RULE)
        self.template = self.env.find_template("ros-msgs-message")

    def cycle(self):
        self.template.assert_fact(**{"topic": "pose", "msg-ptr": 1})
        return self.env.run()


PYTHON_CYCLES = 2000


def nanoseconds(agent, cycles):
    start = time.process_time()
    fired = sum(agent.cycle() for _ in range(cycles))
    if fired != cycles:
        raise SystemExit(f"clipspy: {fired} of {cycles} rules fired")
    return (time.process_time() - start) / cycles * 1e9


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--cycles", type=int, default=100000)
    parser.add_argument("--rounds", type=int, default=5)
    args = parser.parse_args()
    environment = {"CXLAB_SOURCE_DIR": str(pathlib.Path(__file__).resolve().parent.parent), **os.environ}
    ours, plain, python = [], [], []
    for _ in range(args.rounds):
        done = subprocess.run([args.program, str(args.cycles), "3"], env=environment, check=True, capture_output=True, text=True)
        figures = json.loads(done.stdout)
        ours.append(figures["cxlab_ns"])
        plain.append(figures["plain_clips_ns"])
        python.append(nanoseconds(Agent(), PYTHON_CYCLES))
    print(f"cxlab        {statistics.median(ours):8.0f} ns a cycle (journal hash {figures['hash']})")
    print(f"plain CLIPS  {statistics.median(plain):8.0f} ns: cxlab has {statistics.median(p / o for p, o in zip(plain, ours)):.2f} of its speed")
    print(f"clipspy      {statistics.median(python):8.0f} ns: cxlab has {statistics.median(p / o for p, o in zip(python, ours)):.1f} times its speed")


if __name__ == "__main__":
    main()
