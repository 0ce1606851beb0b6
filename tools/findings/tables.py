"""The tables of docs/findings.md, from the data frames of ``gym_extensions.results``."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from gym_extensions import results
from gym_extensions.catalog.groups import CORES, GROUPS, TaskGroup
from gym_extensions.catalog.protocol import FULL_SUBMISSION_RUNS, STANDARD_BUDGET
from gym_extensions.metrics import probability_of_improvement
from gym_extensions.metrics.statistics import Interval, difference, holm, subtract, summary, zero_mean_p
from gym_extensions.metrics.values import Estimate
from gym_extensions.references import load_references, trained_alone
from gym_extensions.scoring.ranking.boards import CoreBoard
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.core_score import core_logs, final_scores, last_look
from gym_extensions.site.text import fixed, interval
from gym_extensions.submissions.landscapes import SHARES

FINE_TUNING = "trpo"
LEARNED, FINAL, LOST = "learning_performance", "final_performance", "forgetting"
COLUMNS = (LEARNED, FINAL, LOST)
REPLAY = ("sac", "sac-fresh-buffer")
"""The same learner with its replay buffer kept across tasks, and emptied."""
TRANSFERS = (
    "zero_shot_transfer",
    "generalization_to_unseen_tasks",
    "asymptotic_transfer",
    "forward_transfer_auc",
    "joint_gap",
    "practice",
    "transfer_at_equal_practice",
)
TUNED = ("cloning", "l2", "l2-init", "online-ewc", "packnet", "ppo")
"""Methods that have other settings in the second edition of the core, as submissions of their own."""
WORDS = {LEARNED: "learned", FINAL: "at the end", LOST: "forgetting"}
"""The metrics of ``COLUMNS`` in words."""
VERDICTS = {"separated": "significant", "equivalent": "equivalent", "open": "not significant"}
"""The verdicts of the core in words."""
CORE = [GROUPS[name.removesuffix("-v0")] for name in CORES["core-v1"]]


class Value(NamedTuple):
    """A mean with its interval; NaN where there is none."""

    mean: float
    low: float
    high: float

    @classmethod
    def of(cls, each: Interval | Estimate) -> Value:
        """The value of an interval or a metric."""
        return cls(*(math.nan if end is None else end for end in (each.mean, each.low, each.high)))

    def __neg__(self) -> Value:
        return Value(-self.mean, -self.high, -self.low)

    @property
    def is_known(self) -> bool:
        """Whether there is a mean."""
        return not math.isnan(self.mean)

    def __str__(self) -> str:
        if not self.is_known:
            return "–"
        if math.isnan(self.low):
            return f"{fixed(self.mean, 2)} (one run)"
        return f"{fixed(self.mean, 2)} ({interval(self.low, self.high, 2)})"

    @property
    def interval(self) -> str:
        """The interval alone."""
        return interval(self.low, self.high, 2)


NONE = Value(math.nan, math.nan, math.nan)


def values_of(frame: pd.DataFrame) -> list[Value]:
    """The values of the rows of a frame with the columns ``mean``, ``low`` and ``high``."""
    return [Value(*row) for row in frame[list(Value._fields)].itertuples(index=False)]


def of_edition(name: str, edition: int) -> str:
    """The submission of a method in an edition of the core."""
    return f"{name}-tuned" if edition > 1 and name in TUNED else name


def percent(share: Value) -> str:
    """A share in percent, with its interval."""
    if not share.is_known:
        return "–"
    mean, low, high = (100 * each for each in share)
    return f"{fixed(mean, 0)} % ({interval(low, high, 0)})"


class Against(NamedTuple):
    """A method minus another one, over the core: the adjusted interval, the verdict, whether no plan named
    the pair, and the adjusted p value.
    """

    value: Value
    verdict: str
    exploratory: bool
    p_value: float

    def said(self, edition: int) -> str:
        """The verdict in words. Bold is what a plan named alone, of which the first edition has nothing."""
        word = VERDICTS[self.verdict]
        if self.exploratory:
            return word if edition == 1 else f"{word}, exploratory"
        return f"**{word}**" if self.verdict == "separated" else word


@dataclass(frozen=True)
class Method:
    """A row of the core board, and its differences from fine-tuning by metric; none without a rank."""

    row: pd.Series
    against: dict[str, Against]

    def value(self, metric: str) -> Value:
        """A metric over all groups of the core."""
        return Value(*(self.row[f"{metric}{end}"] for end in ("", "_low", "_high")))

    @property
    def observes_task(self) -> bool:
        """Whether the agent observes the task in evaluation."""
        return bool(self.row["observes_task"])

    @property
    def kept(self) -> str:
        """The share of what was learned that is kept, in percent, with its interval."""
        return percent(self.value("retention"))

    @property
    def rank(self) -> str:
        """The possible ranks, such as ``1–3``."""
        first, last = self.row["rank_first"], self.row["rank_last"]
        return f"{first}" if first == last else f"{first}–{last}"


def against(board: CoreBoard, metric: str, name: str, other: str) -> Against | None:
    """A method minus another one; None if they are not compared."""
    if (pair := board.pair(metric, name, other)) is None:
        return None
    value = Value(pair.mean, pair.low, pair.high)
    return Against(value if pair.first == name else -value, pair.verdict, pair.exploratory, pair.p_value)


def methods(core: pd.DataFrame, board: CoreBoard) -> list[Method]:
    """The ranked methods of the core, best first."""
    found = []
    for _, row in core[core["ranked"]].iterrows():
        compared = {metric: against(board, metric, row["name"], FINE_TUNING) for metric in (FINAL, LOST)}
        found.append(Method(row, {metric: each for metric, each in compared.items() if each}))
    return found


def improvements(methods: Sequence[Method], cards: Mapping[str, Scorecard]) -> list[tuple[str, float]]:
    """The probability of improvement over fine-tuning, by name, over the runs of the last look of both."""
    looks = {method.row["name"]: int(method.row["look"]) for method in methods}
    found = []
    for name in looks:
        if name != FINE_TUNING:
            names = name, FINE_TUNING
            runs = min(looks[each] for each in names)
            both = (np.hstack(final_scores(core_logs(cards[each]).values(), runs)) for each in names)
            found.append((name, probability_of_improvement(*both)))
    return found


def value(metrics: pd.DataFrame, name: str, group: str, metric: str, protocol: str = "sequential") -> Value:
    """A metric of a submission on a group or suite, at the standard budget."""
    found = metrics[
        (metrics["name"] == name)
        & (metrics["group"] == group)
        & (metrics["metric"] == metric)
        & (metrics["protocol"] == protocol)
        & (metrics["budget"] == STANDARD_BUDGET)
    ]
    return next(iter(values_of(found)), NONE)


def by_group(metrics: pd.DataFrame, names: Sequence[str], metric: str) -> list[tuple[str, list[Value]]]:
    """A metric of submissions on every group of the core; submissions with five runs on one of them."""
    full = metrics[metrics["runs"] >= FULL_SUBMISSION_RUNS]
    rows = [(name, [value(full, name, group.id, metric) for group in CORE]) for name in names]
    return [row for row in rows if any(each.is_known for each in row[1])]


@dataclass(frozen=True)
class Forgetting:
    """Fine-tuning on a group: the metrics of ``COLUMNS``, and whether the corrected test finds forgetting."""

    group: TaskGroup
    runs: int
    metrics: Mapping[str, Value]
    significant: bool

    @property
    def is_learned(self) -> bool:
        """Whether its score right after training is above the floor, by its interval."""
        return self.metrics[LEARNED].low > 0


def fine_tuning(metrics: pd.DataFrame, runs: dict[str, Sequence[float]]) -> list[Forgetting]:
    """Fine-tuning on every group with a score, the most forgetting first.

    Args:
        metrics: of ``results.metrics``.
        runs: forgetting of each run, by group id. A t test per group that was learned, with Holm's correction
            over those of the core and over the others, finds where its mean differs from 0. It tests the runs
            of the last look alone; all runs if there are too few for a look.
    """
    found = {}
    for group in GROUPS.values():
        values = {metric: value(metrics, FINE_TUNING, group.id, metric) for metric in COLUMNS}
        if all(each.is_known for each in values.values()):
            found[group.id] = Forgetting(group, len(runs[group.id]), values, significant=False)
    for on_core in (True, False):
        family = [each for each in found.values() if each.is_learned and (each.group in CORE) == on_core]
        tested = [runs[each.group.id][: last_look(each.runs) or None] for each in family]
        rejected = holm(np.array([zero_mean_p(summary(part)) for part in tested]))
        for each, is_significant in zip(family, rejected, strict=True):
            found[each.group.id] = replace(each, significant=bool(is_significant))
    return sorted(found.values(), key=lambda each: -each.metrics[LOST].mean)


def transfers(metrics: pd.DataFrame) -> list[tuple[str, list[Value]]]:
    """The transfers of fine-tuning by group that it learned, the groups with most values first."""
    rows = []
    for group in GROUPS.values():
        values = [value(metrics, FINE_TUNING, group.id, metric) for metric in TRANSFERS]
        is_learned = value(metrics, FINE_TUNING, group.id, LEARNED).low > 0
        if is_learned and any(each.is_known for each in values):
            rows.append((group.name, values))
    return sorted(rows, key=lambda row: -sum(each.is_known for each in row[1]))


def practice_by_other_runs(evaluations: pd.DataFrame) -> list[tuple[str, Value]]:
    """Practice on the groups without single runs: the cumulative runs minus those of version 1's references.

    Args:
        evaluations: mean returns of fine-tuning, from ``results.evaluations``.
    """
    rows = []
    for group in GROUPS.values():
        protocols = dict(list(evaluations[evaluations["group"] == group.id].groupby("protocol")))
        task = group.task_ids[-1]
        if "cumulative" in protocols and "single" not in protocols and task in trained_alone():
            last = protocols["cumulative"].query("task == @task and stage == stage.max()")["return"]
            normalize = load_references().tasks[task].normalize
            alone = [normalize(run.mean) for run in trained_alone()[task].runs]
            gap = difference([normalize(each) for each in last], alone)
            rows.append((group.name, Value.of(gap)))
    return rows


def replay(runs: dict[str, dict[str, Sequence[float]]]) -> list[tuple[str, Value, float]]:
    """A metric of SAC with its replay buffer minus SAC without: group, difference, p value (Welch).

    Args:
        runs: the metric of each run, by submission and group id.
    """
    rows = []
    for group in CORE:
        kept, emptied = (runs.get(name, {}).get(group.id, ()) for name in REPLAY)
        if min(len(kept), len(emptied)) >= FULL_SUBMISSION_RUNS:
            gap = difference(kept, emptied)
            p_value = zero_mean_p(subtract(summary(kept), summary(emptied)))
            rows.append((group.name, Value.of(gap), p_value))
    return rows


def between_and_beyond(shares: pd.DataFrame) -> list[tuple[str, str, Value, Value]]:
    """Interpolation and extrapolation on the groups of the core: group, submission, both values.

    Args:
        shares: from ``results.landscapes``.
    """
    rows = []
    for group in CORE:
        values = []
        for name, found in shares[shares["group"] == group.id].groupby("submission"):
            known = dict(zip(found["share"], values_of(found), strict=True))
            between, beyond = (known.get(share, NONE) for share in SHARES)
            values.append((group.name, str(name), between, beyond))
        if len(values) > 1:  # the best of one submission is its own
            rows += sorted(values, key=lambda row: -(row[2] if row[2].is_known else row[3]).mean)
    return rows


def predictors(policies: pd.DataFrame) -> list[tuple[str, list[Value]]]:
    """What predicts forgetting, by submission: of KL and of distance the correlation across and within tasks.

    Args:
        policies: from ``results.policies``.
    """
    places = [(predictor, kind) for predictor in ("drift", "distances") for kind in ("across", "within")]
    rows = []
    for name, found in results.forgetting_predictors(policies).groupby("submission", sort=False):
        known = dict(zip(zip(found["predictor"], found["kind"], strict=True), values_of(found), strict=True))
        rows.append((str(name), [known.get(place, NONE) for place in places]))
    return rows


class Change(NamedTuple):
    """The change of a number from the first task to the last one, and its means at the stages."""

    mean: float
    low: float
    high: float
    untrained: float
    first: float
    last: float

    def __str__(self) -> str:
        return str(Value(*self[:3]))


def network_changes(policies: pd.DataFrame) -> list[tuple[str, list[Change]]]:
    """Rank, then inactive share, of the last hidden layer by submission.

    Args:
        policies: from ``results.policies``.
    """
    found = results.network_changes(policies).rename(columns={"change": "mean"})
    found = found[found["measure"] != "norms"]
    last = found[found["layer"] == found.groupby(["submission", "measure"])["layer"].transform("max")]
    return [
        (str(name), [Change(*row) for row in rows[list(Change._fields)].itertuples(index=False)])
        for name, rows in last.groupby("submission", sort=False)
    ]


def sides(rows: Sequence[tuple[str, Sequence[Value | Change]]], column: int) -> str:
    """The names whose interval in a column lies above 0, and below."""
    above = [f"`{name}`" for name, values in rows if values[column].low > 0]
    below = [f"`{name}`" for name, values in rows if values[column].high < 0]
    return f"above 0 for {', '.join(above) or 'none'}, below 0 for {', '.join(below) or 'none'}"


def open_tasks() -> dict[str, list[str]]:
    """The tasks without an expert, by name of the group."""
    references = load_references().tasks
    without = {name for name, reference in references.items() if reference.open}
    tasks = {
        group.name: [task.name for task in group.tasks if task.id in without] for group in GROUPS.values()
    }
    return {name: each for name, each in tasks.items() if each}


def most_forgotten(rows: Sequence[Forgetting], panels: int = 4) -> list[str]:
    """The groups whose intervals of forgetting lie farthest above 0, in the order of the rows."""
    lows = {row.group.name: row.metrics[LOST].low for row in rows if row.metrics[LOST].low > 0}
    chosen = sorted(lows, key=lambda name: -lows[name])[:panels]
    return [name for name in lows if name in chosen]


def scores_by_stage(card: Scorecard) -> pd.DataFrame:
    """The score on every task after every stage of the sequential runs, as ``plot_retention`` expects it."""
    rows = [
        (card.name, group, "sequential", run, stage, task, 0, float(stage), score)
        for group, protocols in card.groups.items()
        if (log := protocols.get("sequential"))
        for run, matrix in zip(log.runs, log.return_matrix, strict=True)
        for stage, means in enumerate(matrix)
        for task, mean in zip(log.tasks, means, strict=True)
        if (score := log.reference[task].normalize(mean)) is not None
    ]
    columns = ("submission", "group", "protocol", "run", "stage", "task", "step", "trained", "return")
    return pd.DataFrame(rows, columns=list(columns))
