"""What was lost most: told as `score` tells it, and only where it is more than chance."""

from __future__ import annotations

import pytest

from gym_extensions.scoring.scorecard.highlights import highlights
from gym_extensions.site.charts.small_multiples import most_lost
from gym_extensions.site.views.trial import group_trials

from .conftest import sequential, submission
from .reading import typed

REFERENCES = {"version": "made-up", "provisional": False, "sha256": ""}


def matrix(*losses: float) -> list[list[float]]:
    """One run: each of the five tasks is worth 900 after its training and has lost so much at the end."""
    lost = (*losses, *[0.0] * (5 - len(losses)))
    stages = [[900.0 if task < stage else 0.0 for task in range(5)] for stage in range(6)]
    return [*stages[:5], [900.0 - loss for loss in lost]]


@pytest.mark.parametrize(
    ("runs", "place"),
    [
        ([matrix(300, 100), matrix(320, 120), matrix(310, 90)], 0),
        ([matrix(100, 300)], 1),
        # 300, 0 and 600: the mean, 300, ± 4.303 · 300 / √3 = 745 reaches far below 0; 100, 110, 90 does not.
        ([matrix(300, 100), matrix(0, 110), matrix(600, 90)], 1),
        ([matrix(300), matrix(0), matrix(600)], None),
        ([matrix(-300), matrix(-310), matrix(-305)], None),
    ],
)
def test_the_task_that_lost_most_is_the_one_that_score_names(
    runs: list[list[list[float]]], place: int | None
) -> None:
    scores = sequential("hopper-gravity", runs)
    card = submission("agile", {"hopper-gravity-v0": {"sequential": scores}})
    (entry,) = typed({"format": 1, "references": REFERENCES, "submissions": [card]}).submissions
    (trial,) = group_trials(entry)
    task = None if place is None else scores["tasks"][place]
    lost = most_lost(trial)
    assert (lost.task if lost else None) == task
    name = "" if task is None else task.rsplit("/", 1)[-1].removesuffix("-v0")
    said = [
        sentence.split()[1]
        for sentence in highlights(entry.groups["hopper-gravity-v0"]["sequential"])
        if sentence.startswith("forgets")
    ]
    assert said == ([name] if name else [])
