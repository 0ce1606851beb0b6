"""Runs that are identical in every episode, and a submission in which they count once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.submission import GroupEntry


def without_copies(entry: GroupEntry) -> GroupEntry:
    """The entry with runs that are identical in every episode counted once, and notes that say so.

    Sequential and single runs are pairs, and a pair is identical where both are; joint runs stand alone.
    """
    for protocols in (("sequential", "single"), ("joint",)):
        entry = _without_copies(entry, [entry.logs[name] for name in protocols if name in entry.logs])
    return entry


def _without_copies(entry: GroupEntry, logs: list[Log]) -> GroupEntry:
    each = [originals(log) for log in logs]
    same: dict[tuple[int | None, ...], list[int]] = {}
    for run in sorted(set().union(*each)):
        same.setdefault(tuple(one.get(run) for one in each), []).append(run)
    copies = [runs for runs in same.values() if len(runs) > 1]
    if not copies:
        return entry
    firsts = {runs[0] for runs in same.values()}
    which = "Joint runs" if logs[0].protocol == "joint" else "Runs"
    notes = [
        f"{which} {', '.join(map(str, runs))} are identical in every episode and count as one."
        for runs in copies
    ]
    kept = entry.logs | {log.protocol: only(log, firsts) for log in logs}
    return replace(entry, logs=kept, notes=(*entry.notes, *notes))


def only(log: Log, runs: set[int]) -> Log:
    """The rows of a complete log that belong to the given runs."""
    keep = [index for index, run in enumerate(log.run.tolist()) if run in runs]
    return replace(
        log,
        runs=tuple(sorted(runs)),
        run=log.run[keep],
        stage=log.stage[keep],
        task=[log.task[index] for index in keep],
        position=log.position[keep],
        episode=log.episode[keep],
        seed=log.seed[keep],
        length=log.length[keep],
        return_=log.return_[keep],
        terminated=log.terminated[keep],
        fingerprint=[log.fingerprint[index] for index in keep],
    )


def outcomes(log: Log) -> dict[int, tuple[bytes, ...]]:
    """What each run of a log measured, as bytes: episode by episode, whatever the order of the rows."""
    order = np.lexsort((log.episode, log.position, log.stage, log.run))
    starts = np.searchsorted(log.run[order], log.runs).tolist()
    ends = [*starts[1:], order.size]
    measured = (log.stage, log.position, log.episode, log.length, log.return_, log.terminated)
    columns = [column[order] for column in measured]
    return {
        run: tuple(column[start:end].tobytes() for column in columns)
        for run, start, end in zip(log.runs, starts, ends, strict=True)
    }


def originals(log: Log) -> dict[int, int]:
    """For each run of a log the first run that is the same in every episode, itself where none is before."""
    first: dict[tuple[bytes, ...], int] = {}
    return {run: first.setdefault(outcome, run) for run, outcome in outcomes(log).items()}
