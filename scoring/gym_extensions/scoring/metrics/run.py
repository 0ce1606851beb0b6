"""One run in normalized returns is the input of every metric, with the indices of the formulas."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Run:
    """Normalized returns of one training seed.

    Stages s count from 0 (untrained), tasks j from 1.

    All mappings hold the scored positions only.

    Attributes:
        T: number of tasks of the group.
        scored: positions j of the tasks that are not unsolved.
        normalized_returns: p[s][j] by (s, j).
        final_episodes: normalized returns of the evaluation episodes at stage T, by j.
        single_task: p_single[j] by j.
        auc: area under the training curve in the sequential log, by j.
        single_task_auc: area under the training curve in the single log, by j.
    """

    T: int
    scored: tuple[int, ...]
    normalized_returns: dict[tuple[int, int], float] = field(default_factory=dict)
    final_episodes: dict[int, tuple[float, ...]] = field(default_factory=dict)
    single_task: dict[int, float] = field(default_factory=dict)
    auc: dict[int, float] = field(default_factory=dict)
    single_task_auc: dict[int, float] = field(default_factory=dict)

    def p(self, s: int, j: int) -> float:
        """Normalized mean return on task j after stage s."""
        return self.normalized_returns[s, j]
