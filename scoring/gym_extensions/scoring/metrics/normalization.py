"""Results and references -> one ``Run`` of normalised returns for every training seed."""

from __future__ import annotations

from gym_extensions.scoring.metrics.auc import area
from gym_extensions.scoring.metrics.returns import Results
from gym_extensions.scoring.metrics.run import Run
from gym_extensions.scoring.references import Reference, References


def _areas(results: Results, protocol: str, run: int, scored: dict[int, Reference]) -> dict[int, float]:
    found = {}
    for j, reference in scored.items():
        steps, values = results.curves.get((protocol, run, results.group.task_ids[j - 1]), ([], []))
        height = area(steps, reference.all_normalised(values), results.steps)
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
    alone = dict(zip(results.runs.get("single", ()), results.means.get("single", ()), strict=True))
    found = []
    first = 0 if protocol == "sequential" else T
    for seed, run, means in zip(
        results.runs[protocol], results.returns[protocol], results.means[protocol], strict=True
    ):
        cells = {
            (s, j): reference.normalised(row[j - 1])
            for s, row in enumerate(means, first)
            for j, reference in scored.items()
        }
        found.append(
            Run(
                T=T,
                scored=tuple(scored),
                cells=cells,
                last={j: tuple(reference.all_normalised(run[-1][j - 1])) for j, reference in scored.items()},
                alone={j: ref.normalised(alone[seed][0][j - 1]) for j, ref in scored.items()}
                if seed in alone
                else {},
                area=_areas(results, protocol, seed, scored) if protocol == "sequential" else {},
                area_alone=_areas(results, "single", seed, scored) if protocol == "sequential" else {},
            )
        )
    return found
