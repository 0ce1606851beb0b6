"""Performance profiles, drawn: the share of runs and tasks above each score, of one entry or of a board."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

from gym_extensions.site.charts.scale import Axis
from gym_extensions.site.charts.svg import points, px, stroke, tick
from gym_extensions.site.views.board_row import Row
from gym_extensions.site.views.trial import Points, Trial

X = (40.0, 372.0)
Y = (164.0, 24.0)
WIDTH, HEIGHT = 384, 196
TOLD = (0.0, 0.5, 1.0, 2.0)
"""The scores whose shares are said in words."""
APART = 6
"""Lines that the style sheet tells apart by colour and dashes; further ones share a grey."""


@dataclass(frozen=True)
class Line:
    """One entry's profile: its class in the style sheet, its title, its interquartile mean."""

    kind: str
    title: str
    iqm: float | None
    profile: Points

    @property
    def sample(self) -> Markup:
        """A piece of the line, to stand by the title."""
        inside = stroke(0, 4, 26, 4, f"line {self.kind}")
        return Markup(f'<svg class="sample" viewBox="0 0 26 8" aria-hidden="true">{inside}</svg>')


def said(profile: Points) -> str:
    """The profile in words, for example ``above 0: 100 %, above 0.5: 60 %``."""
    shares = dict(profile)
    return ", ".join(f"above {tick(at)}: {_percent(shares[at])}" for at in TOLD if at in shares)


def of_trial(trial: Trial) -> Markup:
    """The profile of one entry on one group; nothing where the document has none."""
    if not trial.profile:
        return Markup("")
    return _drawn([Line("p1", "", trial.iqm, trial.profile)], said(trial.profile))


def lines(rows: Sequence[Row]) -> list[Line]:
    """The lines of a board's entries that have a profile, from top to bottom."""
    having = [row for row in rows if row.trial.profile]
    return [
        Line(f"p{place if place <= APART else 0}", row.entry.title, row.trial.iqm, row.trial.profile)
        for place, row in enumerate(having, 1)
    ]


def of_board(found: Sequence[Line]) -> Markup:
    """All lines on one scale, the board's first entry uppermost."""
    return _drawn(found, "; ".join(f"{line.title}: {said(line.profile)}" for line in found))


def _drawn(found: Sequence[Line], label: str) -> Markup:
    first, last = found[0].profile[0][0], found[0].profile[-1][0]
    x, y = Axis(first, last, *X), Axis(0.0, 1.0, *Y)
    inside = [stroke(x.start, y.at(share), x.end, y.at(share), "level") for share in (0.0, 0.5, 1.0)]
    inside += [_text("tick side", x.start - 5, y.at(share) + 3, _percent(share)) for share in (0.0, 0.5, 1.0)]
    inside += [
        stroke(x.at(score), y.start, x.at(score), y.end, f"grid {name}")
        for score, name in ((0.0, "floor"), (1.0, "ceiling"))
    ]
    inside += [
        _text(f"tick{' key' if score in {0, 1} else ''}", x.at(score), y.start + 14, tick(score))
        for score in x.ticks()
    ]
    inside.append(_text("tick name", 0, 10, "share of runs and tasks above the score"))
    inside.append(_text("tick side", x.end, y.start + 29, "score at the end (0 floor, 1 reference)"))
    for line in reversed(found):
        title = f"<title>{escape(line.title)}</title>" if line.title else ""
        drawn = points(_corners(line.profile), x, y)
        inside.append(f'<polyline class="line {line.kind}" points="{drawn}">{title}</polyline>')
    return Markup(
        f'<svg class="profile" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'aria-label="{escape(label)}">{"".join(inside)}</svg>'
    )


def _corners(profile: Points) -> list[tuple[float, float]]:
    """The points without those that lie on a level between two others."""
    inner = range(1, len(profile) - 1)
    level = {at for at in inner if profile[at - 1][1] == profile[at][1] == profile[at + 1][1]}
    return [point for at, point in enumerate(profile) if at not in level]


def _percent(share: float) -> str:
    return f"{100 * share:.0f}\u202f%"


def _text(kind: str, x: float, y: float, words: str) -> str:
    return f'<text class="{kind}" x="{px(x)}" y="{px(y)}">{words}</text>'
