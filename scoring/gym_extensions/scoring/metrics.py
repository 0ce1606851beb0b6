"""Every metric: one name, one formula, one small function of a run. Defined in docs/metrics.md."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from gym_extensions.scoring.run import Number, Run, deviation, mean


@dataclass(frozen=True)
class Metric:
    """A metric as the site shows it: its key, title, formula, which way is better, what it needs, its function.

    ``better`` is ``higher``, ``lower`` or empty (not ranked); ``needs`` names the files without ``.csv``; ``known_as``
    other names of the same formula. ``function`` is None where the value is no function of one run (joint gap).
    """

    name: str
    title: str
    formula: str
    better: str
    needs: tuple[str, ...]
    function: Callable[[Run], Number] | None
    known_as: str = ""


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
    return mean(deviation(run.last[j]) for j in run.scored)


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


FINAL = Metric(
    "final_performance",
    "Final performance",
    "mean over j of p[T][j]",
    "higher",
    ("sequential",),
    final_performance,
    "ACC, average performance; the paper's Fully Trained",
)
SPREAD = Metric(
    "spread",
    "Spread",
    "mean over j of the population standard deviation of the 20 returns at stage T, over (ceiling_j − floor_j)",
    "",
    ("sequential",),
    spread,
    "the paper's constrained variance; a policy that fails at once has little of it",
)
WORST_TENTH = Metric(
    "worst_tenth",
    "Worst tenth",
    "mean over j of the mean of the ⌈n/10⌉ lowest normalised returns at stage T",
    "higher",
    ("sequential",),
    worst_tenth,
    "CVaR",
)

SEQUENTIAL = (
    FINAL,
    Metric(
        "learning_performance",
        "Learning performance",
        "mean over j of p[j][j]",
        "higher",
        ("sequential",),
        learning_performance,
        "the paper's After Env Training",
    ),
    Metric(
        "forgetting",
        "Forgetting",
        "mean over j < T of ( p[j][j] − p[T][j] )",
        "lower",
        ("sequential",),
        forgetting,
        "minus backward transfer (Lopez-Paz & Ranzato 2017)",
    ),
    Metric(
        "worst_case_forgetting",
        "Worst-case forgetting",
        "mean over j < T of ( max over j ≤ s < T of p[s][j] − p[T][j] )",
        "lower",
        ("sequential",),
        worst_case_forgetting,
        "Chaudhry et al. 2018; a maximum over noisy means is biased upward",
    ),
    Metric(
        "forgetting_all_later_stages",
        "Forgetting, all later stages",
        "mean over j < T of the mean over s > j of ( p[j][j] − p[s][j] )",
        "lower",
        ("sequential",),
        forgetting_all_later_stages,
        "NBT (LIBERO; there over T)",
    ),
    Metric(
        "forward_transfer",
        "Forward transfer",
        "mean over j ≥ 2 of ( p[j][j] − p_single[j] )",
        "higher",
        ("sequential", "single"),
        forward_transfer,
        "asymptotic transfer (Taylor & Stone 2009)",
    ),
    Metric(
        "zero_shot_transfer",
        "Zero-shot transfer",
        "mean over j ≥ 2 of ( p[j−1][j] − p[0][j] )",
        "higher",
        ("sequential",),
        zero_shot_transfer,
        "FWT (Lopez-Paz & Ranzato 2017); jumpstart",
    ),
    Metric(
        "generalisation_to_unseen_tasks",
        "Generalisation to unseen tasks",
        "mean over 0 < s < j of ( p[s][j] − p[0][j] )",
        "higher",
        ("sequential",),
        generalisation_to_unseen_tasks,
        "the upper triangle of the matrix",
    ),
    Metric(
        "learning_speed_transfer",
        "Learning-speed transfer",
        "mean over j ≥ 2 of ( AUC_j − AUC_single,j )",
        "higher",
        ("sequential", "single", "curves"),
        learning_speed_transfer,
        "the numerator of Continual World's FT",
    ),
    Metric(
        "average_over_training",
        "Average over training",
        "mean over all s ≥ j ≥ 1 of p[s][j]",
        "higher",
        ("sequential",),
        average_over_training,
        "A of Díaz-Rodríguez et al. 2018",
    ),
    Metric(
        "joint_gap",
        "Joint gap",
        "final performance of joint.csv − final performance",
        "lower",
        ("sequential", "joint"),
        None,
        "distance to multitask training",
    ),
    SPREAD,
    WORST_TENTH,
)
SINGLE = (
    Metric(
        "single_task_performance",
        "Single-task performance",
        "mean over j of p_single[j]",
        "higher",
        ("single",),
        single_task_performance,
        "the paper's Single Env",
    ),
)
JOINT = (FINAL, SPREAD, WORST_TENTH)

METRICS = {"sequential": SEQUENTIAL, "single": SINGLE, "joint": JOINT}
"""Every metric by protocol, in the order of docs/metrics.md."""
