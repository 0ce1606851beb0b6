"""Sketches of runs, by which boards recognize copies."""

from __future__ import annotations

import hashlib

from gym_extensions.submissions.log import Log
from gym_extensions.submissions.submission import SubmittedGroup

SIZE = 16
"""Digests per run: the smallest of those of all its last episodes (a bottom-k sketch)."""
SIGNIFICANT_DIGITS = 5
"""Digits of a return that count, so that little noise changes few digests."""
SHARE = 0.5
"""Least share of common episodes of two runs, and of such runs of a submission, that makes it a duplicate."""

Sketch = tuple[str, ...]


def run_sketches(submitted: SubmittedGroup, protocol: str) -> tuple[Sketch, ...]:
    """What two equal runs have in common: the sketch of the last episodes of each run of a log.

    In navigation, returns are whole numbers, and different agents that stand still have equal episodes.
    Episodes cannot show a copy there. A run's sketch is the digest of its policies instead, and is empty
    without them.
    """
    log = submitted.logs[protocol]
    if any(task.body.family != "navigation" for task in submitted.group.tasks):
        return episode_sketches(log)
    policies = [submitted.runs[protocol][run].policies for run in log.runs]
    return tuple((each.sha256,) if each else () for each in policies)


def episode_sketches(log: Log) -> tuple[Sketch, ...]:
    """The sketch of each run: the 16 smallest digests of its episodes after the last stage, sorted.

    Where there are several tasks, the last one does not count: methods that only differ in what they keep of
    earlier tasks rightly have equal episodes on it. An episode's digest is the first eight hexadecimal digits
    of the SHA-256 of its task's index, number, length, return (five significant digits) and end. Two sketches
    estimate the Jaccard index of the episodes of two runs: the number of common ones per episode that either
    has.

    Source: E. Cohen and H. Kaplan, Summarizing data using bottom-k sketches, PODC 2007.
    """
    digests: dict[int, set[str]] = {run: set() for run in log.runs}
    last = log.rows[log.rows["stage"] == log.rows["stage"].max()]
    earlier = last[last["position"] < last["position"].max()]
    last = earlier if len(earlier) else last
    columns = ("run", "position", "episode", "length", "return", "terminated")
    for run, *key, return_, terminated in zip(*(last[name].tolist() for name in columns), strict=True):
        episode = (*key, f"{return_:.{SIGNIFICANT_DIGITS - 1}e}", terminated)
        digests[run].add(hashlib.sha256(repr(episode).encode()).hexdigest()[:8])
    return tuple(tuple(sorted(digests[run])[:SIZE]) for run in log.runs)


def is_common(first: Sketch, second: Sketch) -> bool:
    """Whether two runs share at least half of their episodes, as estimated from their sketches.

    Two runs of n episodes with f n common ones have f / (2 − f) common ones per episode of either.
    """
    union = sorted({*first, *second})[:SIZE]
    return bool(union) and len({*first} & {*second} & {*union}) >= SHARE / (2 - SHARE) * len(union)
