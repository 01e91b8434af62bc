"""Trains the dispatcher that comes with cxlab: from what becomes of a game when one of its choices is made otherwise.

    python train_dispatcher.py train --out training --processes 2
    python train_dispatcher.py evaluate training/policy.json --seeds 30001..30400 --processes 2
    python train_dispatcher.py draw training/curve.csv curve.svg

Needs NumPy only. A round plays games with the policy of the round before, the first one with what the rules prefer. At some choices the game
branches (`ChoiceGame.what_if`): a copy takes another option and plays on with the same policy to its end. The points that the copy
has more are what that option is worth at that choice. A ridge regression on the terms of both options gives the next policy, which
takes the option that is worth most. The last one is in policy.json. curve.csv compares policies with the rules, by seeds kept for that
(20001...). A round has three of them: from a quarter of its games, from half of them, and from all.

`train` goes on with what training/samples.jsonl has; the same arguments give the same weights, with any number of processes.
"""

from __future__ import annotations

import argparse
import csv
import json
import multiprocessing
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cxlab.learn import Choice, ChoiceGame, LinearPolicy, play
from cxlab.learn.policy import Policy, preferred, term_values

KIND = "begin-order"  # jobs stay with the rules: another job is worth no more (docs/reference/learning.md)
START = LinearPolicy({KIND: {"preferred": 1.0, "none": 0.5}})
TERMS = ("none", "worth", "worth*worth", "payments", "first_machine_shared", "to_begin", "to_end", "none*time", "none*products")
TRAINING_SEEDS = 1_000_000  # and up, each played once
CHECKING_SEEDS = 20001  # and up
BRANCHES = (0.8, 0.05)  # the shares of the choices at which a game branches: an order is begun; none is
HELD = 20.0  # s for which a copy passes by the orders that it has passed by
CUT = 100.0  # points; a branch that makes more difference counts so much
RIDGE = 50.0  # samples
MARGIN = 3.0  # points by which an option must be worth more than the rules'

Vector = NDArray[np.float64]
Sample = dict[str, Any]


class PassingBy:
    """A policy that passes by the orders of a choice for some time."""

    def __init__(self, policy: Policy, choice: Choice) -> None:
        self.policy, self.passed, self.until = policy, set(choice.options[:-1]), choice.now + HELD

    def __call__(self, choice: Choice) -> int:
        if choice.kind == KIND and choice.now < self.until:
            choice = choice._replace(allowed=choice.allowed & [option not in self.passed for option in choice.options])
        return self.policy(choice)


def points_with(game: ChoiceGame, policy: Policy) -> float:
    """Plays a game to its end."""
    while (choice := game.next()) is not None:
        game.choose(policy(choice))
    return float(game.close()["teams"]["CYAN"]["points"])


def branch(game: ChoiceGame, policy: Policy, choice: Choice, option: int) -> float:
    """Points of the game with this option. The last option begins none of the others for a while."""

    def go_on() -> float:
        game.choose(option)
        return points_with(game, PassingBy(policy, choice) if option == len(choice.options) - 1 else policy)

    return game.what_if(go_on)


def game_with_branches(task: tuple[dict[str, dict[str, float]], int, int, str]) -> dict[str, Any]:
    """The samples of one game: both options with the situation, and the points that the other one brings."""
    weights, seed, number, scenario = task
    policy, random = LinearPolicy(weights), np.random.default_rng([number, seed])
    samples: list[Sample] = []
    with ChoiceGame(scenario, seed=seed, tier="timed") as game:
        while (choice := game.next()) is not None:
            taken = policy(choice)
            others = [option for option in np.flatnonzero(choice.allowed).tolist() if option != taken]
            if choice.kind == KIND and others and random.random() < BRANCHES[taken == len(choice.options) - 1]:
                other = others[random.integers(len(others))]
                points = branch(game, policy, choice, other)
                situation, both = choice.situation.round(4).tolist(), choice.features[[taken, other]].round(4).tolist()
                samples.append({"situation": situation, "taken": both[0], "other": both[1], "points": points})
            game.choose(taken)
        points = float(game.close()["teams"]["CYAN"]["points"])
    return {"seed": seed, "points": points, "samples": [{**sample, "gain": sample.pop("points") - points} for sample in samples]}


def term_differences(sample: Sample) -> Vector:
    features = np.array([sample["taken"], sample["other"]])
    choice = Choice(KIND, "", ["", ""], np.ones(2, bool), 0, np.array(sample["situation"]), features, 0.0)
    taken, other = term_values(choice, TERMS)
    difference: Vector = other - taken
    return difference


