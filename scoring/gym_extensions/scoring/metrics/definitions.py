"""Defines every metric as one row, with its formula as text and as code.

See docs/metrics.md.
"""

from __future__ import annotations

from gym_extensions.scoring.metrics.metric import Metric
from gym_extensions.scoring.metrics.run import Run
from gym_extensions.scoring.statistics.descriptive import Number, mean, standard_deviation

HIGHER, LOWER, NOT_RANKED = "higher", "lower", ""


def _later_forgetting(run: Run, j: int) -> Number:
    return mean(run.p(j, j) - run.p(s, j) for s in range(j + 1, run.T + 1))


def _lowest_tenth(values: tuple[float, ...]) -> float:
    return mean(sorted(values)[: -(-len(values) // 10)]) or 0.0


FINAL = Metric(
    "final_performance",
    "Final performance",
    "mean over j of p[T][j]",
    lambda run: mean(run.p(run.T, j) for j in run.scored),
    HIGHER,
    protocols=("sequential", "joint"),
    known_as="ACC, average performance; the paper's Fully Trained",
    limits="Whether low values come from forgetting or from never learning.",
)
JOINT_GAP = Metric(
    "joint_gap",
    "Joint gap",
    "final performance of joint.csv − final performance",
    None,
    LOWER,
    needs=("joint",),
    known_as="distance to multitask training",
    limits="Which part is due to the order: joint training also alternates between tasks.",
)
TABLE = (
    FINAL,
    Metric(
        "learning_performance",
        "Learning performance",
        "mean over j of p[j][j]",
        lambda run: mean(run.p(j, j) for j in run.scored),
        HIGHER,
        known_as="the paper's After Env Training",
        limits="What is left at the end.",
    ),
    Metric(
        "forgetting",
        "Forgetting",
        "mean over j < T of ( p[j][j] − p[T][j] )",
        lambda run: mean(run.p(j, j) - run.p(run.T, j) for j in run.scored if j < run.T),
        LOWER,
        known_as="minus backward transfer (Lopez-Paz & Ranzato 2017)",
        limits="Whether anything was learned; and gains on one task cancel losses on another.",
    ),
    Metric(
        "worst_case_forgetting",
        "Worst-case forgetting",
        "mean over j < T of ( max over j ≤ s < T of p[s][j] − p[T][j] )",
        lambda run: mean(
            max(run.p(s, j) for s in range(j, run.T)) - run.p(run.T, j) for j in run.scored if j < run.T
        ),
        LOWER,
        known_as="Chaudhry et al. 2018, whose maximum is over 1 ≤ s < T; "
        "a maximum over noisy means is biased upward",
        limits="A typical loss. It takes the best stage, so noise raises it.",
    ),
    Metric(
        "mean_later_forgetting",
        "Mean later forgetting",
        "mean over j < T of the mean over s > j of ( p[j][j] − p[s][j] )",
        lambda run: mean(value for j in run.scored if (value := _later_forgetting(run, j)) is not None),
        LOWER,
        known_as="NBT (LIBERO; there over T)",
        limits="The state at the end: losses in between count as much.",
    ),
    Metric(
        "asymptotic_transfer",
        "Asymptotic transfer",
        "mean over j ≥ 2 of ( p[j][j] − p_single[j] )",
        lambda run: mean(run.p(j, j) - run.single_task[j] for j in run.scored if j >= 2),
        HIGHER,
        needs=("single",),
        known_as="Taylor & Stone 2009",
        limits="How fast a task was learned.",
    ),
    Metric(
        "zero_shot_transfer",
        "Zero-shot transfer",
        "mean over j ≥ 2 of ( p[j−1][j] − p[0][j] )",
        lambda run: mean(run.p(j - 1, j) - run.p(0, j) for j in run.scored if j >= 2),
        HIGHER,
        known_as="FWT (Lopez-Paz & Ranzato 2017); jumpstart",
        limits="Whether a gain is due to similar tasks or to any training at all.",
    ),
    Metric(
        "generalization_to_unseen_tasks",
        "Generalization to unseen tasks",
        "mean over 0 < s < j of ( p[s][j] − p[0][j] )",
        lambda run: mean(run.p(s, j) - run.p(0, j) for j in run.scored for s in range(1, j)),
        HIGHER,
        known_as="the upper triangle of the matrix",
        limits="Anything about tasks outside of the group.",
    ),
    Metric(
        "forward_transfer_auc",
        "Forward transfer (AUC)",
        "mean over j ≥ 2 of ( AUC_j − AUC_single,j )",
        lambda run: mean(run.auc[j] - run.single_task_auc[j] for j in run.scored if j >= 2),
        HIGHER,
        needs=("single", "curves"),
        known_as="the numerator of Continual World's FT",
        limits="What is reached at the end of a task's training.",
    ),
    Metric(
        "average_lower_triangle",
        "Average of the lower triangle",
        "mean over all s ≥ j ≥ 1 of p[s][j]",
        lambda run: mean(run.p(s, j) for j in run.scored for s in range(j, run.T + 1)),
        HIGHER,
        known_as="A of Díaz-Rodríguez et al. 2018",
        limits="Learning and retention apart: it mixes both.",
    ),
    JOINT_GAP,
    Metric(
        "return_std",
        "Return standard deviation",
        "mean over j of the population standard deviation of the 20 normalized returns at stage T",
        lambda run: mean(standard_deviation(run.final_episodes[j]) for j in run.scored),
        NOT_RANKED,
        protocols=("sequential", "joint"),
        known_as="the paper's constrained variance; small also for a policy that fails at once",
        limits="Whether returns are good: failing at once every time has a small deviation.",
    ),
    Metric(
        "cvar_10",
        "CVaR 10\N{NO-BREAK SPACE}%",
        "mean over j of the mean of the ⌈n/10⌉ lowest normalized returns at stage T",
        lambda run: mean(_lowest_tenth(run.final_episodes[j]) for j in run.scored),
        HIGHER,
        protocols=("sequential", "joint"),
        known_as="conditional value at risk, expected shortfall; worst tenth",
        limits="Rare failures: two of twenty episodes are averaged.",
    ),
    Metric(
        "single_task_performance",
        "Single-task performance",
        "mean over j of p_single[j]",
        lambda run: mean(run.single_task[j] for j in run.scored),
        HIGHER,
        protocols=("single",),
        known_as="the paper's Single Env",
        limits="Anything about several tasks.",
    ),
)
"""Every metric. To add one, add a row here and a worked example in ``conformance/``."""

METRICS: dict[str, tuple[Metric, ...]] = {
    protocol: tuple(metric for metric in TABLE if protocol in metric.protocols)
    for protocol in ("sequential", "single", "joint")
}
"""The metrics of each protocol in the order of the table; the first one sorts the protocol's boards."""

BY_NAME = {metric.name: metric for metric in TABLE}
