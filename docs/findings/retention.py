"""What the figure of retention shows: the groups in it, and scores in place of returns."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from gym_extensions.scoring.references import Reference
from gym_extensions.scoring.statistics import Interval

PANELS = 4


def most_forgotten(forgetting: Mapping[str, Interval]) -> list[str]:
    """Up to ``PANELS`` groups whose intervals of forgetting lie farthest above 0, in the given order."""
    lows = {name: each.low for name, each in forgetting.items() if each.low is not None and each.low > 0}
    chosen = sorted(lows, key=lambda name: -lows[name])[:PANELS]
    return [name for name in forgetting if name in chosen]


def as_scores(frame: pd.DataFrame, references: Mapping[str, Reference]) -> pd.DataFrame:
    """Evaluations with scores in the column ``return``, without the tasks that have none."""
    scored = {name: each for name, each in references.items() if not each.open}
    frame = frame[frame["task"].isin(scored)]
    scores = [
        scored[task].normalize(value) for task, value in zip(frame["task"], frame["return"], strict=True)
    ]
    return frame.assign(**{"return": scores})
