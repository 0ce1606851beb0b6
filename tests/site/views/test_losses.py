"""The largest loss is the one that ``score`` reports, and only if it is significant."""

from __future__ import annotations

import pytest

from gym_extensions.scoring.scorecard.highlights import highlights
from gym_extensions.site.views.losses import largest_loss
from gym_extensions.site.views.trial import group_trials

from ..browser import typed
from ..conftest import sequential, submission

REFERENCES = {"version": "made-up", "provisional": False, "sha256": ""}


def matrix(*losses: float) -> list[list[float]]:
    """One run: each of five tasks has the return 900 after its training, and 900 − its loss at the end."""
    padded = (*losses, *[0.0] * (5 - len(losses)))
    stages = [[900.0 if task < stage else 0.0 for task in range(5)] for stage in range(6)]
    return [*stages[:5], [900.0 - loss for loss in padded]]


@pytest.mark.parametrize(
    ("runs", "index"),
    [
        ([matrix(300, 100), matrix(320, 120), matrix(310, 90)], 0),
        ([matrix(100, 300)], 1),
        # 300, 0 and 600: the mean, 300, ± 4.303 · 300 / √3 = 745 reaches far below 0; 100, 110, 90 does not.
        ([matrix(300, 100), matrix(0, 110), matrix(600, 90)], 1),
        ([matrix(300), matrix(0), matrix(600)], None),
        ([matrix(-300), matrix(-310), matrix(-305)], None),
    ],
)
def test_the_task_with_the_largest_loss_is_the_one_that_score_names(
    runs: list[list[list[float]]], index: int | None
) -> None:
    scores = sequential("hopper-gravity", runs)
    card = submission("agile", {"hopper-gravity-v0": {"sequential": scores}})
    (entry,) = typed({"format": 1, "references": REFERENCES, "submissions": [card]}).submissions
    (trial,) = group_trials(entry)
    task = None if index is None else scores["tasks"][index]
    loss = largest_loss(trial)
    assert (loss.task if loss else None) == task
    name = "" if task is None else task.rsplit("/", 1)[-1].removesuffix("-v0")
    reported = [
        sentence.split()[1]
        for sentence in highlights(entry.groups["hopper-gravity-v0"]["sequential"])
        if sentence.startswith("forgets")
    ]
    assert reported == ([name] if name else [])
