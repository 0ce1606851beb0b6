"""The worked example of the page of metrics: one run of three tasks, with the value of every metric."""

from __future__ import annotations

from collections.abc import Mapping

from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.scoring.metrics.definitions import FINAL, TABLE
from gym_extensions.scoring.metrics.run import Run

MATRIX = ((0.0, 0.1, 0.0), (0.8, 0.2, 0.1), (0.5, 0.9, 0.3), (0.4, 0.7, 1.0))
"""p[s][j]: a row per stage from 0, a column per task."""
SINGLE = (0.8, 0.8, 0.9)
"""p_single[j]."""
AREAS, SINGLE_AREAS = (0.5, 0.6, 0.7), (0.5, 0.4, 0.5)
"""Areas under the training curves, in the sequential log and of tasks trained alone."""
JOINT = 0.9
"""Final performance of the same agent on all tasks at once."""
SPREAD = 0.02
"""Distance of neighboring episodes of a cell, which lie evenly around its mean."""


def example_run() -> Run:
    """The run of the example."""
    tasks = range(1, len(SINGLE) + 1)
    offsets = [SPREAD * (index - (EVALUATION_EPISODES - 1) / 2) for index in range(EVALUATION_EPISODES)]
    return Run(
        T=len(SINGLE),
        scored=tuple(tasks),
        normalized_returns={(s, j): MATRIX[s][j - 1] for s in range(len(MATRIX)) for j in tasks},
        final_episodes={j: tuple(MATRIX[-1][j - 1] + offset for offset in offsets) for j in tasks},
        single_task=dict(zip(tasks, SINGLE, strict=True)),
        auc=dict(zip(tasks, AREAS, strict=True)),
        single_task_auc=dict(zip(tasks, SINGLE_AREAS, strict=True)),
    )


def example_values() -> Mapping[str, float | None]:
    """The value of every metric of the example by name; the joint gap is joint minus final performance."""
    run = example_run()
    values = {metric.name: metric.function(run) for metric in TABLE if metric.function}
    final = values[FINAL.name]
    return {"joint_gap": None if final is None else JOINT - final, **values}
