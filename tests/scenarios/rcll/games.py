#!/usr/bin/env python3
"""Plays games of the default scenario and checks what each must show.

    games.py PROGRAM SCENARIO TIER FIRST_SEED LAST_SEED

Points, deliveries, share of work, driving together, contacts, lengths of skills; and for every accepted product that its track in
the journal is continuous: from a dispenser or shelf through grippers and belts to the gate, never by another way. Whoever a robot
waits for comes near its way.
"""
import collections
import json
import pathlib
import subprocess
import sys
import tempfile

import game_invariants

LEAST_DELIVERIES = 3
LEAST_POINTS, LEAST_MEAN_POINTS = 250, 450
LEAST_SHARE_WITH_RINGS = 0.9   # of the games: a product of C1 or more is delivered
LEAST_PIECES_A_ROBOT = 3
LEAST_SHARE_DRIVING_TOGETHER = 0.2
LEAST_SHARE_AT_WORK = 0.6
LONGEST_SKILL_S = 120


class Game:
    def __init__(self, folder):
        self.result = json.loads((folder / "result.json").read_text())
        self.pieces = collections.defaultdict(list)   # holder changes by piece
        self.deliveries = []
        self.skills = []                              # (robot, skill, begin, end, code)
        self.drives = []                              # (begin, end) of each phase of driving
        running, driving = {}, {}
        for line in (folder / "journal.jsonl").open():
            record = json.loads(line)
            data, t = record["data"], record["t"] / 1e9
            if record["kind"] == "skill" and data["event"] in ("phase", "end"):
                if data["robot"] in driving:
                    self.drives.append((driving.pop(data["robot"]), t))
                if data.get("phase") == "drive":
                    driving[data["robot"]] = t
            if record["kind"] == "skill" and data["event"] == "start":
                running[data["robot"]] = t
            elif record["kind"] == "skill" and data["event"] == "end":
                self.skills.append((data["robot"], data["skill"], running.pop(data["robot"]), t, data["code"]))
            elif record["kind"] == "referee" and data["event"] == "piece":
                self.pieces[data["piece"]].append(data)
            elif record["kind"] == "referee" and data["event"] == "delivery":
                self.deliveries.append(data)
        self.running = running

    def share_driving_together(self):
        steps = [(t, d) for begin, end in self.drives for t, d in ((begin, 1), (end, -1))]
        together = driving = last = 0
        for t, change in sorted(steps):
            together += (t - last) if driving >= 2 else 0
            driving, last = driving + change, t
        return together / self.result["sim_time_s"]

    def useful_pieces(self):
        """Pieces that each robot placed and that ended in an accepted product or gave a cap."""
        accepted = {d["piece"] for d in self.deliveries if d["correct"]}
        placed = collections.Counter()
        for piece, track in self.pieces.items():
            carrier = any(step["to"] == "slot" for step in track)
            for step in track:
                if step["from"] == "gripper" and step["to"] == "belt" and (piece in accepted or carrier):
                    placed[step["from_name"]] += 1
        return placed

    def broken_tracks(self):
        allowed = {("dispenser", "belt"), ("dispenser", "slot"), ("slot", "gripper"), ("belt", "gripper"),
                   ("gripper", "belt"), ("gripper", "slot"), ("belt", "gate")}
        for delivery in self.deliveries:
            if not delivery["correct"]:
                continue
            track = self.pieces[delivery["piece"]]
            steps = [(step["from"], step["to"]) for step in track]
            if not steps or steps[0][0] != "dispenser" or steps[-1] != ("belt", "gate"):
                yield f"piece {delivery['piece']}: begins or ends elsewhere: {steps}"
            if any(step not in allowed for step in steps):
                yield f"piece {delivery['piece']}: an impossible step in {steps}"
            if any(a["to"] != b["from"] for a, b in zip(track, track[1:])):
                yield f"piece {delivery['piece']}: a gap in {steps}"
            if sum(step == ("belt", "gripper") for step in steps) < 2:
                yield f"piece {delivery['piece']}: was not carried to the cap station and to the delivery station"

    def points(self):
        return max(team["points"] for team in self.result["teams"].values())

    def with_rings(self):
        return any(order["correct"] and order["complexity"] != "C0" for order in self.result["orders"])

    def faults(self):
        r = self.result
        if r["status"] != "completed":
            yield f"status {r['status']}: {r['reason']}"
        team = next(t for t in r["teams"].values() if t["points"])
        if sum(team["by_kind"].values()) != team["points"]:
            yield "the kinds do not sum to the points"
        accepted = sum(d["correct"] for d in r["deliveries"])
        if accepted < LEAST_DELIVERIES:
            yield f"only {accepted} deliveries"
        if self.points() < LEAST_POINTS:
            yield f"only {self.points()} points"
        for robot in r["robots"]:
            if robot["contacts"]:
                yield f"{robot['name']} touched another robot"
            if r["tier"] == "physics" and robot["busy_s"] < LEAST_SHARE_AT_WORK * r["sim_time_s"]:
                yield f"{robot['name']} at work only {robot['busy_s'] / r['sim_time_s']:.0%}"
            if self.useful_pieces()[robot["name"]] < LEAST_PIECES_A_ROBOT:
                yield f"{robot['name']} placed only {self.useful_pieces()[robot['name']]} pieces that mattered"
        if (share := self.share_driving_together()) < LEAST_SHARE_DRIVING_TOGETHER:
            yield f"two or more robots drive at once only {share:.0%} of the game"
        longest = max(end - begin for _, _, begin, end, _ in self.skills)
        if longest > LONGEST_SKILL_S:
            yield f"a skill took {longest:.0f} s"
        for robot, skill, begin, _, code in self.skills:
            if skill == "drive_to" and code != 0:
                yield f"{robot} gave up a drive at {begin:.0f} s: {code}"
        yield from self.broken_tracks()


def main():
    if len(sys.argv) != 6:
        sys.exit(__doc__)
    program, scenario, tier, first, last = sys.argv[1:]
    failed, deliveries, points, with_rings = 0, [], [], 0
    with tempfile.TemporaryDirectory(prefix="cxlab-games-") as folder:
        for seed in range(int(first), int(last) + 1):
            out = pathlib.Path(folder) / str(seed)
            done = subprocess.run([program, "run", scenario, "--tier", tier, "--seed", str(seed), "--quiet", "--out", str(out)],
                                  capture_output=True, text=True)
            game = Game(out)
            faults = list(game.faults()) + list(game_invariants.waits(game_invariants.Game(out))) + ([f"exit code {done.returncode}: {done.stderr}"] if done.returncode else [])
            accepted = sum(d["correct"] for d in game.result["deliveries"])
            deliveries.append(accepted)
            points.append(game.points())
            with_rings += game.with_rings()
            idlest = min(robot["busy_s"] for robot in game.result["robots"]) / game.result["sim_time_s"]
            print(f"seed {seed}: {game.points()} points, {accepted} delivered, each robot at work {idlest:.0%} or more, "
                  f"driving together {game.share_driving_together():.0%}", *faults, sep="; ", flush=True)
            failed += bool(faults)
    games, mean = len(points), sum(points) / len(points)
    print(f"{games - failed} passed, {failed} failed; {mean:.0f} points, {sum(deliveries) / games:.2f} deliveries a game, "
          f"rings in {with_rings} of {games}")
    sys.exit(1 if failed or mean < LEAST_MEAN_POINTS or with_rings < LEAST_SHARE_WITH_RINGS * games else 0)


if __name__ == "__main__":
    main()
