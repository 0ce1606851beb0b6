"""The returns of all evaluation episodes of a cell as dots on one line, with a ring around one of them."""

from __future__ import annotations

import statistics
from collections.abc import Sequence

from markupsafe import Markup

from gym_extensions.site.charts.scale import Scale, scale_around
from gym_extensions.site.charts.svg import picture, px, stroke, text, tick_label
from gym_extensions.site.motion.watch import Episode
from gym_extensions.site.text.numbers import digits_for, fixed

WIDTH, MARGIN, LINE = 280, 12, 26
TICKS = 4


def episode_dots(episodes: Sequence[Episode]) -> list[Markup]:
    """A picture per episode: the dots of its cell on the scale that all of them share."""
    returns = [value for episode in episodes for value in episode.clip.returns]
    scale = scale_around(returns, MARGIN, WIDTH - MARGIN, always=(0.0,))
    return [_dots(episode, scale) for episode in episodes]


def _dots(episode: Episode, scale: Scale) -> Markup:
    returns, digits = episode.clip.returns, digits_for(episode.clip.returns)
    y = LINE / 2
    parts = [stroke(scale.at(scale.low), y, scale.at(scale.high), y, "level")]
    parts += [text("tick", scale.at(mark), LINE + 8, tick_label(mark)) for mark in scale.ticks(TICKS)]
    dots = "".join(f"M{scale.at(value):.0f} {y:.0f}h0" for value in returns)
    parts.append(f'<path class="episodes" d="{dots}"/>')
    mean = statistics.fmean(returns)
    parts.append(stroke(scale.at(mean), y - 9, scale.at(mean), y + 9, "cell-mean"))
    parts.append(f'<circle class="shown" cx="{px(scale.at(episode.return_))}" cy="{px(y)}" r="5.5"/>')
    label = (
        f"Returns of the {len(returns)} episodes: mean {fixed(mean, digits)}, "
        f"from {fixed(min(returns), digits)} to {fixed(max(returns), digits)}; "
        f"the episode shown has {fixed(episode.return_, digits)}"
    )
    return picture("dots", str(WIDTH), str(LINE + 12), label, "".join(parts))
