"""A few digests per run, by which boards recognize the episodes of another entry."""

from __future__ import annotations

import hashlib

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

    Source: E. Cohen and H. Kaplan, Summarizing data using bottom-k sketches, PODC 2007.
    """
    last = max(log.stage.tolist(), default=0)
    digests: dict[int, set[str]] = {run: set() for run in log.runs}
    columns = (log.run, log.stage, log.position, log.episode, log.length, log.return_, log.terminated)
    for run, stage, *key, return_, terminated in zip(*(column.tolist() for column in columns), strict=True):
        if stage == last:
            episode = (*key, f"{return_:.{SIGNIFICANT_DIGITS - 1}e}", terminated)
            digests[run].add(hashlib.sha256(repr(episode).encode()).hexdigest()[:8])
    return tuple(tuple(sorted(digests[run])[:SIZE]) for run in log.runs)


def is_common(first: Sketch, second: Sketch) -> bool:
    """Whether two runs share at least half of their episodes, as estimated from their sketches."""
    union = sorted({*first, *second})[:SIZE]
    return bool(union) and len({*first} & {*second} & {*union}) >= SHARE * len(union)
