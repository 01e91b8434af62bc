#!/usr/bin/env python3
"""Plays games, and beside each the referee box as a model (referee_model.py): both must agree event by event.

    referee_games.py PROGRAM TIER FIRST_SEED LAST_SEED [KIND]...   # none, script, a fault of fault_games.py, together

By default all kinds. `script` is a game without an agent, in which random instructions, picks, places and reports of both
teams, mostly senseless, meet random faults of machines. In the first game some records are changed, and the comparison must see each change.
"""
import json
import pathlib
import random
import subprocess
import sys
import tempfile

import fault_games
import referee_model

RULES = ("refbox", "rulebook", "league")
ACTIONS = {"instruct_machine": "rcll_interfaces/action/InstructMachine", "pick": "cxlab_skills/action/Pick",
           "place": "cxlab_skills/action/Place", "discard": "cxlab_skills/action/Discard"}


class Script:
    """A scenario of random deeds."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.stimuli, self.instructed = [], set()
        draw = self.random
        self.orders = [self.order() for _ in range(12)]
        for team in "CM":
            at = 1.0
            while (at := at + draw.expovariate(1 / 9)) < 1190:
                self.instruct(at, team if draw.random() < 0.97 else "M", self.goal(team))
            for _ in range(8):
                self.report(draw.choice([180, 180.02, draw.uniform(0, 182)]), team)
        for robot in range(1, 7):
            self.carry(f"robot{robot}", "C" if robot < 4 else "M")
        self.stimuli.sort(key=lambda stimulus: stimulus["at"])

    def order(self):
        draw, begin = self.random, self.random.randrange(900)
        return {"complexity": "C0", "base_color": self.base(), "cap_color": draw.choice(["CAP_GREY", "CAP_BLACK"]),
                "activate_at": max(0, begin - draw.choice([0, 60, 120])), "delivery_begin": begin,
                "delivery_end": begin + draw.choice([8, 20, 60, 150, 300]), "delivery_gate": draw.randint(1, 3),
                "quantity": draw.randint(1, 2), "competitive": draw.random() < 0.3}

    def base(self):
        return "BASE_" + self.random.choice(["RED", "SILVER", "BLACK"])

    def add(self, at, **deed):
        self.stimuli.append({"at": max(0, round(at * 50) / 50), **deed})

    def instruct(self, at, team, goal):
        """Once a machine and tick: the journal does not say which of two a fault strikes."""
        if (key := (round(at * 50), goal["machine"])) in self.instructed:
            return
        self.instructed.add(key)
        self.act(at, "/cyan/factory" if team == "C" else "/magenta/factory", "instruct_machine", goal)

    def act(self, at, node, action, goal):
        self.add(at, send_goal=f"{node}/{action}", type=ACTIONS[action], goal=goal)

    def goal(self, team):
        draw = self.random
        machine = draw.choice(["BS", "CS1", "CS2", "RS1", "RS2", "DS", "SS", "SS"])
        fields = {"BS": {"side": draw.choice(["INPUT", "OUTPUT"]), "base_color": self.base()},
                  "CS": {"operation": draw.choice(["RETRIEVE_CAP", "MOUNT_CAP"])},
                  "RS": {"ring_color": "RING_" + draw.choice(["BLUE", "GREEN", "ORANGE", "YELLOW"])},
                  "DS": {"order_id": draw.randrange(15)},
                  "SS": {"operation": draw.choice(["STORE", "RETRIEVE", "RETRIEVE", "CHANGE_INFO"]),
                         "shelf": draw.choice([0, 1, 2, 3, 4, 5] * 3 + [6]), "slot": draw.choice([0, 1, 1, 1, 2, 3])}}
        fields = fields[machine[:2]]
        fields = {"operation": "RESET"} if draw.random() < 0.05 else {} if draw.random() < 0.03 else fields
        return {"machine": f"{team if draw.random() < 0.97 else 'X'}-{machine}", **fields}

    def report(self, at, team):
        draw = self.random
        machine = draw.choice(["BS", "CS1", "CS2", "RS1", "RS2", "DS", "SS"])
        right = draw.random() < 0.7
        whose, other = team if draw.random() < 0.8 else "MC"["CM".index(team)], "CYAN" if team == "M" else "MAGENTA"
        entry = {"name": f"{whose}-{machine}" if draw.random() < 0.7 else "", "type": machine[:2],
                 "zone": (whose, machine) if right else draw.choice(["C_Z11", ""]),
                 "rotation": -1 if draw.random() < 0.4 else 90}
        self.add(at, publish="/cyan/machine_report" if team == "C" else "/magenta/machine_report",
                 type="rcll_interfaces/msg/MachineReport", data={"team_color": other if draw.random() < 0.1 else "", "machines": [entry]})

    def carry(self, robot, team):
        draw, at = self.random, self.random.uniform(5, 10)
        while at < 1180:
            to = team if draw.random() < 0.96 else "CM"[team == "C"]
            kind = draw.random()
            if kind < 0.3:
                source = "BS-OUTPUT"
                target = draw.choice(["RS1-SLIDE", "RS2-SLIDE", "RS1-INPUT", "RS2-INPUT", "CS1-INPUT", "SS-INPUT"])
                self.instruct(at - 4.5, team, {"machine": f"{team}-BS", "side": "OUTPUT", "base_color": self.base()})
            elif kind < 0.6:
                station = draw.choice(["CS1", "CS2"])
                source = f"{station}-SHELF-{draw.choice(['LEFT', 'MIDDLE', 'RIGHT'])}"
                target = draw.choice([f"{station}-INPUT"] * 3 + ["RS1-SLIDE"])
            elif kind < 0.85:
                shelf = draw.randrange(6)
                source, target, parts = "SS-OUTPUT", "DS-INPUT", referee_model.STORED[shelf].split()
                self.instruct(at - 3, team, {"machine": f"{team}-SS", "operation": "RETRIEVE", "shelf": shelf, "slot": 1})
                at += 21
                fits = [i for i, o in enumerate(self.orders, 1) if [o["base_color"], o["cap_color"]] == parts]
                self.instruct(at + draw.uniform(34, 46), team, {"machine": f"{team}-DS", "order_id": draw.choice(fits or [1])})
            else:
                source = draw.choice(["CS1", "CS2", "RS1", "RS2"]) + "-OUTPUT"
                target = draw.choice(["RS1-SLIDE", "CS1-INPUT", "DS-INPUT", "RS1-INPUT"])
            self.act(at, f"/{robot}", "pick", {"target": f"{team}-{source}"})
            self.act(at + 20, f"/{robot}", "place", {"target": f"{to}-{target}"})
            if draw.random() < 0.3:
                self.act(at + 39, f"/{robot}", "discard", {"target": ""})
            at += 42

    def scenario(self, zones):
        for stimulus in self.stimuli:
            for entry in stimulus.get("data", {}).get("machines", []):
                if isinstance(entry["zone"], tuple):
                    entry["zone"] = zones["-".join(entry["zone"])]
        machines = [f"{team}-{machine}" for team in "CM" for machine in ("BS", "CS1", "CS2", "DS", "RS1", "RS2", "SS")]
        faults = [{"kind": kind, "machine": machine, **keys} for machine in machines for kind, keys in {
            "machine_breaks": {"mean_s": 500}, "machine_down": {"mean_s": 200, "seconds": self.random.choice([10, 25, 45])},
            "piece_taken": {"mean_s": 400}, "instruction_lost": {"probability": 0.05},
            "instruction_late": {"probability": 0.1, "seconds": self.random.choice([3, 12])}}.items()]
        return {"schema": 1, "world": {"kind": "rcll", "orders": self.orders}, "stimuli": self.stimuli, "faults": faults,
                "timed": {"pick_mean_s": 2.5, "pick_sigma_s": 0.1, "place_mean_s": 2.5, "place_sigma_s": 0.1}}


def play(program, tier, kind, seed, folder):
    """The folder of the game."""
    out, rules = folder / f"{kind}-{seed}", RULES[seed % 3]
    arguments = {"world.rules": rules, "world.information": "all", "world.setup_s": "0", "world.team": "CYAN",
                 "world.exploration": "true" if seed % 2 else "false"}
    scenario = "rcll/game"
    if kind == "script":
        script = Script(seed)
        drawn = folder / f"drawn-{seed}.yaml"
        subprocess.run([program, "new", "game", drawn, "--seed", str(seed)], check=True, capture_output=True)
        zones = dict(referee_model.re.findall(r"machine: (\S+)\n +zone: (\S+)", drawn.read_text()))
        scenario = folder / f"script-{seed}.yaml"
        scenario.write_text(json.dumps(script.scenario(zones)))
        arguments.update({"world.team": "BOTH", "world.setup_s": str(seed % 3 * 5)})
    elif kind != "none":
        arguments["faults"] = json.dumps(fault_games.faults_of(kind))
    done = subprocess.run([program, "run", str(scenario), "--tier", tier, "--seed", str(seed), "--quiet", "--journal", "full",
                           "--out", str(out), *(x for key, value in arguments.items() for x in ("--set", f"{key}={value}"))],
                          capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"exit code {done.returncode}: {done.stderr}")
    return out


def problems(folder, change=lambda records: None):
    game = referee_model.Game(folder)
    change(game.records)
    game.play()
    return game.compare()


def changes():
    """Changes of a journal that must be seen: a name and what is done to the records."""
    def edit(find, alter):
        def change(records):
            i = next(i for i, (t, _, d) in enumerate(records) if t > 1 and find(d))
            records[i:i + 1] = alter(*records[i])
        return change
    event = lambda name: lambda d: d.get("event") == name
    message = lambda d: d.get("op") == "publish" and d["name"].endswith("/machine_info")
    idle = lambda d: event("machine")(d) and d["state"] == "IDLE"

    def relight(t, stream, d):
        machine = d["msg"]["machines"][0]
        light = machine["lights"][1]
        light["state"] = "BLINK" if light["state"] != "BLINK" else "OFF"
        return [(t, stream, d)]
    yield "a state is missing", edit(idle, lambda *r: [])
    yield "a state is 0.1 s late", edit(idle, lambda t, s, d: [(t + 0.1, s, d)])
    yield "a state is another", edit(idle, lambda t, s, d: [(t, s, {**d, "state": "WAIT-IDLE"})])
    yield "a score is a point more", edit(event("score"), lambda t, s, d: [(t, s, {**d, "points": d["points"] + 1})])
    yield "a score comes twice", edit(event("score"), lambda *r: [r, r])
    yield "an order comes late", edit(event("order"), lambda t, s, d: [(t + 1, s, d)])
    yield "an answer is another", edit(lambda d: d.get("op") == "result", lambda t, s, d: [
        (t, s, {**d, "result": {**d["result"], "error_code": d["result"]["error_code"] + 1}})])
    yield "a lamp is another", edit(message, relight)


def main():
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    program, tier, first, last, *kinds = sys.argv[1:]
    played = failed = 0
    with tempfile.TemporaryDirectory(prefix="cxlab-referee-") as folder:
        for seed in range(int(first), int(last) + 1):
            for kind in kinds or ["none", "script", *fault_games.FAULTS, "together"]:
                out = play(program, tier, kind, seed, pathlib.Path(folder))
                bad = problems(out)
                if not played and not bad:
                    bad = [f"not seen: {name}" for name, change in changes() if not problems(out, change)]
                print(f"{kind}, seed {seed}, {RULES[seed % 3]}: {'differs' if bad else 'agrees'}", *bad, sep="\n  ", flush=True)
                played += 1
                failed += bool(bad)
    print(f"{played - failed} agree, {failed} differ")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