def fitted(games: Iterable[dict[str, Any]]) -> LinearPolicy:
    """The policy by a ridge regression of what options brought on their terms."""
    samples = [sample for game in games for sample in game["samples"]]
    x = np.array([term_differences(sample) for sample in samples])
    y = np.clip([sample["gain"] for sample in samples], -CUT, CUT)
    scale = np.sqrt((x**2).mean(axis=0)) + 1e-3
    x = x / scale
    solution = np.linalg.solve(x.T @ x + RIDGE * np.eye(len(TERMS)), x.T @ y) / scale
    weights = dict(zip(TERMS, solution.round(3).tolist(), strict=True))
    return LinearPolicy({KIND: {"preferred": MARGIN, **weights}})


def points_of(task: tuple[dict[str, dict[str, float]] | None, int, str]) -> float:
    """Points of a game with these weights; None: what the rules prefer."""
    weights, seed, scenario = task
    return float(play(preferred if weights is None else LinearPolicy(weights), seed, scenario=scenario)["teams"]["CYAN"]["points"])


def play_games(pool: Executor, policy: LinearPolicy | None, seeds: Sequence[int], scenario: str) -> Vector:
    weights = None if policy is None else policy.weights
    return np.array(list(pool.map(points_of, [(weights, seed, scenario) for seed in seeds])))


def interval(differences: Vector) -> tuple[float, float]:
    """Mean and half the width of its 95 % interval."""
    return float(differences.mean()), float(1.96 * differences.std(ddof=1) / np.sqrt(len(differences)))


