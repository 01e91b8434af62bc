#!/usr/bin/env python3
"""How long each part of the build took: seconds of its commands, from ninja's log.

    CCACHE_DISABLE=1 bash -c 'time ./dev run --until 1'     # in a fresh clone
    benchmarks/build.py [build/release/.ninja_log]

A part is a folder of the sources, without the rest of its path. The seconds are those of the wall clock, which are those
of the processor where nothing else runs. A command that made several files counts once, and of one that ran more than
once the last time counts.
"""

import collections
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
DEEP = ("cx", "scenarios", "sim", "planner", "third_party")  # folders whose subfolders are parts


def part_of(output):
    """cx/engine of cx/engine/CMakeFiles/...; the program and its libraries, which are linked, are `link`."""
    path = pathlib.PurePath(output)
    if path.is_absolute():
        build = next((parent for parent in path.parents if parent.parent.name == "build"), path.parent)
        path = path.relative_to(build)
    if path.suffix in (".so", ".a", "") or ".so." in path.name:
        return "link"
    if path.parts[0] == "CMakeFiles":
        return "cmake"
    deep = path.parts[0] in DEEP and path.parts[1] != "CMakeFiles"
    return "/".join(path.parts[:2]) if deep else path.parts[0]


def main():
    log = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/.ninja_log")
    if not log.exists():
        sys.exit(f"{log}: there is no log of a build; build first: ./dev run --until 1")
    commands = {}  # (begin, end, hash of the command): output
    for line in log.read_text().splitlines():
        if not line.startswith("#"):
            begin, end, _, output, command = line.split("\t")
            commands[output] = (int(begin), int(end), command)
    seconds, files, seen = collections.Counter(), collections.Counter(), set()
    for output, command in commands.items():
        if command in seen:
            continue
        seen.add(command)
        seconds[part_of(output)] += (command[1] - command[0]) / 1000
        files[part_of(output)] += 1
    for part, s in seconds.most_common():
        print(f"{part:28} {s:7.1f} s  {files[part]:4} commands")
    print(f"{'all':28} {sum(seconds.values()):7.1f} s  {sum(files.values()):4} commands")


if __name__ == "__main__":
    main()
