"""Results and references -> one ``Run`` of normalized returns per training seed."""

from __future__ import annotations

from gym_extensions.scoring.metrics.auc import area
from gym_extensions.scoring.metrics.returns import Results
from gym_extensions.scoring.metrics.run import Run
from gym_extensions.scoring.references import Reference, References


def _areas(results: Results, protocol: str, run: int, scored: dict[int, Reference]) -> dict[int, float]:
    areas = {}
    for j, reference in scored.items():
        steps, values = results.curves.get((protocol, run, results.group.task_ids[j - 1]), ([], []))
        height = area(steps, reference.normalize_all(values), results.steps)
        if height is not None:
            areas[j] = height
    return areas


def normalized_runs(results: Results, references: References, protocol: str) -> list[Run]:
    """One Run per training seed of a protocol's log.

    Every task of the group needs a reference.

    ``single_task`` and the areas are filled in where the log has a single log or curves beside it.
    """
    ids = results.group.task_ids
    scored = {
        j: reference for j, task in enumerate(ids, 1) if not (reference := references.tasks[task]).unsolved
    }
    T = len(ids)
    single = dict(zip(results.runs.get("single", ()), results.means.get("single", ()), strict=True))
    first_stage = 0 if protocol == "sequential" else T
    runs = []
    for seed, episodes, means in zip(
        results.runs[protocol], results.returns[protocol], results.means[protocol], strict=True
    ):
        with_curves = scored if protocol == "sequential" else {}
        runs.append(
            Run(
                T=T,
                scored=tuple(scored),
                normalized_returns={
                    (s, j): reference.normalize(row[j - 1])
                    for s, row in enumerate(means, first_stage)
                    for j, reference in scored.items()
                },
                final_episodes={
                    j: tuple(reference.normalize_all(episodes[-1][j - 1])) for j, reference in scored.items()
                },
                single_task={
                    j: reference.normalize(single[seed][0][j - 1])
                    for j, reference in (scored if seed in single else {}).items()
                },
                auc=_areas(results, protocol, seed, with_curves),
                single_task_auc=_areas(results, "single", seed, with_curves),
            )
        )
    return runs
