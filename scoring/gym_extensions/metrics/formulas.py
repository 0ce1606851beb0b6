"""Every metric: its formula as text and as code over one run.

See docs/metrics.md. A metric is a row of ``TABLE``. The input of every formula is a :class:`NormalizedRun` of
normalized returns; curves, performance profile and interquartile mean have functions of their own.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike

from gym_extensions.catalog.protocol import CURVE_POINTS, IN_ORDER, PROTOCOLS
from gym_extensions.documents import about
from gym_extensions.errors import BenchError
from gym_extensions.metrics.statistics import Array, Number, mean, standard_deviation


@dataclass(frozen=True)
class NormalizedRun:
    """Normalized returns of one training seed.

    Stages s count from 0 (untrained), tasks j from 1.

    All mappings hold the scored positions only.

    Attributes:
        T: number of tasks of the group.
        scored: positions j of the tasks that are not open.
        normalized_returns: p[s][j] by (s, j).
        final_episodes: normalized returns of the evaluation episodes at stage T, by j.
        single_task: p_single[j] by j.
        cumulative: p_cumulative[T] by T; empty without a cumulative run of this training seed.
        auc: area under the training curve in the sequential log, by j.
        single_task_auc: area under the training curve in the single log, by j.
        order: the task at each position j, counted from 1 in the order of the group; j itself if empty.
    """

    T: int
    scored: tuple[int, ...]
    normalized_returns: dict[tuple[int, int], float] = field(default_factory=dict)
    final_episodes: dict[int, tuple[float, ...]] = field(default_factory=dict)
    single_task: dict[int, float] = field(default_factory=dict)
    cumulative: dict[int, float] = field(default_factory=dict)
    auc: dict[int, float] = field(default_factory=dict)
    single_task_auc: dict[int, float] = field(default_factory=dict)
    order: tuple[int, ...] = ()

    def task(self, j: int) -> int:
        """The task at position j, counted from 1 in the order of the group."""
        return self.order[j - 1] if self.order else j

    def p(self, s: int, j: int) -> float:
        """Normalized mean return on task j after stage s."""
        return self.normalized_returns[s, j]


NEEDS = {
    "single": "single-task runs",
    "joint": "joint runs",
    "cumulative": "cumulative runs",
    "curves": "training curves",
}
"""What a metric may need that not every submission has, in words."""
Place = Literal["boards", "ranks", "screen", "core", "alone"]


@dataclass(frozen=True)
class Metric:
    """One metric: its formula, what it needs, and where it is shown.

    Attributes:
        name: its key in scorecards.
        title: its name on pages.
        formula: its definition as text.
        terms: what it is the mean of, for one run: the position j of a task, and a value of that task. There
            are none where the value is not a function of one run (joint gap).
        better: ``higher``, ``lower`` or empty (not ranked).
        protocols: the protocols that it is a metric of.
        needs: what it needs besides mean returns after training: of ``NEEDS``; or ``untrained`` (returns
            before training) and ``episodes`` (single returns), which every log has and not every matrix.
        columns: the protocols whose boards have it as a column on pages.
        shown: where else it is shown: in ``boards`` (boards.json and their data frames), with its ``ranks``
            in the column, on the ``screen`` of ``score``, on the ``core`` board, and in the row ``alone`` of
            boards. The page of a submission and its scorecard have every metric.
        known_as: other names of the same formula.
        limits: what its value does not say.
    """

    name: str
    title: str
    formula: str
    terms: Callable[[NormalizedRun], Iterable[tuple[int, float]]]
    better: str
    protocols: tuple[str, ...] = IN_ORDER
    needs: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    shown: tuple[Place, ...] = ("boards",)
    known_as: str = ""
    limits: str = ""

    def of_run(self, run: NormalizedRun) -> Number:
        """The value for one run; None without a term."""
        return mean(value for _, value in self.terms(run))

    def shares(self, run: NormalizedRun) -> dict[int, float]:
        """What each task adds to the value of one run, by task from 1: their sum is the value.

        Every share is proportional to the task's scores, so that an error of the span from floor to expert
        by one per cent changes it by one per cent.
        """
        terms = list(self.terms(run))
        shares: dict[int, list[float]] = defaultdict(list)
        for j, value in terms:
            shares[run.task(j)].append(value)
        return {task: math.fsum(values) / len(terms) for task, values in shares.items()}


HIGHER, LOWER, NOT_RANKED = "higher", "lower", ""


def _later_forgetting(run: NormalizedRun, j: int) -> Number:
    return mean(run.p(j, j) - run.p(s, j) for s in range(j + 1, run.T + 1))


def _last_task(run: NormalizedRun, value: Callable[[int], float]) -> list[tuple[int, float]]:
    return [(run.T, value(run.T))] if run.T in run.scored else []


def _lowest_tenth(values: tuple[float, ...]) -> float:
    return mean(sorted(values)[: -(-len(values) // 10)]) or 0.0


TABLE = (
    Metric(
        "final_performance",
        "Final performance",
        "mean over j of p[T][j]",
        lambda run: ((j, run.p(run.T, j)) for j in run.scored),
        HIGHER,
        protocols=(*IN_ORDER, "joint"),
        columns=(*IN_ORDER, "joint"),
        shown=("boards", "ranks", "screen", "core", "alone"),
        known_as="ACC, average performance; the paper's Fully Trained",
        limits="Whether low values come from forgetting or from never learning.",
    ),
    Metric(
        "learning_performance",
        "Learning performance",
        "mean over j of p[j][j]",
        lambda run: ((j, run.p(j, j)) for j in run.scored),
        HIGHER,
        columns=IN_ORDER,
        shown=("boards", "screen", "core"),
        known_as="the paper's After Env Training",
        limits="What is left at the end.",
    ),
    Metric(
        "forgetting",
        "Forgetting",
        "mean over j < T of ( p[j][j] − p[T][j] )",
        lambda run: ((j, run.p(j, j) - run.p(run.T, j)) for j in run.scored if j < run.T),
        LOWER,
        columns=IN_ORDER,
        shown=("boards", "ranks", "screen", "core"),
        known_as="minus backward transfer (Lopez-Paz & Ranzato 2017)",
        limits="Whether anything was learned; and gains on one task cancel losses on another.",
    ),
    Metric(
        "worst_case_forgetting",
        "Worst-case forgetting",
        "mean over j < T of ( max over j ≤ s < T of p[s][j] − p[T][j] )",
        lambda run: (
            (j, max(run.p(s, j) for s in range(j, run.T)) - run.p(run.T, j)) for j in run.scored if j < run.T
        ),
        LOWER,
        shown=(),
        known_as="forgetting (Chaudhry et al. 2018), with a maximum over 1 ≤ s < T",
        limits="A typical loss. It takes the best stage, so noise raises it.",
    ),
    Metric(
        "mean_later_forgetting",
        "Mean later forgetting",
        "mean over j < T of the mean over s > j of ( p[j][j] − p[s][j] )",
        lambda run: ((j, value) for j in run.scored if (value := _later_forgetting(run, j)) is not None),
        LOWER,
        shown=(),
        known_as="NBT (LIBERO; there over T)",
        limits="The state at the end: losses in between count as much.",
    ),
    Metric(
        "asymptotic_transfer",
        "Asymptotic transfer",
        "mean over j ≥ 2 of ( p[j][j] − p_single[j] )",
        lambda run: ((j, run.p(j, j) - run.single_task[j]) for j in run.scored if j >= 2),
        HIGHER,
        needs=("single",),
        columns=IN_ORDER,
        shown=("boards", "screen"),
        known_as="Taylor & Stone 2009",
        limits="How fast a task was learned.",
    ),
    Metric(
        "zero_shot_transfer",
        "Zero-shot transfer",
        "mean over j ≥ 2 of ( p[j−1][j] − p[0][j] )",
        lambda run: ((j, run.p(j - 1, j) - run.p(0, j)) for j in run.scored if j >= 2),
        HIGHER,
        needs=("untrained",),
        columns=IN_ORDER,
        shown=("boards", "core"),
        known_as="FWT (Lopez-Paz & Ranzato 2017); jumpstart",
        limits="Whether a gain is due to similar tasks or to any training at all.",
    ),
    Metric(
        "generalization_to_unseen_tasks",
        "Generalization to unseen tasks",
        "mean over 0 < s < j of ( p[s][j] − p[0][j] )",
        lambda run: ((j, run.p(s, j) - run.p(0, j)) for j in run.scored for s in range(1, j)),
        HIGHER,
        needs=("untrained",),
        known_as="the upper triangle of the matrix",
        limits="Anything about tasks outside of the group.",
    ),
    Metric(
        "forward_transfer_auc",
        "Forward transfer (AUC)",
        "mean over j ≥ 2 of ( AUC_j − AUC_single,j )",
        lambda run: ((j, run.auc[j] - run.single_task_auc[j]) for j in run.scored if j >= 2),
        HIGHER,
        needs=("single", "curves"),
        known_as="the numerator of Continual World's FT",
        limits="What is reached at the end of a task's training.",
    ),
    Metric(
        "average_lower_triangle",
        "Average of the lower triangle",
        "mean over all s ≥ j ≥ 1 of p[s][j]",
        lambda run: ((j, run.p(s, j)) for j in run.scored for s in range(j, run.T + 1)),
        HIGHER,
        shown=(),
        known_as="A of Díaz-Rodríguez et al. 2018",
        limits="Learning and retention apart: it mixes both.",
    ),
    Metric(
        "joint_gap",
        "Joint gap",
        "final performance of joint training − final performance",
        lambda run: (),
        LOWER,
        needs=("joint",),
        shown=("boards", "screen"),
        known_as="distance to multitask training",
        limits="Which part is due to the order: joint training also alternates between tasks.",
    ),
    Metric(
        "return_std",
        "Return standard deviation",
        "mean over j of the population standard deviation of the 20 normalized returns at stage T",
        lambda run: ((j, standard_deviation(run.final_episodes[j])) for j in run.scored),
        NOT_RANKED,
        protocols=(*IN_ORDER, "joint"),
        needs=("episodes",),
        shown=(),
        known_as="the paper's constrained variance",
        limits="Whether returns are good: failing at once every time has a small deviation.",
    ),
    Metric(
        "cvar_10",
        "CVaR 10\N{NO-BREAK SPACE}%",
        "mean over j of the mean of the ⌈n/10⌉ lowest normalized returns at stage T",
        lambda run: ((j, _lowest_tenth(run.final_episodes[j])) for j in run.scored),
        HIGHER,
        protocols=(*IN_ORDER, "joint"),
        needs=("episodes",),
        columns=("joint",),
        known_as="conditional value at risk, expected shortfall; worst tenth",
        limits="Rare failures: two of twenty episodes are averaged.",
    ),
    Metric(
        "practice",
        "Practice",
        "p_cumulative[T] − p_single[T]",
        lambda run: _last_task(run, lambda j: run.cumulative[j] - run.single_task[j]),
        NOT_RANKED,
        protocols=("sequential",),
        needs=("single", "cumulative"),
        shown=(),
        limits="Whether the earlier tasks helped: both policies saw the last task alone.",
    ),
    Metric(
        "transfer_at_equal_practice",
        "Transfer at equal practice",
        "p[T][T] − p_cumulative[T]",
        lambda run: _last_task(run, lambda j: run.p(j, j) - run.cumulative[j]),
        NOT_RANKED,
        protocols=("sequential",),
        needs=("cumulative",),
        shown=(),
        limits="Any task but the last.",
    ),
    Metric(
        "last_task_performance",
        "Last-task performance",
        "p_cumulative[T]",
        lambda run: _last_task(run, lambda j: run.p(j, j)),
        NOT_RANKED,
        protocols=("cumulative",),
        columns=("cumulative",),
        shown=("boards", "screen"),
        limits="Any task but the last, which alone was trained.",
    ),
    Metric(
        "single_task_performance",
        "Single-task performance",
        "mean over j of p_single[j]",
        lambda run: ((j, run.single_task[j]) for j in run.scored),
        HIGHER,
        protocols=("single",),
        columns=("single",),
        shown=("boards", "ranks", "screen", "alone"),
        known_as="the paper's Single Env",
        limits="Anything about several tasks.",
    ),
)
"""Every metric. To add one, add a row here and a worked example in ``conformance/``."""

BY_NAME = {metric.name: metric for metric in TABLE}
FINAL, LEARNING = BY_NAME["final_performance"], BY_NAME["learning_performance"]
FORGETTING, JOINT_GAP = BY_NAME["forgetting"], BY_NAME["joint_gap"]

METRICS: dict[str, tuple[Metric, ...]] = {
    protocol: tuple(metric for metric in TABLE if protocol in metric.protocols) for protocol in PROTOCOLS
}
"""The metrics of each protocol in the order of the table; the first one sorts the protocol's boards."""

