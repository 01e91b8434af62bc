"""Trains the dispatcher that comes with cxlab: evolution strategies over whole games, started from greedy's own choices.

    python train_dispatcher.py train --out training --minutes 60 --processes 2
    python train_dispatcher.py evaluate training/best.json --seeds 30001..30200 --processes 2
    python train_dispatcher.py draw training/curve.csv curve.svg

Needs NumPy only. The policy is linear in the features of each option (docs/reference/learning.md). Each generation plays pairs of games with
the same seed, one with the weights plus a perturbation, one minus it; the differences of their points, cut at 150, are the
gradient, which Adam follows. Each 5 generations the weights play seeds kept for that (20001...); the best ones so far are kept
in best.json. `train` goes on from training/state.json, if there is one; the same arguments give the same weights, with any
number of processes.
"""

from __future__ import annotations

import argparse
import csv
import json
import multiprocessing
import time
from concurrent.futures import Executor, ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cxlab.learn import LinearPolicy, play
from cxlab.learn.features import KINDS, OPTION
from cxlab.learn.policy import preferred

# What is trained; the other weights stay: 1 for what the rules prefer, 0 else.
TRAINED = {
    "begin-order": ("none", "worth", "points", "jobs", "rings", "payments", "to_begin", "to_end", "first_machine_shared",
                    "machines_shared", "cap_ready", "spare_robots"),
    "take-job": ("urgency", "way", "haul", "buffer", "clear", "pay", "deliver", "not_there_yet", "not_free_yet", "points",
                 "time_left", "next_users"),
}  # fmt: skip
TRAINING_SEEDS = 1_000_000  # and up, each played once
CHOOSING_SEEDS = range(20001, 20049)
SIGMA = 0.3
RATE = 0.06
CUT = 150.0
EVERY = 5

Vector = NDArray[np.float64]


def trained() -> NDArray[np.bool_]:
    """Which weights of the vector of a policy are trained."""
    return np.array([name in TRAINED[kind] for kind in KINDS for name in OPTION[kind]])


def points(task: tuple[list[float] | None, int]) -> float:
    """Points of a game with these weights; None: what the rules prefer."""
    weights, seed = task
    policy = preferred if weights is None else LinearPolicy.of_vector(np.array(weights))
    return float(play(policy, seed)["teams"]["CYAN"]["points"])


def play_games(pool: Executor, weights: Vector | None, seeds: range) -> Vector:
    given = None if weights is None else weights.tolist()
    return np.array(list(pool.map(points, [(given, seed) for seed in seeds])))


def interval(differences: Vector) -> tuple[float, float]:
    """Mean and half the width of its 95 % interval."""
    return float(differences.mean()), float(1.96 * differences.std(ddof=1) / np.sqrt(len(differences)))


class Training:
    """The state of a training; all of it is in state.json."""

    def __init__(self, folder: Path, pairs: int, seed: int) -> None:
        self.folder, self.pairs, self.seed = folder, pairs, seed
        self.weights = LinearPolicy.greedy().vector()
        self.first, self.second = np.zeros_like(self.weights), np.zeros_like(self.weights)
        self.generation = 0
        self.best: float | None = None
        folder.mkdir(parents=True, exist_ok=True)
        if (folder / "state.json").exists():
            state: dict[str, Any] = json.loads((folder / "state.json").read_text())
            if (state["pairs"], state["seed"]) != (pairs, seed):
                raise SystemExit(f"{folder}/state.json is of --pairs {state['pairs']} --seed {state['seed']}; use those, or another --out")
            self.weights, self.first, self.second = (np.array(state[key]) for key in ("weights", "first", "second"))
            self.generation, self.best = state["generation"], state["best"]
        else:
            (folder / "curve.csv").write_text("generation,games,minutes,training_points,choosing_gain,half_width\n")

    def save(self) -> None:
        state = {
            "pairs": self.pairs, "seed": self.seed, "generation": self.generation, "best": self.best,
            "weights": self.weights.tolist(), "first": self.first.tolist(), "second": self.second.tolist(),
        }  # fmt: skip
        new = self.folder / "state.json.new"
        new.write_text(json.dumps(state))
        new.replace(self.folder / "state.json")

    def step(self, pool: Executor) -> float:
        """One generation; the mean points of its games."""
        random = np.random.default_rng([self.seed, self.generation])
        noise = random.standard_normal((self.pairs, len(self.weights))) * trained()
        first_seed = TRAINING_SEEDS + self.generation * self.pairs
        tasks = [
            ((self.weights + sign * SIGMA * row).tolist(), first_seed + number)
            for number, row in enumerate(noise)
            for sign in (1, -1)
        ]
        games = np.array(list(pool.map(points, tasks))).reshape(self.pairs, 2)
        differences = np.clip(games[:, 0] - games[:, 1], -CUT, CUT)
        gradient = differences @ noise / (2 * SIGMA * self.pairs)
        self.generation += 1
        self.first = 0.9 * self.first + 0.1 * gradient
        self.second = 0.99 * self.second + 0.01 * gradient**2
        step = self.first / (1 - 0.9**self.generation)
        scale = np.sqrt(self.second / (1 - 0.99**self.generation))[trained()].mean() + 1e-9
        self.weights = self.weights + RATE * step / scale
        return float(games.mean())


