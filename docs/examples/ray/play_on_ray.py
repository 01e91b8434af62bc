#!/usr/bin/env python3
"""Plays a sweep of cxlab on a cluster of Ray. The machines need no common folder.

    pip install ray
    play_on_ray.py suite.yaml --out runs/all                          # on this machine
    play_on_ray.py suite.yaml --out runs/all --address auto           # on the cluster that this machine is part of
    play_on_ray.py suite.yaml --out runs/all --address auto --ship .  # files of this folder go to all machines

A task plays some cells with `cxlab bench SUITE --cell A..B` on some machine and returns their rows, a few KB each. They are written into the
folder of --out as they come, and collected at the end. What a machine was playing that fails is played on another one. After whatever ends
this program the same command goes on: only cells without a row that counts are played.

With --ship DIR Ray copies DIR, in which the suite and all files that it names must lie, to each machine, and cells are played from there.
Without it each machine must have these files at the same path. Each machine must have the same build of cxlab; --cxlab names it, as a
path below DIR if it is shipped as well.
"""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile


def play_cells(cxlab, suite, first, last, options):
    """The rows of these cells by the names of their files. Runs on a machine of the cluster, in the folder that was shipped, if there is one."""
    with tempfile.TemporaryDirectory(prefix="cxlab-cells-") as folder:
        done = subprocess.run([cxlab, "bench", suite, "--cell", f"{first}..{last}", "--quiet", "--out", folder, *options],
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        rows = {file.name: file.read_bytes() for file in (pathlib.Path(folder) / "rows").glob("*.json")}
    if len(rows) != last - first + 1:  # a game that crashed has a row, too
        raise RuntimeError(f"cells {first}..{last}: {len(rows)} rows, exit code {done.returncode}\n{done.stdout[-2000:]}")
    return rows


def stretches(numbers, most):
    """Ranges of numbers that follow each other, of at most so many."""
    out = []
    for number in numbers:
        if out and number == out[-1][1] + 1 and number - out[-1][0] < most:
            out[-1][1] = number
        else:
            out.append([number, number])
    return out


def write_row(folder, name, row):
    """Whole or not at all."""
    part = folder / f"{name}.part-{os.getpid()}"
    part.write_bytes(row)
    part.rename(folder / name)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("suite", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder of the rows, on this machine")
    parser.add_argument("--address", help="of the cluster, as of ray.init; auto: that of this machine. Default: a new one, of this machine alone")
    parser.add_argument("--cxlab", default="cxlab", help="the program on each machine (default: the one on its PATH)")
    parser.add_argument("--ship", type=pathlib.Path, metavar="DIR", help="a folder that is copied to each machine")
    parser.add_argument("--cells-per-task", type=int, default=10, metavar="N")
    parser.add_argument("--tasks-at-once", type=int, metavar="N", help="that are handed to Ray (default: twice the processors of the cluster)")
    parser.add_argument("--retries", type=int, default=20, help="how often the cells of a machine that failed are played again")
    parser.add_argument("--time-limit", metavar="S", help="as of cxlab bench")
    options = parser.parse_args()

    ship = options.ship and options.ship.resolve()
    suite = options.suite.resolve()
    here = options.cxlab  # the program on this machine
    if ship:
        if not suite.is_relative_to(ship):
            parser.error(f"{suite} is not below {ship}, the folder of --ship; expected a folder with the suite and all that it names")
        there = str(suite.relative_to(ship))
        if (ship / options.cxlab).is_file():
            here = str(ship / options.cxlab)
            options.cxlab = f"./{options.cxlab}"
    else:
        there = str(suite)

    try:
        import ray
    except ModuleNotFoundError:
        sys.exit(f"{sys.executable} has no Ray: pip install ray")
    if shutil.which(here) is None:
        sys.exit(f"there is no program {here}; expected --cxlab with the path of cxlab, or cxlab on the PATH")

    bench = [here, "bench", str(suite)]
    rows = options.out.resolve() / "rows"
    rows.mkdir(parents=True, exist_ok=True)
    listed = subprocess.run([*bench, "--cells", "--missing", "--out", str(options.out)], stdout=subprocess.PIPE, text=True, check=False)
    if listed.returncode != 0:
        return listed.returncode
    todo = stretches([int(line.split("\t")[0]) for line in listed.stdout.splitlines()], options.cells_per_task)

    failed = 0
    if todo:
        ray.init(address=options.address, runtime_env={"working_dir": str(ship)} if ship else None, log_to_driver=False,
                 include_dashboard=False if options.address is None else None)
        # One processor for each task. Ray plays a task again if its machine is lost, but not if the task raises.
        task = ray.remote(num_cpus=1, max_retries=options.retries)(play_cells)
        at_once = options.tasks_at_once or max(2, 2 * int(ray.cluster_resources().get("CPU", 1)))
        limits = ["--time-limit", options.time_limit] if options.time_limit else []
        waiting, next_one, done = {}, iter(todo), 0
        total = sum(last - first + 1 for first, last in todo)
        while True:
            while len(waiting) < at_once and (cells := next(next_one, None)):
                waiting[task.remote(options.cxlab, there, *cells, limits)] = cells
            if not waiting:
                break
            (ended, *_), _ = ray.wait(list(waiting))
            first, last = waiting.pop(ended)
            try:
                for name, row in ray.get(ended).items():
                    write_row(rows, name, row)
                done += last - first + 1
                print(f"{done} of {total} games", file=sys.stderr)
            except ray.exceptions.RayError as error:
                failed += 1
                print(f"cells {first}..{last}: {error}", file=sys.stderr)
        ray.shutdown()
    collected = subprocess.run([*bench, "--collect", str(options.out), "--out", str(options.out)], check=False).returncode
    return collected or (1 if failed else 0)


if __name__ == "__main__":
    sys.exit(main())
