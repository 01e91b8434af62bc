#!/usr/bin/env python3
"""How fast games are played whose choices are made from Python: decisions and games a second, and the time of a reset.

    PYTHONPATH=build/release/python benchmarks/learning.py [--games 40] [--processes 2] [--threads 2] [--interval 1] [--envs 16]

With `--interval` the rules ask for an order each time so many seconds have passed, also where none can begin. `choices` counts the decisions that
have more than one option. `games` plays them one after the other in each process (cxlab.learn.play_all), which is how train_dispatcher.py trains; `vector` is the
vector environment of the package with so many environments in `--threads`, `async` gymnasium.vector.AsyncVectorEnv with an environment a process (both only
where Gymnasium is installed). All take the option that the rules prefer, and no journal is kept. Each game is a whole one of the timed tier.
"""

import argparse
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
from cxlab.learn import play
from cxlab.learn.games import Games, at_interval, shown_options


class Counting:
    """The rules' choices, counted."""

    def __init__(self):
        self.decisions = self.choices = 0

    def __call__(self, choice):
        self.decisions += 1
        self.choices += sum(choice.allowed) > 1
        return choice.preferred


def play_one(task):
    seed, interval = task
    policy = Counting()
    begun = time.process_time()
    play(policy, seed, **({} if interval is None else {"set": at_interval(interval)}))
    return policy.decisions, policy.choices, time.process_time() - begun


def action_of(games):
    return int(np.flatnonzero(shown_options(games.choice) == games.choice.preferred)[0])


def reset_times(games, interval):
    """Times to reset environments whose next game is made ready while one is played, ms."""
    env = Games("rcll/external", team="CYAN", ahead=True, tier="timed", journal="none", interval=interval)
    times = []
    for seed in range(1, games + 2):
        begun = time.perf_counter()
        env.begin(seed, seed + 1 if seed <= games else None)
        times.append(1e3 * (time.perf_counter() - begun))
        while env.choice is not None:
            env.answer(action_of(env))
        env.result()
    env.close()
    return times[0], np.array(times[1:])


def vector(env, games):
    """Decisions and games a second of a vector environment until so many games have ended."""
    count = env.num_envs
    _, info = env.reset(seed=list(range(1, count + 1)))
    done = decisions = 0
    over, begun = np.zeros(count, dtype=bool), time.perf_counter()
    while done < games:
        preferred = info.get("preferred", np.zeros(count, dtype=int))
        decisions += count - int(over.sum())  # an environment whose game has ended begins the next one
        _, _, terminated, truncated, info = env.step(preferred)
        over = terminated | truncated
        done += int(over.sum())
    seconds = time.perf_counter() - begun
    env.close()
    return decisions / seconds, done / seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--games", type=int, default=40)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--threads", type=int, default=2, help="of the vector")
    parser.add_argument("--interval", type=float)
    parser.add_argument("--envs", type=int, nargs="*", default=[16], help="environments of the vector")
    arguments = parser.parse_args()
    tasks = [(seed, arguments.interval) for seed in range(1, arguments.games + 1)]
    with ProcessPoolExecutor(arguments.processes, get_context("forkserver")) as pool:
        list(pool.map(play_one, tasks[: arguments.processes]))  # the processes are there
        begun = time.perf_counter()
        decisions, choices, cpu = np.array(list(pool.map(play_one, tasks))).T
        seconds = time.perf_counter() - begun
    print(f"games    {sum(decisions) / seconds:8.0f} decisions/s {arguments.games / seconds:6.2f} games/s in {arguments.processes} processes; "
          f"{np.mean(decisions):.0f} decisions, {np.mean(choices):.0f} choices and {1e3 * np.mean(cpu):.0f} ms of the processor a game")
    first, others = reset_times(min(arguments.games, 20), arguments.interval)
    print(f"reset    {np.median(others):8.2f} ms median, {others.max():.2f} ms at most; {first:.0f} ms for the first game")
    try:
        import gymnasium
        from cxlab.learn.registration import register
    except ImportError:
        print("vector   Gymnasium is not installed")
        return
    register()
    name, settings = "cxlab/RCLLDispatch-v0", {"journal": "none", "interval": arguments.interval}
    for envs in arguments.envs:
        made = gymnasium.make_vec(name, envs, threads=arguments.threads, **settings)
        rate, games = vector(made, max(arguments.games, 2 * envs))
        print(f"vector   {rate:8.0f} decisions/s {games:6.2f} games/s with {envs} environments in {arguments.threads} threads")
    made = gymnasium.vector.AsyncVectorEnv([lambda: gymnasium.make(name, **settings)] * arguments.processes, shared_memory=True)
    rate, games = vector(made, arguments.games)
    print(f"async    {rate:8.0f} decisions/s {games:6.2f} games/s with AsyncVectorEnv of {arguments.processes}")


if __name__ == "__main__":
    main()
