"""Results and references -> one ``Run`` of normalised returns for every training seed."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gym_extensions.scoring.curves import area
from gym_extensions.scoring.normalise import Reference, References
from gym_extensions.scoring.results import Results
from gym_extensions.scoring.run import Run

Means = list[list[list[float]]]


def cell_mean(episodes: Sequence[float]) -> float:
    """The mean return of a cell's episodes, by ``math.fsum``."""
    return math.fsum(episodes) / len(episodes)


def stage_returns(results: Results, protocol: str) -> list[list[list[list[float]]]]:
    """Returns as nested lists [run][stage][task][episode]; single and joint logs have one stage."""
    array = getattr(results, protocol)
    if array is None:
        return []
    listed: list[list[list[list[float]]]] = (array if protocol == "sequential" else array[:, None]).tolist()
    return listed


def matrix(results: Results, protocol: str) -> Means:
    """Mean raw returns [run][stage][task]."""
    return [
        [[cell_mean(episodes) for episodes in tasks] for tasks in run]
        for run in stage_returns(results, protocol)
    ]


def _areas(results: Results, protocol: str, run: int, scored: dict[int, Reference]) -> dict[int, float]:
    found = {}
    for j, reference in scored.items():
        curve = results.curves.get((protocol, run, results.group.task_ids[j - 1]), ())
        height = area([(step, reference.normalised(value)) for step, value in curve], results.steps)
        if height is not None:
            found[j] = height
    return found


def normalised(results: Results, references: References, protocol: str) -> list[Run]:
    """One Run for each training seed of a protocol's log; every task of the group needs a reference.

    ``alone`` and the areas are filled in for sequential and single logs, where their files are there.
    """
    ids = results.group.task_ids
    known = {j: references.tasks[task] for j, task in enumerate(ids, 1)}
    scored = {j: reference for j, reference in known.items() if not reference.open}
    T = len(ids)
    alone = dict(zip(results.runs.get("single", ()), matrix(results, "single"), strict=True))
    found = []
    for seed, run in zip(results.runs[protocol], stage_returns(results, protocol), strict=True):
        first = 0 if protocol == "sequential" else T
        cells = {
            (s, j): reference.normalised(cell_mean(tasks[j - 1]))
            for s, tasks in enumerate(run, first)
            for j, reference in scored.items()
        }
        found.append(
            Run(
                T=T,
                scored=tuple(scored),
                cells=cells,
                last={j: tuple(map(reference.normalised, run[-1][j - 1])) for j, reference in scored.items()},
                alone={j: ref.normalised(alone[seed][0][j - 1]) for j, ref in scored.items()}
                if seed in alone
                else {},
                area=_areas(results, protocol, seed, scored) if protocol == "sequential" else {},
                area_alone=_areas(results, "single", seed, scored) if protocol == "sequential" else {},
            )
        )
    return found
