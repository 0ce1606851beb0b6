"""Finds runs that are identical in every episode, and counts them as one run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.submission import SubmittedGroup

TOLERANCE = 1e-5
"""Largest difference of identical returns, absolute and relative: ten times the tolerance of replay, so that
a copy with noise that replay accepts is not another run."""
PAIRED_PROTOCOLS = (("sequential", "single"), ("joint",))
"""Protocols whose runs belong together: a run of one agent has both a sequential and a single log."""


def merge_identical_runs(submitted: SubmittedGroup) -> SubmittedGroup:
    """The group with identical runs counted as one, and a note per set of identical runs.

    A sequential and a single run of one training seed are a pair; two pairs are identical if both logs are.
    Joint runs are compared by themselves.
    """
    for protocols in PAIRED_PROTOCOLS:
        logs = [submitted.logs[name] for name in protocols if name in submitted.logs]
        submitted = _merge(submitted, logs)
    return submitted


def _merge(submitted: SubmittedGroup, logs: list[Log]) -> SubmittedGroup:
    """The group with the runs merged that are identical in each of these logs."""
    first_runs = [first_identical_runs(log) for log in logs]
    sets: dict[tuple[int | None, ...], list[int]] = {}
    for run in sorted(set().union(*first_runs)):
        sets.setdefault(tuple(first.get(run) for first in first_runs), []).append(run)
    copies = [runs for runs in sets.values() if len(runs) > 1]
    if not copies:
        return submitted
    kind = "Joint runs" if logs[0].protocol == "joint" else "Runs"
    notes = [
        f"{kind} {', '.join(map(str, runs))} are identical in every episode and count as one."
        for runs in copies
    ]
    distinct = {runs[0] for runs in sets.values()}
    merged = submitted.logs | {log.protocol: select_runs(log, distinct) for log in logs}
    return replace(submitted, logs=merged, notes=(*submitted.notes, *notes))


def select_runs(log: Log, runs: set[int]) -> Log:
    """The rows of a complete log that belong to these runs."""
    rows = [index for index, run in enumerate(log.run.tolist()) if run in runs]
    return replace(
        log,
        runs=tuple(sorted(runs)),
        run=log.run[rows],
        stage=log.stage[rows],
        task=[log.task[index] for index in rows],
        position=log.position[rows],
        episode=log.episode[rows],
        seed=log.seed[rows],
        length=log.length[rows],
        return_=log.return_[rows],
        terminated=log.terminated[rows],
        success=log.success[rows],
        trace=[log.trace[index] for index in rows if log.trace],
        fingerprint=[log.fingerprint[index] for index in rows],
    )


def measurements(log: Log) -> dict[int, tuple[bytes, NDArray[np.float64]]]:
    """The measured columns of each run but the returns as bytes, and its returns, sorted by episode key."""
    order = np.lexsort((log.episode, log.position, log.stage, log.run))
    starts = np.searchsorted(log.run[order], log.runs).tolist()
    ends = [*starts[1:], order.size]
    names = ("stage", "position", "episode", "length", "terminated", "success")
    columns = [getattr(log, name)[order] for name in names]
    returns = log.return_[order]
    return {
        run: (b"".join(column[start:end].tobytes() for column in columns), returns[start:end])
        for run, start, end in zip(log.runs, starts, ends, strict=True)
    }


def first_identical_runs(log: Log) -> dict[int, int]:
    """For each run, the first run that is identical in every episode.

    That is the run itself if it is the first. Returns that differ by less than ``TOLERANCE`` are identical.
    """
    firsts: dict[bytes, list[tuple[int, float, NDArray[np.float64]]]] = {}
    result = {}
    for run, (measured, returns) in measurements(log).items():
        candidates, total = firsts.setdefault(measured, []), float(returns.sum())
        scale = TOLERANCE * max(1.0, float(np.abs(returns).sum()))
        result[run] = next(
            (
                first
                for first, other_total, other in candidates
                if abs(total - other_total) <= 2 * scale + TOLERANCE * returns.size
                if np.allclose(returns, other, rtol=TOLERANCE, atol=TOLERANCE)
            ),
            run,
        )
        if result[run] == run:
            candidates.append((run, total, returns))
    return result
