"""Sketches by which boards recognize copies, and signs of trouble in logs, as notes for a reader to judge."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

import numpy as np

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
    last = log.rows[log.rows["stage"] == log.rows["stage"].max()]
    columns = ("run", "position", "episode", "length", "return", "terminated")
    for run, *key, return_, terminated in zip(*(last[name].tolist() for name in columns), strict=True):
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
    """
    return tuple(
        f"{entry.group.id}, {protocol}: {text}"
        for protocol, log in entry.logs.items()
        for text in (
            _identical_lengths(log),
            _shared_episodes(run_sketches(entry, protocol)),
            _above_curves(entry, log) if is_sampled else "",
        )
        if text
    )


def _identical_lengths(log: Log) -> str:
    columns = (log.rows[name].to_numpy() for name in ("length", "position"))
    lengths, positions = (column.reshape(-1, EVALUATION_EPISODES) for column in columns)
    limits = np.array([task.max_steps for task in log.group.tasks])[positions[:, 0]]
    count = int(np.sum(np.all(lengths == lengths[:, :1], axis=1) & (lengths[:, 0] < limits)))
    equal = f"all {EVALUATION_EPISODES} episodes have the same length, which is below the time limit."
    return f"In {count} of {len(lengths)} cells, {equal}" if count else ""


def _shared_episodes(sketches: Sequence[Sketch]) -> str:
    count = sum(any(is_common(each, other) for other in sketches[:at]) for at, each in enumerate(sketches))
    text = f"{count} of {len(sketches)} runs share most of their last episodes with an earlier run."
    return text if count else ""


def _above_curves(entry: SubmittedGroup, log: Log) -> str:
    """Compares the mean return right after the training on a task with the training curve of that task."""
    rows, documents = log.rows, entry.runs[log.protocol].items()
    curves = [(run, curve) for run, document in documents for curve in document.curves]
    count = 0
    for run, curve in curves:
        position = entry.group.task_ids.index(curve.task)
        stage = position + 1 if log.protocol == "sequential" else 1
        cell = (rows["run"] == run) & (rows["stage"] == stage) & (rows["position"] == position)
        if curve.returns and cell.any():
            top, low = max(curve.returns), min(curve.returns)
            count += bool(rows["return"][cell].to_numpy().mean() > top + CURVE_RANGES * (top - low))
    where = "cells right after training, the mean return is far above the training curve."
    return f"In {count} of {len(curves)} {where}" if count else ""