BOARD_METRICS = {
    protocol: tuple(metric for metric in metrics if "boards" in metric.shown)
    for protocol, metrics in METRICS.items()
}
"""The metrics of each protocol that boards have."""

COLUMNS = {
    protocol: tuple(metric.name for metric in metrics if protocol in metric.columns)
    for protocol, metrics in METRICS.items()
}
"""The names of the metrics that are columns of a protocol's boards on pages."""

CORE_METRICS = tuple(metric.name for metric in TABLE if "core" in metric.shown)
"""The names of the metrics of the core board. A submission without a value of one of them has no score."""


def area(steps: Sequence[int], values: Sequence[float], end: float) -> float | None:
    """(1/D) ∫₀ᴰ of a curve by trapezoids, constant before its first and after its last point.

    Its steps ascend from 1 and are cut off at ``end``, D, the budget's training steps. None with fewer than
    ten points. Raises ``BenchError`` for another curve (``bad-curve``).
    """
    given = numbers("area", [*steps, *values])
    faults = {
        f"It has {len(steps)} steps and {len(values)} values.": len(steps) != len(values),
        f"Its end is {end}.": not 0 < end < math.inf,
        "A step or a value is not a finite number.": not np.isfinite(given).all(),
        "Its steps do not ascend from 1.": any(a >= b for a, b in pairwise((0, *steps))),
    }
    if fault := next((text for text, is_fault in faults.items() if is_fault), ""):
        hint = "Give ascending steps, as many values, and an end above 0."
        raise BenchError("bad-curve", fault, "area", hint)
    if len(steps) < CURVE_POINTS:
        return None
    points = [(0.0, values[0]), *zip(map(float, steps), values, strict=True)]
    if steps[-1] <= end:
        points.append((float(end), values[-1]))
    else:  # the curve's value at the end in place of the points after it
        beyond = next(index for index, (x, _) in enumerate(points) if x >= end)
        (x0, y0), (x1, y1) = points[beyond - 1], points[beyond]
        points[beyond:] = [(float(end), y0 + (y1 - y0) * (float(end) - x0) / (x1 - x0))]
    return math.fsum([(x1 - x0) * (y0 + y1) / 2 for (x0, y0), (x1, y1) in pairwise(points)]) / end


