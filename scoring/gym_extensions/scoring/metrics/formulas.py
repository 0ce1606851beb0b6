"""The metrics' formulas: one small function of a run each, as docs/metrics.md writes them."""

from __future__ import annotations

from gym_extensions.scoring.metrics.run import Run
from gym_extensions.scoring.statistics.descriptive import Number, mean, standard_deviation


def final_performance(run: Run) -> Number:
    """Mean over j of p[T][j]."""
    return mean(run.p(run.T, j) for j in run.scored)


def learning_performance(run: Run) -> Number:
    """Mean over j of p[j][j]."""
    return mean(run.p(j, j) for j in run.scored)


def forgetting(run: Run) -> Number:
    """Mean over j < T of p[j][j] − p[T][j]: the last task cannot be forgotten."""
    return mean(run.p(j, j) - run.p(run.T, j) for j in run.scored if j < run.T)


def worst_case_forgetting(run: Run) -> Number:
    """Mean over j < T of the best p[s][j], j ≤ s < T, less p[T][j]."""
    return mean(max(run.p(s, j) for s in range(j, run.T)) - run.p(run.T, j) for j in run.scored if j < run.T)


def forgetting_all_later_stages(run: Run) -> Number:
    """Mean over j < T of the mean over s > j of p[j][j] − p[s][j]."""
    each = [mean(run.p(j, j) - run.p(s, j) for s in range(j + 1, run.T + 1)) for j in run.scored]
    return mean(value for value in each if value is not None)


def forward_transfer(run: Run) -> Number:
    """Mean over j ≥ 2 of p[j][j] − p_single[j]."""
    return mean(run.p(j, j) - run.alone[j] for j in run.scored if j >= 2)


def zero_shot_transfer(run: Run) -> Number:
    """Mean over j ≥ 2 of p[j−1][j] − p[0][j]."""
    return mean(run.p(j - 1, j) - run.p(0, j) for j in run.scored if j >= 2)


def generalisation_to_unseen_tasks(run: Run) -> Number:
    """Mean over 0 < s < j of p[s][j] − p[0][j]."""
    return mean(run.p(s, j) - run.p(0, j) for j in run.scored for s in range(1, j))


def learning_speed_transfer(run: Run) -> Number:
    """Mean over j ≥ 2 of AUC_j − AUC_single,j."""
    return mean(run.area[j] - run.area_alone[j] for j in run.scored if j >= 2)


def average_over_training(run: Run) -> Number:
    """Mean over all s ≥ j ≥ 1 of p[s][j]."""
    return mean(run.p(s, j) for j in run.scored for s in range(j, run.T + 1))


def spread(run: Run) -> Number:
    """Mean over j of the population standard deviation of the normalised returns at stage T."""
    return mean(standard_deviation(run.last[j]) for j in run.scored)


def worst_tenth(run: Run) -> Number:
    """Mean over j of the mean of the ⌈n/10⌉ lowest normalised returns at stage T."""
    return mean(_lowest_tenth(run.last[j]) for j in run.scored)


def _lowest_tenth(values: tuple[float, ...]) -> float:
    count = -(-len(values) // 10)
    lowest = mean(sorted(values)[:count])
    return 0.0 if lowest is None else lowest


def single_task_performance(run: Run) -> Number:
    """Mean over j of p_single[j]."""
    return mean(run.alone[j] for j in run.scored)
