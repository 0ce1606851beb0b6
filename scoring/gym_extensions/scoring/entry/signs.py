"""Sketches by which boards recognize copies, and signs of trouble in logs, as notes for a reader to judge."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.rollouts.log import Log
from gym_extensions.rollouts.submission import SubmittedGroup

SIZE = 16
"""Digests per run: the smallest of those of all its last episodes (a bottom-k sketch)."""
SIGNIFICANT_DIGITS = 5
"""Digits of a return that count, so that little noise changes few digests."""

SHARE = 0.5
"""Least share of common episodes of two runs, and of such runs of an entry, that makes it a duplicate."""

Sketch = tuple[str, ...]


def run_sketches(entry: SubmittedGroup, protocol: str) -> tuple[Sketch, ...]:
    """What two equal runs have in common: the sketch of the last episodes of each run of a log.

    In navigation, returns are whole numbers, and different agents that stand still have equal episodes.
    Episodes cannot show a copy there. A run's sketch is the digest of its policies instead, and is empty
    without them.
    """
    log = entry.logs[protocol]
    if any(task.body.family != "navigation" for task in entry.group.tasks):
        return episode_sketches(log)
    policies = [entry.runs[protocol][run].policies for run in log.runs]
    return tuple((each.sha256,) if each else () for each in policies)


def episode_sketches(log: Log) -> tuple[Sketch, ...]:
    """The sketch of each run: the 16 smallest digests of its episodes after the last stage, sorted.

    An episode's digest is the first eight hexadecimal digits of the SHA-256 of its task's index, number,
    length, return (five significant digits) and end. The share of common digests of two sketches estimates
    the share of common episodes, whatever else differs in the two runs.

    Source: E. Cohen and H. Kaplan, Summarizing data using bottom-k sketches, PODC 2007.
    """
    digests: dict[int, set[str]] = {run: set() for run in log.runs}
    last = log.stage == log.stage.max(initial=0)
    columns = (log.run, log.position, log.episode, log.length, log.return_, log.terminated)
    for run, *key, return_, terminated in zip(*(column[last].tolist() for column in columns), strict=True):
        episode = (*key, f"{return_:.{SIGNIFICANT_DIGITS - 1}e}", terminated)
        digests[run].add(hashlib.sha256(repr(episode).encode()).hexdigest()[:8])
    return tuple(tuple(sorted(digests[run])[:SIZE]) for run in log.runs)


def is_common(first: Sketch, second: Sketch) -> bool:
    """Whether two runs share at least half of their episodes, as estimated from their sketches."""
    union = sorted({*first, *second})[:SIZE]
    return bool(union) and len({*first} & {*second} & {*union}) >= SHARE * len(union)


CURVE_RANGES = 0.5
"""Ranges of a training curve above its maximum from which a mean return is far above the curve. The largest
of the 210 curves of November 2026 with sampled actions is 0.16."""


def signs(entry: SubmittedGroup, is_sampled: bool) -> tuple[str, ...]:
    """One sentence per kind of sign and log of a group that has no problem.

    Training curves are compared only where evaluation samples its actions, as training does: a deterministic
    policy does without the noise of its training curve. Outliers within a cell are not reported: where most
    episodes end alike and a few last longer, honest cells have outliers of fifty interquartile ranges.

    Args:
        entry: the group's logs and curves.
        is_sampled: whether actions are sampled in evaluation.
    """
    return tuple(
        f"{entry.group.id}, {protocol}: {text}"
        for protocol, log in entry.logs.items()
        for text in (
            *_identical_lengths(log),
            *_shared_episodes(run_sketches(entry, protocol)),
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


def _shared_episodes(sketches: Sequence[Sketch]) -> Iterator[str]:
    count = sum(
        any(is_common(sketch, other) for other in sketches[:index]) for index, sketch in enumerate(sketches)
    )
    if count:
        yield f"{count} of {len(sketches)} runs share most of their last episodes with an earlier run."


def _above_curves(entry: SubmittedGroup, log: Log) -> Iterator[str]:
    """Compares the mean return right after the training on a task with the training curve of that task."""
    curves = {
        (run, curve.task): np.array(curve.returns)
        for run, document in entry.runs[log.protocol].items()
        for curve in document.curves
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