THRESHOLDS = tuple(step / 20 for step in range(-10, 41))
"""τ from −.5 to 2 in steps of .05."""


@dataclass(frozen=True, slots=True)
class Profile:
    """Performance profile: for each τ the fraction of (run, task) pairs with a score above it."""

    tau: Annotated[tuple[float, ...], about("scores τ, ascending")]
    fraction: Annotated[tuple[float, ...], about("for each τ the fraction of pairs with p[T][j] > τ")]

    @property
    def points(self) -> tuple[tuple[float, float], ...]:
        """Pairs (τ, fraction), by τ."""
        return tuple(zip(self.tau, self.fraction, strict=True))


def numbers(name: str, given: ArrayLike) -> Array:
    """An array of floats. Raises ``BenchError`` (``bad-matrix``) for ragged rows and for text."""
    try:
        return np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        message = "It is not an array of numbers."
        raise BenchError("bad-matrix", message, name, "Give rows of equal length.") from error


def finite(name: str, given: ArrayLike) -> Array:
    """An array of finite numbers. Raises ``BenchError`` (``bad-matrix``) for anything else."""
    array = numbers(name, given)
    if not np.isfinite(array).all():
        index = tuple(np.argwhere(~np.isfinite(array))[0].tolist())
        message, hint = f"The value at index {list(index)} is {array[index]}.", "Leave out what has no value."
        raise BenchError("bad-matrix", message, name, hint)
    return array