def pool_of(processes: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(processes, multiprocessing.get_context("forkserver"))


class Training:
    """Keeps the games with their branches (samples.jsonl), and how the policies did (curve.csv)."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        folder, self.games, self.seed, self.scenario = Path(arguments.out), arguments.games, arguments.seed, arguments.scenario
        self.folder, self.checking = folder, range(CHECKING_SEEDS, CHECKING_SEEDS + arguments.checking)
        self.played: dict[int, dict[str, Any]] = {}
        folder.mkdir(parents=True, exist_ok=True)
        these = {name: getattr(arguments, name) for name in ("games", "checking", "seed")}
        if (folder / "arguments.json").exists():
            before = json.loads((folder / "arguments.json").read_text())
            if before != these:
                given = " ".join(f"--{name} {value}" for name, value in before.items())
                raise SystemExit(f"{folder} is a training with {given}; use those, or another --out")
        else:
            (folder / "arguments.json").write_text(json.dumps(these))
            (folder / "curve.csv").write_text("games,branches,minutes,gain,half_width\n")
            (folder / "samples.jsonl").write_text("")
        text = (folder / "samples.jsonl").read_text()
        whole = text[: text.rfind("\n") + 1]  # of a line that was being written nothing is kept
        if whole != text:
            (folder / "samples.jsonl").write_text(whole)
        for line in whole.splitlines():
            game = json.loads(line)
            self.played[game["seed"]] = game
        with (folder / "curve.csv").open() as rows:
            self.curve = list(csv.DictReader(rows))

    def policy(self, games: int) -> LinearPolicy:
        """From the first games; from none, the rules' own choices."""
        return fitted(self.played[TRAINING_SEEDS + number] for number in range(games)) if games else START

    def play(self, number: int, games: int, pool: Executor) -> None:
        """The first games, as far as they have not been played yet: those of this round with the policy from all rounds before it."""
        weights = self.policy(number * self.games).weights
        missing = [seed for seed in range(TRAINING_SEEDS, TRAINING_SEEDS + games) if seed not in self.played]
        tasks = [(weights, seed, self.seed, self.scenario) for seed in missing]
        for game in pool.map(game_with_branches, tasks):
            self.played[game["seed"]] = game
            with (self.folder / "samples.jsonl").open("a") as out:
                out.write(json.dumps(game) + "\n")

    def check(self, games: int, pool: Executor, rules: Vector, minutes: float) -> None:
        """How the policy from the first games does with the seeds kept for that."""
        policy = self.policy(games)
        (self.folder / "policy.json").write_text(policy.to_json())
        if any(row["games"] == str(games) for row in self.curve):
            return
        gain, width = interval(play_games(pool, policy, self.checking, self.scenario) - rules)
        branches = sum(len(self.played[TRAINING_SEEDS + number]["samples"]) for number in range(games))
        row = {"games": games, "branches": branches, "minutes": round(minutes, 1), "gain": round(gain, 1), "half_width": round(width, 1)}
        self.curve.append({key: str(value) for key, value in row.items()})
        with (self.folder / "curve.csv").open("a") as out:
            out.write(",".join(map(str, row.values())) + "\n")
        print(f"games {games}, branches {branches}: {gain:+.1f} ± {width:.1f} points against the rules ({minutes:.1f} min)", flush=True)


def train(arguments: argparse.Namespace) -> None:
    training = Training(arguments)
    before = float(training.curve[-1]["minutes"]) if training.curve else 0.0
    begun = time.monotonic()
    with pool_of(arguments.processes) as pool:
        rules = play_games(pool, None, training.checking, arguments.scenario)
        print(f"the rules alone: {rules.mean():.1f} points with the {len(rules)} seeds of the comparison", flush=True)
        for number in range(arguments.rounds):
            for quarters in (1, 2, 4):
                games = number * training.games + max(1, training.games * quarters // 4)
                training.play(number, games, pool)
                training.check(games, pool, rules, before + (time.monotonic() - begun) / 60)


def evaluate(arguments: argparse.Namespace) -> None:
    first, last = (int(part) for part in arguments.seeds.split(".."))
    seeds = range(first, last + 1)
    with pool_of(arguments.processes) as pool:
        rules = play_games(pool, None, seeds, arguments.scenario)
        learned = play_games(pool, LinearPolicy.load(arguments.policy), seeds, arguments.scenario)
    gain, width = interval(learned - rules)
    print(f"{len(seeds)} games: rules {rules.mean():.1f}, policy {learned.mean():.1f} points; difference {gain:+.1f} ± {width:.1f} (95 %)")
    if arguments.csv:
        rows = [f"{seed},{one:.0f},{other:.0f}" for seed, one, other in zip(seeds, rules, learned, strict=True)]
        Path(arguments.csv).write_text("\n".join(["seed,rules,policy", *rows]) + "\n")


def draw(arguments: argparse.Namespace) -> None:
    """An SVG of curve.csv: gain against the rules with the seeds kept for that, with its 95 % interval, over the games played."""
    with open(arguments.curve, encoding="utf-8") as text:
        rows = list(csv.DictReader(text))
    if not rows:
        raise SystemExit(f"{arguments.curve}: no policy has been compared with the rules yet")
    games, gain, width = (np.array([0.0, *(float(row[key]) for row in rows)]) for key in ("games", "gain", "half_width"))
    low, high = min(0.0, (gain - width).min()), max(0.0, (gain + width).max())
    x = 50 + 530 * games / games.max()
    y, top, bottom = (20 + 240 * (high - value) / (high - low) for value in (gain, gain + width, gain - width))
    zero = 20 + 240 * high / (high - low)
    bars = "".join(f'<path d="M{at:.1f} {a:.1f}V{b:.1f}" stroke="#9ab"/>' for at, a, b in zip(x, top, bottom, strict=True))
    line = " ".join(f"{at:.1f},{value:.1f}" for at, value in zip(x, y, strict=True))
    labels = "".join(
        f'<text x="44" y="{at + 4:.1f}" text-anchor="end">{value:+.0f}</text>' for at, value in ((20, high), (zero, 0), (260, low))
    )
    Path(arguments.svg).write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 600 300" font-family="sans-serif" font-size="12">'
        '<rect width="600" height="300" fill="#fff"/>'
        f'<path d="M50 {zero:.1f}H580" stroke="#000"/>{bars}<polyline points="{line}" fill="none" stroke="#147" stroke-width="2"/>{labels}'
        f'<text x="580" y="290" text-anchor="end">{games.max():.0f} games</text><text x="50" y="14">points more than the rules</text></svg>\n'
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    for name, does, about in (
        ("train", train, "train a policy"),
        ("evaluate", evaluate, "compare a policy with the rules"),
        ("draw", draw, "draw the learning curve"),
    ):
        command = commands.add_parser(name, help=about)
        command.set_defaults(does=does)
        if name != "draw":
            command.add_argument("--processes", type=int, default=1, help="games at a time (1)")
            command.add_argument("--scenario", default="rcll/external", help="whose rules ask (rcll/external)")
        if name == "train":
            command.add_argument("--out", default="training", help="folder of the training (training)")
            command.add_argument("--rounds", type=int, default=1, help="how many, each with the policy from those before (1)")
            command.add_argument("--games", type=int, default=80, help="of a round, each with some 13 branches (80)")
            command.add_argument("--checking", type=int, default=48, help="games by which policies are compared with the rules (48)")
            command.add_argument("--seed", type=int, default=1, help="of the choices at which games branch (1)")
        elif name == "draw":
            command.add_argument("curve", help="curve.csv of a training")
            command.add_argument("svg", help="the picture")
        else:
            command.add_argument("policy", help="weights (JSON)")
            command.add_argument("--seeds", default="30001..30400", help="FIRST..LAST, seeds that the training has not seen")
            command.add_argument("--csv", help="writes the points of each game there")
    arguments = parser.parse_args()
    arguments.does(arguments)


if __name__ == "__main__":
    main()
