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
    first: dict[tuple[object, ...], int] = {}
    for run in sorted(runs[0]):
        first.setdefault(tuple(one[run] for one in each), run)
    kept = sorted(first.values())
    if len(kept) == len(runs[0]):
        return entry
    logs = {protocol: only(log, set(kept)) for protocol, log in entry.logs.items()}
    note = f"Runs {sorted(runs[0])} hold {len(kept)} different: runs identical in every episode count as one."
    return replace(entry, logs=logs, notes=(*entry.notes, note))


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
