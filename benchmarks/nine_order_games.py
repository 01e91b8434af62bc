#!/usr/bin/env python3
"""Writes games of nine orders for a production of 1,020 s, as files that `world.game` and `games:` of a suite take.

    benchmarks/nine_order_games.py CXLAB FOLDER FIRST LAST

For each seed it takes the game that `cxlab new game` draws, without one of its eight orders with a window. A window that would end after
1,020 s ends then. If it lasts the whole game, it is cut. Any other one moves, and its order is released 60 s before it at the latest. A
down period that ends later is left out. The league's games of 2021 had nine orders and 1,020 s.
"""
import pathlib
import re
import subprocess
import sys

PRODUCTION = 1020
RELEASED_BEFORE = 60


def blocks(lines):
    """The entries of a list in YAML, each a list of lines."""
    found = []
    for line in lines:
        if line.lstrip().startswith("- ") and ":" in line and len(line) - len(line.lstrip()) <= 2:
            found.append([line])
        else:
            found[-1].append(line)
    return found


def number(block, key):
    return float(re.search(rf"^\s*(?:- )?{key}: (\S+)$", "\n".join(block), re.M)[1])


def with_number(block, key, value):
    return [re.sub(rf"^(\s*(?:- )?{key}: ).*$", rf"\g<1>{value:g}", line) for line in block]


def cut_order(block):
    begin, end = number(block, "delivery_begin"), number(block, "delivery_end")
    if end <= PRODUCTION:
        return block
    if begin > 0:
        begin -= end - PRODUCTION
    active = min(number(block, "activate_at"), max(0, begin - RELEASED_BEFORE))
    for key, value in (("activate_at", active), ("delivery_begin", begin), ("delivery_end", PRODUCTION)):
        block = with_number(block, key, value)
    return block


def cut_game(text, seed):
    sections = {}
    for line in text.splitlines():
        if line and not line.startswith((" ", "-")):
            name = line
            sections[name] = []
        elif line:
            sections[name].append(line)
    out = []
    for name, lines in sections.items():
        if name.startswith("overtime"):
            continue  # drawn for the end of production
        if name == "orders:":
            orders = blocks(lines)
            del orders[2 + seed % (len(orders) - 2)]
            lines = [line for order in orders for line in cut_order(order)]
        if name == "down:":
            lines = [line for period in blocks(lines) if number(period, "end_s") < PRODUCTION for line in period]
            name = name if lines else "down: []"
        out += [name, *lines]
    return "\n".join(out) + "\n"


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    program, folder, first, last = sys.argv[1], pathlib.Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
    folder.mkdir(parents=True, exist_ok=True)
    for seed in range(first, last + 1):
        file = folder / f"g{seed}.yaml"
        subprocess.run([program, "new", "game", file, "--seed", str(seed), "--force"], check=True, stdout=subprocess.DEVNULL)
        file.write_text(cut_game(file.read_text(), seed))


if __name__ == "__main__":
    main()
