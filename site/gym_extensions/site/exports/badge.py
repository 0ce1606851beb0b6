"""A badge that shows the final performance of an entry, as an SVG file for other pages."""

from __future__ import annotations

from markupsafe import escape

from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.text.numbers import fixed
from gym_extensions.site.views.board_row import COLUMNS
from gym_extensions.site.views.trial import group_trials, suite_trials

NAME = "gym-extensions"
CHARACTER, PADDING, HEIGHT = 6.6, 8, 20
"""Width of a character at 11 px, space beside each text, and height, in px."""


def badge(card: Scorecard) -> str:
    """The badge of an entry: its first score, suites before groups, or that it has none."""
    return _svg(NAME, _score(card))


def _score(card: Scorecard) -> str:
    if card.problems:
        return "refused"
    for trial in (*suite_trials(card), *group_trials(card)):
        value = trial.metric(COLUMNS[trial.protocol][0])
        if value.mean is not None:
            half = "" if value.ends is None else f" ± {fixed((value.ends[1] - value.ends[0]) / 2)}"
            return f"{trial.group} {fixed(value.mean)}{half}"
    return "no score"


def _svg(left: str, right: str) -> str:
    first, second = (round(len(text) * CHARACTER + 2 * PADDING) for text in (left, right))
    label = escape(f"{left}: {right}")
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{first + second}" height="{HEIGHT}" role="img" '
        f'aria-label="{label}"><title>{label}</title><rect width="{first + second}" height="{HEIGHT}" rx="3" '
        f'fill="#0b5a8f"/><path d="M3 0h{first - 3}v{HEIGHT}H3a3 3 0 0 1-3-3V3a3 3 0 0 1 3-3" '
        'fill="#3b4148"/>'
        f'<g fill="#fff" font-family="Verdana,DejaVu Sans,sans-serif" font-size="11" text-anchor="middle">'
        f'<text x="{first / 2:g}" y="14" textLength="{first - 2 * PADDING}">{escape(left)}</text>'
        f'<text x="{first + second / 2:g}" y="14" textLength="{second - 2 * PADDING}">{escape(right)}</text>'
        "</g></svg>\n"
    )