def train(arguments: argparse.Namespace) -> None:
    training = Training(Path(arguments.out), arguments.pairs, arguments.seed)
    begun = time.monotonic()
    with ProcessPoolExecutor(arguments.processes, multiprocessing.get_context("forkserver")) as pool:
        rules = play_games(pool, None, CHOOSING_SEEDS)
        print(f"the rules alone: {rules.mean():.1f} points with the {len(rules)} seeds of the choice", flush=True)
        while (minutes := (time.monotonic() - begun) / 60) < arguments.minutes and training.generation < arguments.generations:
            mean = training.step(pool)
            gain, width = float("nan"), float("nan")
            if training.generation % EVERY == 0:
                gain, width = interval(play_games(pool, training.weights, CHOOSING_SEEDS) - rules)
                if training.best is None or gain > training.best:
                    training.best = gain
                    (training.folder / "best.json").write_text(LinearPolicy.of_vector(training.weights.round(4)).to_json())
            training.save()
            with (training.folder / "curve.csv").open("a") as curve:
                games = training.generation * 2 * training.pairs
                curve.write(f"{training.generation},{games},{minutes:.1f},{mean:.1f},{gain:.1f},{width:.1f}\n")
            told = "" if np.isnan(gain) else f", {gain:+.1f} ± {width:.1f} against the rules"
            print(f"generation {training.generation}: {mean:.1f} points{told} ({minutes:.1f} min)", flush=True)


def evaluate(arguments: argparse.Namespace) -> None:
    first, last = (int(part) for part in arguments.seeds.split(".."))
    seeds = range(first, last + 1)
    weights = LinearPolicy.load(arguments.policy).vector()
    with ProcessPoolExecutor(arguments.processes, multiprocessing.get_context("forkserver")) as pool:
        rules = play_games(pool, None, seeds)
        learned = play_games(pool, weights, seeds)
    gain, width = interval(learned - rules)
    print(f"{len(seeds)} games: rules {rules.mean():.1f}, policy {learned.mean():.1f} points; difference {gain:+.1f} ± {width:.1f} (95 %)")
    if arguments.csv:
        rows = [f"{seed},{one:.0f},{other:.0f}" for seed, one, other in zip(seeds, rules, learned, strict=True)]
        Path(arguments.csv).write_text("\n".join(["seed,rules,policy", *rows]) + "\n")


def draw(arguments: argparse.Namespace) -> None:
    """An SVG of curve.csv: gain against the rules with the seeds of the choice, with its 95 % interval, over the games played."""
    with open(arguments.curve, encoding="utf-8") as text:
        rows = [row for row in csv.DictReader(text) if row["choosing_gain"] != "nan"]
    if not rows:
        raise SystemExit(f"{arguments.curve}: no generation has been compared with the rules yet")
    games, gain, width = (np.array([float(row[key]) for row in rows]) for key in ("games", "choosing_gain", "half_width"))
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
        if name == "train":
            command.add_argument("--out", default="training", help="folder of the training (training)")
            command.add_argument("--minutes", type=float, default=90, help="ends after so many minutes (90)")
            command.add_argument("--generations", type=int, default=1000, help="ends after so many generations (1000)")
            command.add_argument("--pairs", type=int, default=64, help="pairs of games in a generation (64)")
            command.add_argument("--seed", type=int, default=1, help="of the perturbations (1)")
        elif name == "draw":
            command.add_argument("curve", help="curve.csv of a training")
            command.add_argument("svg", help="the picture")
        else:
            command.add_argument("policy", help="weights (JSON)")
            command.add_argument("--seeds", default="30001..30200", help="FIRST..LAST, seeds that the training has not seen")
            command.add_argument("--csv", help="writes the points of each game there")
    arguments = parser.parse_args()
    arguments.does(arguments)


if __name__ == "__main__":
    main()
