"""Runs that are identical in every episode count once."""

from __future__ import annotations

from dataclasses import replace

from gym_extensions.scoring.checks.across import outcomes
from gym_extensions.scoring.entry import GroupEntry
from gym_extensions.scoring.rows import Log


def without_copies(entry: GroupEntry) -> GroupEntry:
    """The entry with runs that are identical in every log counted once, and a note that says so."""
    each = [dict(zip(log.runs, outcomes(log), strict=True)) for log in entry.logs.values()]
    runs = [set(one) for one in each]
    if not each or any(one != runs[0] for one in runs):
        return entry
    same: dict[tuple[object, ...], list[int]] = {}
    for run in sorted(runs[0]):
        same.setdefault(tuple(one[run] for one in each), []).append(run)
    if len(same) == len(runs[0]):
        return entry
    logs = {
        protocol: only(log, {copies[0] for copies in same.values()}) for protocol, log in entry.logs.items()
    }
    notes = [
        f"Runs {', '.join(map(str, copies))} are identical in every episode and count as one."
        for copies in same.values()
        if len(copies) > 1
    ]
    return replace(entry, logs=logs, notes=(*entry.notes, *notes))


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
