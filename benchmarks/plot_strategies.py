"""Draws a sweep of strategies: for each the mean points with their 95 % interval, and the points of each game.

    cxlab bench benchmarks/strategies.yaml -j 2 --out runs/strategies
    python3 benchmarks/plot_strategies.py runs/strategies/rows.csv benchmarks/strategies.svg
"""

import csv
import html
import math
import pathlib
import statistics
import sys

# Student's t for 95 %, by degrees of freedom from 1 on; beyond them it is close to 1.96 + 2.4 / degrees.
T = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
     2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042]
LEFT, RIGHT, ROW, TOP = 190, 900, 20, 24


def refuse(why):
    print(f"error: {why}", file=sys.stderr)
    sys.exit(3)


def read_rows(path):
    """The rows of the episodes that were played to their end."""
    with open(path, newline="") as file:
        table = csv.DictReader(file)
        rows, columns = list(table), table.fieldnames or []
    lacking = [column for column in ("strategy", "points") if column not in columns]
    if lacking:
        raise ValueError(f"found {'the columns ' + ', '.join(columns) if columns else 'an empty file'}, "
                         f"expected {' and '.join(lacking)}{' among them' if columns else ''}")
    for line, row in enumerate(rows, start=2):
        try:
            if row["points"] and not math.isfinite(float(row["points"])):
                raise ValueError
        except ValueError:
            raise ValueError(f"line {line}: found '{row['points']}' as points, expected a number") from None
    played = [row for row in rows if row["points"] and row.get("exit", "0") == "0"]
    if not played:
        raise ValueError(f"found {len(rows)} rows, and none of a game that was played to its end; expected one at least")
    if len(played) < len(rows):
        print(f"not drawn: {len(rows) - len(played)} of {len(rows)} rows, whose games were not played to their end", file=sys.stderr)
    return played


def interval(points):
    if len(points) < 2:
        return 0
    degrees = len(points) - 1
    t = T[degrees - 1] if degrees <= len(T) else 1.96 + 2.4 / degrees
    return t * statistics.stdev(points) / math.sqrt(len(points))


def drawing(rows):
    strategies = list(dict.fromkeys(row["strategy"] for row in rows))
    bottom = TOP + ROW * len(strategies)
    most = 100 * max(1, math.ceil(max(float(row["points"]) for row in rows) / 100))  # at the right edge

    def x(points):
        return LEFT + (RIGHT - LEFT) * points / most

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {RIGHT + 20} {bottom + 46}" font-family="sans-serif" font-size="12">',
           '<rect width="100%" height="100%" fill="white"/>']
    for points in range(0, most + 1, 100):
        out.append(f'<line x1="{x(points)}" y1="{TOP - 8}" x2="{x(points)}" y2="{bottom}" stroke="#ddd"/>'
                   f'<text x="{x(points)}" y="{bottom + 18}" text-anchor="middle" fill="#555">{points}</text>')
    out.append(f'<text x="{(LEFT + RIGHT) / 2}" y="{bottom + 38}" text-anchor="middle">points of a game: grey each game, '
               'coloured the mean with its 95 % interval</text>')
    for i, strategy in enumerate(strategies):
        points = [float(row["points"]) for row in rows if row["strategy"] == strategy]
        mean, half, y = statistics.mean(points), interval(points), TOP + ROW * i + ROW / 2
        colour = "#c2187f" if strategy == "greedy" else "#0093b8"
        if i == 0:
            out.append(f'<line x1="{x(mean)}" y1="{TOP - 8}" x2="{x(mean)}" y2="{bottom}" stroke="{colour}" stroke-dasharray="4 3"/>')
        out.append(f'<text x="{LEFT - 10}" y="{y + 4}" text-anchor="end">{html.escape(strategy.replace("-", " "))}</text>')
        out += [f'<circle cx="{x(p):.1f}" cy="{y}" r="2.5" fill="#bbb"/>' for p in points]
        out.append(f'<line x1="{x(mean - half):.1f}" y1="{y}" x2="{x(mean + half):.1f}" y2="{y}" stroke="{colour}" stroke-width="3"/>'
                   f'<circle cx="{x(mean):.1f}" cy="{y}" r="4.5" fill="{colour}"/>')
    return "\n".join(out) + "\n</svg>\n"


if __name__ == "__main__":
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        sys.exit(2)
    if pathlib.Path(sys.argv[2]).suffix != ".svg":
        refuse(f"{sys.argv[2]}: the drawing is an SVG, expected a name that ends in .svg")
    try:
        rows = read_rows(sys.argv[1])
        with open(sys.argv[2], "w") as file:
            file.write(drawing(rows))
    except OSError as error:
        refuse(f"{error.filename}: {error.strerror}")
    except (csv.Error, ValueError) as error:
        refuse(f"{sys.argv[1]}: no rows of cxlab bench: {error}")
