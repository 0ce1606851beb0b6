"""The page Metrics: the definition of every number, with a worked example."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.scoring.formulas import FINAL, TABLE, Run
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.entry_results import Matrix
from gym_extensions.site.pages.page import File, Render


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """The definition of every number, with an anchor per metric."""
    used = {board.budget for board in site.boards}
    yield "metrics.html", render("metrics.html", "metrics.html", used_budgets=used, example=EXAMPLE)


@dataclass(frozen=True)
class Example:
    """The worked example of the page of metrics: one run of three tasks.

    Args:
        matrix: p[s][j], a row per stage from 0, a column per task.
        single: p_single[j].
        cumulative: p_cumulative[T].
        areas: areas under the training curves in the sequential log.
        single_areas: those of tasks that are trained alone.
        joint: final performance of the same agent on all tasks at once.
        spread: distance of neighbouring episodes of a cell, which lie evenly around its mean.
    """

    matrix: Matrix
    single: tuple[float, ...]
    cumulative: float
    areas: tuple[float, ...]
    single_areas: tuple[float, ...]
    joint: float
    spread: float

    @property
    def run(self) -> Run:
        """The run of the example."""
        tasks = range(1, len(self.single) + 1)
        middle = (EVALUATION_EPISODES - 1) / 2
        offsets = [self.spread * (index - middle) for index in range(EVALUATION_EPISODES)]
        return Run(
            T=len(self.single),
            scored=tuple(tasks),
            normalized_returns={(s, j): row[j - 1] for s, row in enumerate(self.matrix) for j in tasks},
            final_episodes={j: tuple(self.matrix[-1][j - 1] + offset for offset in offsets) for j in tasks},
            single_task=dict(zip(tasks, self.single, strict=True)),
            cumulative={len(self.single): self.cumulative},
            auc=dict(zip(tasks, self.areas, strict=True)),
            single_task_auc=dict(zip(tasks, self.single_areas, strict=True)),
        )

    @cached_property
    def values(self) -> Mapping[str, float | None]:
        """The value of every metric by name; the joint gap is joint minus final performance."""
        run = self.run
        values = {metric.name: metric.of_run(run) for metric in TABLE if metric.terms}
        final = values[FINAL.name]
        return {"joint_gap": None if final is None else self.joint - final, **values}


EXAMPLE = Example(
    matrix=((0.0, 0.1, 0.0), (0.8, 0.2, 0.1), (0.5, 0.9, 0.3), (0.4, 0.7, 1.0)),
    single=(0.8, 0.8, 0.9),
    cumulative=0.95,
    areas=(0.5, 0.6, 0.7),
    single_areas=(0.5, 0.4, 0.5),
    joint=0.9,
    spread=0.02,
)
