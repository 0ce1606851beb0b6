"""Performance profiles: the share of runs and tasks that score above each value.

Source: Agarwal et al., Deep RL at the Edge of the Statistical Precipice, NeurIPS 2021.
"""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup, escape

from gym_extensions.site.charts.svg import Scale, picture, points, stroke, text, tick_label
from gym_extensions.site.charts.task_curves import Line
from gym_extensions.site.submission_results import Points, SubmissionResult

X, Y = (40.0, 372.0), (164.0, 24.0)
"""Left and right, bottom and top."""
DESCRIBED = (0.0, 0.5, 1.0, 2.0)
"""The scores whose shares the description names, where the profile has them."""


def describe(profile: Points) -> str:
    """The profile in words, for example ``above 0: 100 %, above 0.5: 60 %``."""
    shares = dict(profile)
    return ", ".join(
        f"above {tick_label(at)}: {100 * shares[at]:.0f}\u202f%" for at in DESCRIBED if at in shares
    )


def of_result(result: SubmissionResult) -> Markup:
    """The profile of one submission on one group; empty without a profile."""
    return _chart([("p1", "", result.profile)], describe(result.profile)) if result.profile else Markup("")


def of_board(lines: Sequence[Line]) -> Markup:
    """All lines on one scale; the board's first submission is drawn last, above the others."""
    titled = [(line.kind, line.row.submission.title, line.row.result.profile) for line in lines]
    return _chart(titled, "; ".join(f"{title}: {describe(profile)}" for _, title, profile in titled))


def _chart(lines: Sequence[tuple[str, str, Points]], label: str) -> Markup:
    """The profiles: class, title and points of each."""
    first, last = lines[0][2][0][0], max(profile[-1][0] for _, _, profile in lines)
    x, y = Scale(first, last, *X), Scale(0.0, 1.0, *Y)
    body = [stroke(x.start, y.at(share), x.end, y.at(share), "level") for share in (0.0, 0.5, 1.0)]
    body += [text("tick side", x.start - 5, y.at(at / 100) + 3, f"{at}\u202f%") for at in (0, 50, 100)]
    body += [
        stroke(x.at(score), y.start, x.at(score), y.end, f"grid {name}")
        for score, name in ((0.0, "floor"), (1.0, "expert"))
    ]
    body += [
        text(f"tick{' key' if score in {0, 1} else ''}", x.at(score), y.start + 14, tick_label(score))
        for score in x.ticks()
    ]
    body.append(text("tick name", 0, 10, "share of runs and tasks above the score"))
    body.append(text("tick side", x.end, y.start + 29, "normalized score at the end"))
    for kind, title, profile in reversed(lines):
        named = f"<title>{escape(title)}</title>" if title else ""
        # Points between two others of the same share are left out.
        inner = range(1, len(profile) - 1)
        level = {at for at in inner if profile[at - 1][1] == profile[at][1] == profile[at + 1][1]}
        through = points([point for at, point in enumerate(profile) if at not in level], x, y)
        body.append(f'<polyline class="line {kind}" points="{through}">{named}</polyline>')
    return picture("profile", "384", "196", label, "".join(body))
