"""The scores of one submission on one group or suite under one protocol."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.scoring.leaderboard.board import NOTHING_LEARNED
from gym_extensions.scoring.metrics.value import LEAST_LEARNED, MetricValue, learned_nothing
from gym_extensions.scoring.scorecard.model import GroupScore, ReferenceValue, Scorecard, SuiteScore
from gym_extensions.site.text.numbers import count, digits_for
from gym_extensions.site.views.profile import whole_profile

NO_METRIC = MetricValue(why="not part of this protocol")
Points = tuple[tuple[float, float], ...]
Matrix = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Trial:
    """The scores of a scorecard with their group or suite and protocol; a suite has only metrics."""

    group: str
    protocol: str
    score: GroupScore | SuiteScore

    @property
    def id(self) -> str:
        """Its anchor on the page of the submission."""
        return f"{self.group}-{self.protocol}"

    @cached_property
    def detail(self) -> GroupScore | None:
        """The scores of a group; None for a suite."""
        return self.score if isinstance(self.score, GroupScore) else None

    @property
    def metrics(self) -> Mapping[str, MetricValue]:
        """Every metric of the protocol by name."""
        return self.score.metrics

    def metric(self, name: str) -> MetricValue:
        """The named metric; one without a value if the protocol does not have it."""
        return self.score.metrics.get(name, NO_METRIC)

    @property
    def runs(self) -> tuple[int, ...]:
        """Training seeds; empty for a suite."""
        return self.detail.runs if self.detail else ()

    @property
    def tasks(self) -> tuple[str, ...]:
        """Task ids in training order; empty for a suite."""
        return self.detail.tasks if self.detail else ()

    def reference(self, task: str) -> ReferenceValue | None:
        """Floor and ceiling of a task; None for a suite or without references."""
        return self.detail.reference.get(task) if self.detail else None

    @cached_property
    def profile(self) -> Points:
        """Points of the performance profile, up to the highest score; empty without one."""
        whole = whole_profile(self.detail) if self.detail else None
        return whole.points if whole else ()

    @property
    def iqm(self) -> float | None:
        """Interquartile mean of the scores at the end, or None."""
        return self.detail.iqm if self.detail else None

    @cached_property
    def stage_matrices(self) -> tuple[Matrix, ...]:
        """Mean raw returns [run][stage][task] of a sequential log; else empty."""
        return self.detail.return_matrix if self.detail and self.protocol == "sequential" else ()

    @cached_property
    def mean_matrix(self) -> Matrix:
        """Mean raw returns [stage][task], averaged over runs."""
        return tuple(
            tuple(math.fsum(cells) / len(cells) for cells in zip(*stages, strict=True))
            for stages in zip(*self.stage_matrices, strict=True)
        )

    @cached_property
    def matrix_digits(self) -> int:
        """Digits after the point in all matrices: none if returns reach the hundreds."""
        rows = (*self.final_returns, *(stage for run in self.stage_matrices for stage in run))
        return digits_for(10 * cell for row in rows for cell in row)

    @cached_property
    def top_score(self) -> float:
        """The highest normalized mean return of the matrices, at least 1: the strongest tint."""
        rows = [*self.final_returns, *(stage for run in self.stage_matrices for stage in run)]
        scores = (
            reference.normalize(value)
            for row in rows
            for task, value in zip(self.tasks, row, strict=True)
            if (reference := self.reference(task))
        )
        return max(1.0, *(score for score in scores if score is not None), 1.0)

    @cached_property
    def final_returns(self) -> Matrix:
        """Mean raw returns [run][task] of a single or joint log; else empty."""
        staged = self.protocol == "sequential"
        return tuple(run[-1] for run in self.detail.return_matrix) if self.detail and not staged else ()

    @cached_property
    def success_rates(self) -> tuple[tuple[float | None, ...], ...]:
        """Success rates [stage][task], averaged over runs; empty if no task of the group defines success."""
        runs = self.detail.success_rates if self.detail else ()
        return tuple(
            tuple(None if None in cells else _mean(cells) for cells in zip(*stages, strict=True))
            for stages in zip(*runs, strict=True)
        )

    @cached_property
    def learned_nothing(self) -> bool:
        """Whether the agent learned nothing that it could forget."""
        return learned_nothing(self.score.metrics)

    @property
    def why_no_metrics(self) -> str:
        """The reason why every metric is missing; empty if one has a value or reasons differ."""
        reasons = {value.why if value.mean is None else "" for value in self.score.metrics.values()}
        return next(iter(reasons)) if len(reasons) == 1 else ""

    @cached_property
    def unsolved_tasks(self) -> tuple[str, ...]:
        """The tasks that no reference agent has learned, in training order."""
        return tuple(
            task for task in self.tasks if (reference := self.reference(task)) and reference.unsolved
        )


def _mean(cells: tuple[float | None, ...]) -> float:
    return math.fsum(cell for cell in cells if cell is not None) / len(cells)


@lru_cache(maxsize=1024)
def group_order(group_id: str) -> tuple[int, str]:
    """Sorts groups in the catalog's order, others by name after them."""
    ids = [group.id for group in GROUPS.values()]
    return (ids.index(group_id) if group_id in ids else len(ids), group_id)


def _sorted(trials: list[Trial]) -> tuple[Trial, ...]:
    return tuple(
        sorted(trials, key=lambda trial: (group_order(trial.group), PROTOCOLS.index(trial.protocol)))
    )


def group_trials(card: Scorecard) -> tuple[Trial, ...]:
    """The scores of every group and protocol."""
    return _sorted([Trial(g, p, score) for g, scores in card.groups.items() for p, score in scores.items()])


def separate_groups(card: Scorecard) -> tuple[str, ...]:
    """The groups whose results have a page of their own: all, if there are several."""
    groups = tuple(dict.fromkeys(trial.group for trial in group_trials(card)))
    return groups if len(groups) > 1 else ()


def suite_trials(card: Scorecard) -> tuple[Trial, ...]:
    """The scores of every suite and protocol."""
    return _sorted([Trial(s, p, score) for s, scores in card.suites.items() for p, score in scores.items()])


def nothing_to_forget(trial: Trial) -> str:
    """The note beside the forgetting of an agent that learned nothing that it could forget."""
    uncertain = (trial.metric("learning_performance").mean or 0.0) >= LEAST_LEARNED
    return NOTHING_LEARNED + (f", as far as {count(len(trial.runs), 'run')} can show" if uncertain else "")


def table_digits(trial: Trial) -> int:
    """Digits after the point in the paper's table of a trial: two for a printed table."""
    if trial.detail is None or trial.detail.printed_total:
        return 2
    cells = [cell for row in trial.detail.paper_table for cell in row.cells() if cell]
    return digits_for(cell.mean / 10 for cell in cells)
