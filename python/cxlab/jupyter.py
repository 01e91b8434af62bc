"""HTML that notebooks show for runs, answers and sweeps. All texts of runs are escaped in it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

from cxlab.errors import CxlabError

if TYPE_CHECKING:
    from cxlab.run import Answer, Run
    from cxlab.sweep import Comparison, Sweep

# Light and dark notebooks show both of them.
_COLOURS = ("#0a8ea0", "#c2378f", "#b8860b", "#4a7a2c", "#6a5acd", "#a0522d")
_WIDTH, _LEFT, _LANE, _CURVE = 720, 90, 16, 90
_MOST_DRAWN = 3000


def text_html(text: str) -> str:
    return f'<pre style="white-space: pre-wrap">{escape(text)}</pre>'


def link_html(url: str) -> str:
    return f'<a href="{escape(url, quote=True)}" target="_blank" rel="noopener">{escape(url.split("?")[0])}</a>'


def table_html(table: Any) -> str:
    """A data frame as its own package shows it, which escapes its cells; else as text."""
    show = getattr(table, "_repr_html_", None)
    return str(show()) if show else text_html(str(table))


def answer_html(answer: Answer) -> str:
    notes = "".join(f"<p>{escape(note)}</p>" for note in answer.notes)
    return "".join(f"<h4>{escape(key)}</h4>{table_html(answer[key])}" for key in answer) + notes


def comparison_html(comparison: Comparison) -> str:
    notes = "".join(f"<p>{escape(note)}</p>" for note in comparison.notes)
    return f"<p><b>{escape(comparison.answer)}</b></p>{table_html(comparison.differences)}{notes}"


def sweep_html(sweep: Sweep) -> str:
    return (
        f"<p><b>{escape(str(sweep.folder))}</b></p>{table_html(sweep.scores)}"
        f"<p>differences in the same games</p>{table_html(sweep.differences)}"
    )


def run_html(run: Run) -> str:
    """A card with how the run ended, and below it the skills and the points along its time."""
    result = run.result
    reason = result.get("reason") or {}
    facts = [
        ("scenario", result.get("scenario")),
        ("seed", result.get("seed")),
        ("tier", result.get("tier")),
        ("status", result.get("status")),
        ("why", reason.get("message")),
        ("simulated", f"{result['sim_time_s']:g} s" if "sim_time_s" in result else None),
        *((f"points of {name}", team.get("points")) for name, team in (result.get("teams") or {}).items()),
        ("errors of rules", len(result.get("rule_errors") or ()) or None),
        ("warnings", len(result.get("warnings") or ()) or None),
    ]
    cells = "".join(
        f'<tr style="text-align: left"><th>{escape(name)}</th><td>{escape(str(value))}</td></tr>'
        for name, value in facts
        if value is not None
    )
    return f"<div><b>{escape(str(run.folder))}</b><table>{cells}</table>{_timeline(run)}</div>"


def _timeline(run: Run) -> str:
    """Skills and points as SVG; nothing where the run has no journal, or no package for tables is installed."""
    try:
        skills, points = (table.to_pylist() for table in run.arrow._story())
    except CxlabError:
        return ""
    ends = [skill["end_s"] for skill in skills if skill["end_s"] is not None]
    end = max([run.result.get("sim_time_s") or 0.0, *ends, *(given["t_s"] for given in points)])
    if end <= 0 or not (skills or points):
        return ""

    def x(seconds: float) -> float:
        return float(round(_LEFT + (_WIDTH - _LEFT - 50) * seconds / end, 1))

    parts: list[str] = []
    robots = list(dict.fromkeys(skill["robot"] for skill in skills))
    kinds = list(dict.fromkeys(skill["skill"] for skill in skills))
    for lane, robot in enumerate(robots):
        parts.append(_label(0, lane * _LANE + 12, robot))
    for skill in skills[:_MOST_DRAWN]:
        begin, stop = x(skill["begin_s"]), x(skill["end_s"] if skill["end_s"] is not None else end)
        y, width = robots.index(skill["robot"]) * _LANE + 3, max(1.0, round(stop - begin, 1))
        failed = skill["state"] in ("failed", "refused")
        colour = "#d33" if failed else _COLOURS[kinds.index(skill["skill"]) % len(_COLOURS)]
        title = " ".join(str(skill[key]) for key in ("skill", "target", "state") if skill[key])
        parts.append(
            f'<rect x="{begin}" y="{y}" width="{width}" height="{_LANE - 5}" fill="{colour}">'
            f"<title>{escape(title)}</title></rect>"
        )
    top = len(robots) * _LANE + 8
    height = top + _CURVE + 20
    parts += _curves(points, x, top, end)
    parts += [_label(x(end * share), height - 4, _minutes(end * share)) for share in (0, 0.25, 0.5, 0.75, 1)]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" width="{_WIDTH}" '
        f'style="max-width: 100%; color: inherit">{"".join(parts)}</svg>'
    )


def _curves(points: Sequence[dict[str, Any]], x: Callable[[float], float], top: int, end: float) -> Iterable[str]:
    teams = list(dict.fromkeys(given["team"] for given in points))
    totals = [given["total"] for given in points]
    least, most = min([0, *totals]), max([1, *totals])

    def y(total: float) -> float:
        return float(round(top + _CURVE * (most - total) / (most - least), 1))

    for number, team in enumerate(teams):
        colour = _COLOURS[number % len(_COLOURS)]
        path, total = [f"M{x(0)} {y(0)}"], 0
        for given in points:
            if given["team"] == team:
                total = given["total"]
                path.append(f"H{x(given['t_s'])}V{y(total)}")
        path.append(f"H{x(end)}")
        yield f'<path d="{"".join(path)}" fill="none" stroke="{colour}" stroke-width="2"/>'
        yield _label(0, top + 14 + number * 14, f"{team} {total}", colour)


def _label(x: float, y: float, text: str, colour: str = "currentColor") -> str:
    return f'<text x="{x}" y="{y}" font-size="11" font-family="sans-serif" fill="{colour}">{escape(str(text))}</text>'


def _minutes(seconds: float) -> str:
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"
