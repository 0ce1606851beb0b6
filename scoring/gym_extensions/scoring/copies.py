"""Runs that are identical in every episode count once; entries that repeat another are named."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from gym_extensions.scoring.checks.across import originals
from gym_extensions.scoring.entry import GroupEntry
from gym_extensions.scoring.rows import Log


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


def repeats(found: Mapping[str, dict[str, Any]]) -> dict[str, str]:
    """Entries whose every metric is that of another in every run, by name, and the first such other."""
    alike: dict[tuple[tuple[float, ...], ...], list[str]] = {}
    for name, scored in sorted(found.items()):
        runs = tuple(tuple(metric["runs"]) for _, metric in sorted(scored["metrics"].items()))
        if any(runs):
            alike.setdefault(runs, []).append(name)
    return {
        name: names[1] if name == names[0] else names[0]
        for names in alike.values()
        for name in names
        if len(names) > 1
    }