def profile(scores: ArrayLike) -> Profile | None:
    """The performance profile of scores (runs, tasks), or None without scores.

    Raises ``BenchError`` for a score that is not finite (``bad-matrix``), as :func:`iqm` does.
    """
    values = finite("scores", scores)
    if not values.size:
        return None
    return Profile(THRESHOLDS, tuple(float(np.mean(values > threshold)) for threshold in THRESHOLDS))


def iqm(scores: ArrayLike) -> Number:
    """Mean of the scores (runs, tasks) without the lowest and highest ⌊n/4⌋, or None without scores."""
    values = np.sort(finite("scores", scores), axis=None)
    cut = values.size // 4
    return mean(values[cut : values.size - cut])


def probability_of_improvement(scores: ArrayLike, others: ArrayLike) -> float:
    """Mean over tasks of the probability that a run of ``scores`` is above a run of ``others``.

    Ties count one half (Agarwal et al. 2021, "Deep Reinforcement Learning at the Edge of the Statistical
    Precipice", section 4.3).

    Args:
        scores: shape (runs, tasks).
        others: shape (runs, tasks), of the same tasks; the number of runs may differ.

    Raises:
        BenchError: ``bad-matrix`` for a score that is not finite, or for other shapes.
    """
    first, second = finite("scores", scores), finite("others", others)
    are_matrices = first.ndim == second.ndim == 2 and first.size and second.size
    if not are_matrices or first.shape[1] != second.shape[1]:
        message = f"The shapes {first.shape} and {second.shape} are not (runs, tasks) of the same tasks."
        raise BenchError("bad-matrix", message, "scores", "Give one row per run and one column per task.")
    differences = first[:, None] - second[None]
    return float(np.mean((np.sign(differences) + 1.0) / 2.0))
