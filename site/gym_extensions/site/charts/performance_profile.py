"""Performance profiles: the share of runs and tasks above each score, of one entry or of a board.

After Agarwal et al. (2021), "Deep Reinforcement Learning at the Edge of the Statistical Precipice".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

from markupsafe import Markup, escape

from gym_extensions.site.charts.scale import Scale
from gym_extensions.site.charts.svg import picture, points, stroke, text, tick_label
from gym_extensions.site.views.board_row import Row
from gym_extensions.site.views.trial import Points, Trial

X = (40.0, 372.0)
Y = (164.0, 24.0)
WIDTH, HEIGHT = 384, 196
DESCRIBED = (0.0, 0.5, 1.0, 2.0)
"""The scores whose shares the description names, where the profile has them."""
LINE_STYLES = 6
"""Number of line styles in the style sheet, and of lines in a chart."""


@dataclass(frozen=True)
class Line:
    """One entry's profile: its class in the style sheet, its title and name, its interquartile mean."""

    kind: str
    title: str
    iqm: float | None
    profile: Points
    name: str = ""

    @property
    def sample(self) -> Markup:
        """A piece of the line, for the legend."""
        body = stroke(0, 4, 26, 4, f"line {self.kind}")
        return Markup(f'<svg class="sample" viewBox="0 0 26 8" aria-hidden="true">{body}</svg>')


def describe(profile: Points) -> str:
    """The profile in words, for example ``above 0: 100 %, above 0.5: 60 %``."""
    shares = dict(profile)
    return ", ".join(f"above {tick_label(at)}: {_percent(shares[at])}" for at in DESCRIBED if at in shares)


def of_trial(trial: Trial) -> Markup:
    """The profile of one entry on one group; empty without a profile."""
    if not trial.profile:
        return Markup("")
    return _chart([Line("p1", "", trial.iqm, trial.profile)], describe(trial.profile))


def lines(rows: Sequence[Row]) -> list[Line]:
    """The lines of the first entries that have a profile, from top to bottom."""
    profiled = (row for row in rows if row.trial.profile)
    return [
        Line(f"p{number}", row.entry.title, row.trial.iqm, row.trial.profile, row.entry.name)
        for number, row in enumerate(islice(profiled, LINE_STYLES), 1)
    ]


def of_board(lines: Sequence[Line]) -> Markup:
    """All lines on one scale; the board's first entry is drawn last, above the others."""
    return _chart(lines, "; ".join(f"{line.title}: {describe(line.profile)}" for line in lines))


def _chart(lines: Sequence[Line], label: str) -> Markup:
    first, last = lines[0].profile[0][0], max(line.profile[-1][0] for line in lines)
    x, y = Scale(first, last, *X), Scale(0.0, 1.0, *Y)
    body = [stroke(x.start, y.at(share), x.end, y.at(share), "level") for share in (0.0, 0.5, 1.0)]
    body += [text("tick side", x.start - 5, y.at(share) + 3, _percent(share)) for share in (0.0, 0.5, 1.0)]
    body += [
        stroke(x.at(score), y.start, x.at(score), y.end, f"grid {name}")
        for score, name in ((0.0, "floor"), (1.0, "ceiling"))
    ]
    body += [
        text(f"tick{' key' if score in {0, 1} else ''}", x.at(score), y.start + 14, tick_label(score))
        for score in x.ticks()
    ]
    body.append(text("tick name", 0, 10, "share of runs and tasks above the score"))
    body.append(text("tick side", x.end, y.start + 29, "score at the end (0 floor, 1 reference)"))
    for line in reversed(lines):
        title = f"<title>{escape(line.title)}</title>" if line.title else ""
        through = points(_corners(line.profile), x, y)
        body.append(f'<polyline class="line {line.kind}" points="{through}">{title}</polyline>')
    return picture("profile", str(WIDTH), str(HEIGHT), label, "".join(body))


def _corners(profile: Points) -> list[tuple[float, float]]:
    """The points without those between two others of the same share."""
    inner = range(1, len(profile) - 1)
    level = {at for at in inner if profile[at - 1][1] == profile[at][1] == profile[at + 1][1]}
    return [point for at, point in enumerate(profile) if at not in level]


def _percent(share: float) -> str:
    return f"{100 * share:.0f}\u202f%"
