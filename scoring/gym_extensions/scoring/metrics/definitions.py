"""Every metric as a table: one name, one formula, one function. Defined in docs/metrics.md."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from gym_extensions.scoring.metrics import formulas
from gym_extensions.scoring.metrics.run import Run
from gym_extensions.scoring.statistics.descriptive import Number


@dataclass(frozen=True)
class Metric:
    """A metric as the site shows it: its key, title, formula, which way is better, what it needs.

    ``better`` is ``higher``, ``lower`` or empty (not ranked); ``needs`` names files without ``.csv``;
    ``known_as`` other names of the same formula. ``function`` is None where the value is no function of one
    run (joint gap).
    """

    name: str
    title: str
    formula: str
    better: str
    needs: tuple[str, ...]
    function: Callable[[Run], Number] | None
    known_as: str = ""


FINAL = Metric(
    "final_performance",
    "Final performance",
    "mean over j of p[T][j]",
    "higher",
    ("sequential",),
    formulas.final_performance,
    "ACC, average performance; the paper's Fully Trained",
)
SPREAD = Metric(
    "spread",
    "Spread",
    "mean over j of the population standard deviation of the 20 normalised returns at stage T",
    "",
    ("sequential",),
    formulas.spread,
    "the paper's constrained variance; a policy that fails at once has little of it",
)
WORST_TENTH = Metric(
    "worst_tenth",
    "Worst tenth",
    "mean over j of the mean of the ⌈n/10⌉ lowest normalised returns at stage T",
    "higher",
    ("sequential",),
    formulas.worst_tenth,
    "CVaR",
)
JOINT_GAP = Metric(
    "joint_gap",
    "Joint gap",
    "final performance of joint.csv − final performance",
    "lower",
    ("sequential", "joint"),
    None,
    "distance to multitask training",
)

SEQUENTIAL = (
    FINAL,
    Metric(
        "learning_performance",
        "Learning performance",
        "mean over j of p[j][j]",
        "higher",
        ("sequential",),
        formulas.learning_performance,
        "the paper's After Env Training",
    ),
    Metric(
        "forgetting",
        "Forgetting",
        "mean over j < T of ( p[j][j] − p[T][j] )",
        "lower",
        ("sequential",),
        formulas.forgetting,
        "minus backward transfer (Lopez-Paz & Ranzato 2017)",
    ),
    Metric(
        "worst_case_forgetting",
        "Worst-case forgetting",
        "mean over j < T of ( max over j ≤ s < T of p[s][j] − p[T][j] )",
        "lower",
        ("sequential",),
        formulas.worst_case_forgetting,
        "Chaudhry et al. 2018; a maximum over noisy means is biased upward",
    ),
    Metric(
        "forgetting_all_later_stages",
        "Forgetting, all later stages",
        "mean over j < T of the mean over s > j of ( p[j][j] − p[s][j] )",
        "lower",
        ("sequential",),
        formulas.forgetting_all_later_stages,
        "NBT (LIBERO; there over T)",
    ),
    Metric(
        "forward_transfer",
        "Forward transfer",
        "mean over j ≥ 2 of ( p[j][j] − p_single[j] )",
        "higher",
        ("sequential", "single"),
        formulas.forward_transfer,
        "asymptotic transfer (Taylor & Stone 2009)",
    ),
    Metric(
        "zero_shot_transfer",
        "Zero-shot transfer",
        "mean over j ≥ 2 of ( p[j−1][j] − p[0][j] )",
        "higher",
        ("sequential",),
        formulas.zero_shot_transfer,
        "FWT (Lopez-Paz & Ranzato 2017); jumpstart",
    ),
    Metric(
        "generalisation_to_unseen_tasks",
        "Generalisation to unseen tasks",
        "mean over 0 < s < j of ( p[s][j] − p[0][j] )",
        "higher",
        ("sequential",),
        formulas.generalisation_to_unseen_tasks,
        "the upper triangle of the matrix",
    ),
    Metric(
        "learning_speed_transfer",
        "Learning-speed transfer",
        "mean over j ≥ 2 of ( AUC_j − AUC_single,j )",
        "higher",
        ("sequential", "single", "curves"),
        formulas.learning_speed_transfer,
        "the numerator of Continual World's FT",
    ),
    Metric(
        "average_over_training",
        "Average over training",
        "mean over all s ≥ j ≥ 1 of p[s][j]",
        "higher",
        ("sequential",),
        formulas.average_over_training,
        "A of Díaz-Rodríguez et al. 2018",
    ),
    JOINT_GAP,
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
        formulas.single_task_performance,
        "the paper's Single Env",
    ),
)
JOINT = (FINAL, SPREAD, WORST_TENTH)

METRICS = {"sequential": SEQUENTIAL, "single": SINGLE, "joint": JOINT}
"""Every metric by protocol, in the order of docs/metrics.md."""
