"""A few digests per run, by which boards recognize the episodes of another entry."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

from gym_extensions.rollouts.reading.evaluation_log import Log

SIZE = 16
"""Digests per run: the smallest of those of all its last episodes (a bottom-k sketch)."""
SIGNIFICANT_DIGITS = 5
"""Digits of a return that count, so that noise far below the tolerance of a replay changes few digests."""

SHARE = 0.5
"""Least share of common episodes of two runs, and of such runs of an entry, that makes it a duplicate."""

Sketch = tuple[str, ...]


def episode_sketches(log: Log) -> tuple[Sketch, ...]:
    """The sketch of each run: the 16 smallest digests of its episodes after the last stage, sorted.

    An episode's digest is the first eight hexadecimal digits of the SHA-256 of its task's index, number,
    length, return (five significant digits) and end. The share of common digests of two sketches estimates
    the share of common episodes, whatever else differs in the two runs.

    Where episodes are the same on every processor (navigation), the digest of the trace replaces length,
    return and end: returns are whole numbers there, and two agents that stand still have equal ones.

    Source: E. Cohen and H. Kaplan, Summarizing data using bottom-k sketches, PODC 2007.
    """
    last = max(log.stage.tolist(), default=0)
    digests: dict[int, set[str]] = {run: set() for run in log.runs}
    is_exact = bool(log.trace) and all(task.body.segments.tolerance == 0 for task in log.group.tasks)
    measured: Iterable[tuple[object, ...]] = zip(log.trace, strict=True) if is_exact else _measured(log)
    keys = (log.run.tolist(), log.stage.tolist(), log.position.tolist(), log.episode.tolist())
    for run, stage, position, number, values in zip(*keys, measured, strict=True):
        if stage == last:
            episode = (position, number, *values)
            digests[run].add(hashlib.sha256(repr(episode).encode()).hexdigest()[:8])
    return tuple(tuple(sorted(digests[run])[:SIZE]) for run in log.runs)


def _measured(log: Log) -> Iterable[tuple[int, str, bool]]:
    """Length, return (five significant digits) and end of every episode."""
    returns = [f"{return_:.{SIGNIFICANT_DIGITS - 1}e}" for return_ in log.return_.tolist()]
    return zip(log.length.tolist(), returns, log.terminated.tolist(), strict=True)


def is_common(first: Sketch, second: Sketch) -> bool:
    """Whether two runs share at least half of their episodes, as estimated from their sketches."""
    union = sorted({*first, *second})[:SIZE]
    return bool(union) and len({*first} & {*second} & {*union}) >= SHARE * len(union)
