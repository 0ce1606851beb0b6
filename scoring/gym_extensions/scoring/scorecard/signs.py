"""Signs of trouble in a submission's logs, as notes for a reader to judge. None of them is a verdict."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.submission import SubmittedGroup
from gym_extensions.scoring.scorecard.sketches import episode_sketches, is_common

CURVE_RANGES = 0.5
"""Ranges of a training curve above its maximum from which a mean return is far above the curve. The largest
of the 210 curves of November 2026 with sampled actions is 0.16."""


def signs(entry: SubmittedGroup, is_sampled: bool) -> tuple[str, ...]:
    """One sentence per kind of sign and log of a group that has no problem.

    Training curves are compared only where evaluation samples its actions, as training does: a deterministic
    policy does without the noise of its training curve. Outliers within a cell are not reported: where most
    episodes end alike and a few last longer, honest cells have outliers of fifty interquartile ranges, and
    the audit sample contains the largest return of most cells anyway.

    Args:
        entry: the group's logs and curves.
        is_sampled: whether actions are sampled in evaluation.
    """
    return tuple(
        f"{entry.group.id}, {protocol}: {text}"
        for protocol, log in entry.logs.items()
        for text in (
            *_identical_lengths(log),
            *_shared_episodes(log),
            *(_above_curves(entry, log) if is_sampled else ()),
        )
    )


def _cells(column: NDArray[np.generic]) -> NDArray[np.float64]:
    """The column with one row per cell and one column per episode."""
    return np.asarray(column, dtype=np.float64).reshape(-1, EVALUATION_EPISODES)


def _identical_lengths(log: Log) -> Iterator[str]:
    lengths = _cells(log.length)
    limits = np.array([task.max_steps for task in log.group.tasks])[_cells(log.position)[:, 0].astype(int)]
    count = int(np.sum(np.all(lengths == lengths[:, :1], axis=1) & (lengths[:, 0] < limits)))
    if count:
        yield (
            f"In {count} of {len(lengths)} cells, all {EVALUATION_EPISODES} episodes have the same length, "
            "which is below the time limit."
        )


def _shared_episodes(log: Log) -> Iterator[str]:
    sketches = episode_sketches(log)
    count = sum(
        any(is_common(sketch, other) for other in sketches[:index]) for index, sketch in enumerate(sketches)
    )
    if count:
        yield f"{count} of {len(sketches)} runs share most of their last episodes with an earlier run."


def _above_curves(entry: SubmittedGroup, log: Log) -> Iterator[str]:
    """Compares the mean return right after the training on a task with the training curve of that task."""
    if entry.curves is None:
        return
    curves = {
        (run, task): entry.curves.return_[start:stop]
        for (protocol, run, task), start, stop in entry.curves.blocks
        if protocol == log.protocol
    }
    ids = entry.group.task_ids
    count = 0
    means = _cells(log.return_).mean(axis=1)
    keys = (_cells(column)[:, 0].astype(int) for column in (log.run, log.stage, log.position))
    for run, stage, position, mean in zip(*keys, means, strict=True):
        curve = curves.get((int(run), ids[position]))
        trained_last = stage == position + 1 if log.protocol == "sequential" else True
        if curve is not None and trained_last and curve.size:
            count += bool(mean > curve.max() + CURVE_RANGES * (curve.max() - curve.min()))
    if count:
        yield (
            f"In {count} of {len(curves)} cells right after training, the mean return is far above the "
            "training curve."
        )
