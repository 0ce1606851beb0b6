"""Boards and comparisons as typed documents, and which boards a scorecard is on.

docs/scorecard.md describes every key.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Literal, TypeVar

from gym_extensions.catalog.groups import CORE, CORES, SUITES
from gym_extensions.catalog.protocol import BUDGETS, PROTOCOLS, STANDARD_BUDGET
from gym_extensions.documents import JsonDocument, about
from gym_extensions.errors import BenchError
from gym_extensions.metrics import formulas, statistics, values
from gym_extensions.scoring.group_score import GroupScore, SuiteScore
from gym_extensions.scoring.scorecard import CoreGroup, CoreRuns, Scorecard
from gym_extensions.scoring.submission.core_score import core_logs, mean_over_groups
from gym_extensions.scoring.submission.suites import estimate
from gym_extensions.submissions import manifest, review, run


@dataclass(frozen=True, slots=True)
class Difference(values.Estimate):
    """The difference of two means, with Welch's 95 % interval and test for this pair alone."""

    mean: Annotated[float, about("difference of the means")]
    p_value: Annotated[float | None, about("two-sided p value of no difference; null with one run")] = None

    @classmethod
    def of(cls, first: statistics.Summary, second: statistics.Summary) -> Difference:
        """first − second."""
        between = statistics.subtract(first, second)
        interval = statistics.to_interval(between)
        p_value = None if interval.low is None else statistics.zero_mean_p(between)
        return cls(interval.mean, interval.low, interval.high, p_value)


@dataclass(frozen=True, slots=True)
class BoardMetric(values.Estimate):
    """A metric of a submission: the scorecard's value, and its rank on this board."""

    why: Annotated[str, about("as in the scorecard")] = ""
    rank: Annotated[tuple[int, int] | None, about("`[first, last]` possible rank; null without one")] = None
    rank_note: Annotated[str, about("why it has no rank where its submission has one; else empty")] = ""

    @classmethod
    def of(cls, value: values.MetricValue, rank_note: str = "") -> BoardMetric:
        """The value of a scorecard, without a rank yet."""
        return cls(value.mean, value.low, value.high, value.why, rank_note=rank_note)


@dataclass(frozen=True, slots=True)
class Versus:
    """A ranked submission against another one, on the metric that sorts the board."""

    name: Annotated[str, about("the other submission")]
    difference: Annotated[Difference, about("the submission that is above − the one that is below")]
    separated: Annotated[bool, about("whether the board's test, over all pairs, separates the two")]


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardRow:
    """One submission on one board."""

    name: Annotated[str, about("as in the scorecard")]
    title: Annotated[str, about("as in the scorecard")]
    level: Annotated[review.Level, about("lowest level of the submission's logs on this board")]
    runs: Annotated[int, about("number of runs; on a suite the fewest of its groups")]
    ranked: Annotated[bool, about("whether the board ranks it")]
    why: Annotated[
        str, about("why it has no rank: reported, a copy, not verified, too few runs, no score; else empty")
    ] = ""
    steps_counted: Annotated[bool, about("whether the loop counted the training steps of its runs")] = True
    evaluation: Annotated[manifest.Evaluation | None, about("as in the scorecard's manifest")]
    authors: Annotated[tuple[str, ...], about("as in the scorecard's manifest")] = ()
    accepted: Annotated[str, about("date of its last acceptance, YYYY-MM-DD; empty without one")] = ""
    observes: Annotated[manifest.Observes | None, about("as in the scorecard's manifest")]
    memory: Annotated[run.Memory | None, about("as in the scorecard's manifest")]
    metrics: Annotated[dict[str, BoardMetric], about("every metric of the board by name")]
    related: Annotated[tuple[str, ...], about("others with a common author and family of algorithms")] = ()
    vs_next: Annotated[Versus | None, about("the ranked submission below it; null for the last")] = None
    vs_leader: Annotated[Versus | None, about("the first submission; null for itself and without a rank")] = (
        None
    )
    alike: Annotated[str, about("that its runs on a group are unusually alike, in words; else empty")] = ""
    duplicate_of: Annotated[str | None, about("the submission above it that it is a copy of; or null")] = None


@dataclass(frozen=True, slots=True)
class ComputedRow:
    """An agent whose row is computed from the references: never ranked, and no submission."""

    name: Annotated[str, about("`alone`, `trpo` on each task alone; `random`, `zero`, the floor")]
    title: Annotated[str, about("its name on pages")]
    metrics: Annotated[dict[str, BoardMetric], about("of the board by name; intervals of `alone` only")]


@dataclass(frozen=True, slots=True)
class Pair:
    """Two submissions of a board."""

    first: Annotated[str, about("name of the submission that is above")]
    second: Annotated[str, about("name of the submission that is below")]
    metrics: Annotated[dict[str, Difference], about("first − second, of all metrics of both, by name")]


@dataclass(frozen=True, slots=True)
class Lead:
    """The first submission of a board, and how certain its lead is."""

    name: Annotated[str, about("the first ranked submission; without one the first with a score")]
    certainty: Annotated[str, about("a sentence from rank intervals, or without ranks, intervals")]


@dataclass(frozen=True, slots=True)
class Board:
    """Submissions of one group or suite, protocol and budget."""

    group: Annotated[str, about("group id or suite name")]
    published: Annotated[bool, about("false for a custom group, which `score --groups` adds")]
    protocol: Annotated[str, about("name of the protocol")]
    budget: Annotated[str, about("name of the budget")]
    task_conditioned: Annotated[bool, about("whether its agents observe the task in evaluation")]
    ranked: Annotated[int, about("M, the number of ranked submissions")]
    rows: Annotated[tuple[BoardRow, ...], about("ranked by the first metric, best first; then the others")]
    computed: Annotated[tuple[ComputedRow, ...], about("rows computed from the references")] = ()
    pairs: Annotated[tuple[Pair, ...], about("of the first 60 rows, not corrected for their number")] = ()
    lead: Annotated[Lead | None, about("who is first; null without a score")] = None
    least_forgetting: Annotated[
        str | None, about("the ranked submission with the least forgetting of those that learned; or null")
    ] = None

    @property
    def id(self) -> str:
        """Its name, for example ``hopper-gravity-v0-sequential-100k``."""
        conditioned = ("task-conditioned",) if self.task_conditioned else ()
        return "-".join((self.group, self.protocol, self.budget, *conditioned))


@dataclass(frozen=True, slots=True)
class TaskBest:
    """A verified submission with one of the highest returns on a task at the end of sequential training."""

    name: Annotated[str, about("as in the scorecard")]
    title: Annotated[str, about("as in the scorecard")]
    board: Annotated[str, about("name of the board")]
    group: Annotated[str, about("group id of the board")]
    budget: Annotated[str, about("name of the budget")]
    task_conditioned: Annotated[bool, about("whether its agent observes the task in evaluation")]
    learned: Annotated[float | None, about("mean return right after the training on the task")]
    end: Annotated[float, about("mean return at the end")]


@dataclass(frozen=True, slots=True, kw_only=True)
class CoreRow(CoreRuns):
    """One method on the core: the submissions with sequential logs on a group of it."""

    name: Annotated[str, about("as in the scorecard")]
    title: Annotated[str, about("as in the scorecard")]
    level: Annotated[review.Level, about("lowest level of the submission's logs on the core")]
    ranked: Annotated[bool, about("whether it is compared with the others")]
    why: Annotated[str, about("why it has no rank: claimed, a copy, groups or runs missing; else empty")] = ""
    observes: Annotated[manifest.Observes | None, about("as in the scorecard's manifest")]
    metrics: Annotated[
        dict[str, BoardMetric],
        about("means over groups, over runs 0 to n − 1; ranks of `final_performance` and `forgetting`"),
    ]
    alike: Annotated[str, about("that its runs on a group are unusually alike, in words; else empty")] = ""

    @property
    def task_conditioned(self) -> bool:
        """Whether the agent observes the task in evaluation, which decides on its list."""
        return self.observes is not None and self.observes.task_in_evaluation


@dataclass(frozen=True, slots=True, kw_only=True)
class CoreList:
    """One of the two ranked lists of the core. Ranks count the methods of the list alone."""

    task_conditioned: Annotated[bool, about("whether its agents observe the task in evaluation")]
    ranked: Annotated[int, about("M, the number of ranked submissions")]
    rows: Annotated[tuple[CoreRow, ...], about("ranked ones by the core score, best first; then others")]


@dataclass(frozen=True, slots=True)
class VariantScore(values.Estimate):
    """A ranked submission on a variant of the core."""

    place: Annotated[int, about("its place by the mean in its list, from 1; ties share one")] = 1
    rank: Annotated[
        tuple[int, int] | None, about("`[first, last]` possible rank in its list; null without a test")
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CoreVariant:
    """The core without some groups, or with another mean: how far the answer depends on them."""

    name: Annotated[str, about("`without-Hopper`, `without-wall`, …; `interquartile-mean`")]
    title: Annotated[str, about("the same in words")]
    groups: Annotated[tuple[str, ...], about("ids of the groups that count")]
    scores: Annotated[dict[str, VariantScore], about("of every ranked submission by name")]


@dataclass(frozen=True, slots=True, kw_only=True)
class CoreReference:
    """The reference agent on the core, not trained on a sequence of tasks, and so without a rank."""

    name: Annotated[str, about("`joint` (all tasks of a group at once) or `alone` (each task alone)")]
    title: Annotated[str, about("the same in words")]
    runs: Annotated[int, about("n: the mean is over runs 0 to n − 1 of every group")]
    value: Annotated[BoardMetric, about("its score at the end: the mean over groups, with its 95 % interval")]
    groups: Annotated[dict[str, CoreGroup], about("its score by group id")]


AnyRow = TypeVar("AnyRow", BoardRow, CoreRow)
Verdict = Literal["separated", "equivalent", "open"]


@dataclass(frozen=True, slots=True)
class CorePair:
    """Two ranked submissions of the core on one metric, over all groups."""

    first: Annotated[str, about("name of a submission")]
    second: Annotated[str, about("name of a submission that is below it, in the order of the rows")]
    look: Annotated[int, about("n: compared are the runs 0 to n − 1 of every group of both")]
    paired: Annotated[bool, about("paired by run (equal parents and first stages), else Welch's test")]
    mean: Annotated[float, about("mean over groups of the difference of means, first − second")]
    low: Annotated[float, about("lower end of the interval, adjusted for all pairs and looks")]
    high: Annotated[float, about("upper end of the interval, adjusted for all pairs and looks")]
    p_value: Annotated[float, about("adjusted for all pairs (Holm) and looks; at most .05 if separated")]
    verdict: Annotated[Verdict, about("`separated`, `equivalent` (interval inside the margin), or `open`")]
    exploratory: Annotated[
        bool, about("false if the plan names the pair, and its methods alone have ten runs")
    ]
    next_look: Annotated[int | None, about("the look that may decide it; null if decided or after the last")]


@dataclass(frozen=True, slots=True, kw_only=True)
class CoreBoard:
    """One row per method, over all groups of the core, in two lists, and every pair of ranked methods."""

    suite: Annotated[str, about("name of the list of groups, with its version")]
    edition: Annotated[int, about("of the comparisons: 1 of verified runs, 2 of runs that were trained here")]
    groups: Annotated[tuple[str, ...], about("group ids")]
    budget: Annotated[str, about("name of the budget")]
    looks: Annotated[tuple[int, ...], about("numbers of runs at which submissions are compared")]
    levels: Annotated[tuple[float, ...], about("family-wise error rate over all pairs at each look")]
    margin: Annotated[float, about("two are equivalent if the interval of their difference lies in ± this")]
    lists: Annotated[
        tuple[CoreList, ...], about("without the task label in evaluation, then with it; none is empty")
    ]
    references: Annotated[tuple[CoreReference, ...], about("`trpo` trained in other ways")] = ()
    pairs: Annotated[
        dict[str, tuple[CorePair, ...]],
        about(
            "of ranked submissions of both lists by metric: `final_performance`, and `forgetting` of those "
            "that learned"
        ),
    ]
    variants: Annotated[tuple[CoreVariant, ...], about("scores and ranks without some groups")] = ()

    @property
    def rows(self) -> tuple[CoreRow, ...]:
        """The submissions of both lists."""
        return tuple(row for each in self.lists for row in each.rows)

    def pair(self, metric: str, first: str, second: str) -> CorePair | None:
        """The pair of two submissions, in any order; None if they are not compared."""
        names = {first, second}
        return next((pair for pair in self.pairs[metric] if {pair.first, pair.second} == names), None)


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardsDocument(JsonDocument):
    """Every board."""

    format: Annotated[Literal[1], about("1")] = 1
    core: Annotated[CoreBoard | None, about("one row per method; null without a submission on the core")] = (
        None
    )
    boards: Annotated[tuple[Board, ...], about("boards of groups, then of suites")]
    best: Annotated[
        dict[str, tuple[TaskBest, ...]],
        about("by task id the submissions with the highest returns at the end"),
    ] = field(default_factory=dict)


@dataclass(frozen=True)
class Comparison:
    """Two submissions on the core, or on one group or suite, under one protocol with one budget.

    ``metrics`` has of every metric of both, by name: both means, and the first minus the second. On the core
    they are over the runs 0 to ``look`` − 1.
    """

    name: str
    protocol: str
    budget: str
    metrics: dict[str, tuple[float, float, Difference]]
    look: int = 0


def compare(first: Scorecard, second: Scorecard) -> list[Comparison]:
    """What two submissions without problems have in common: the core, groups, then suites.

    The core is compared over the runs of the last look that both have. The intervals are Welch's 95 %
    intervals for this one pair, not corrected for multiple comparisons.

    Raises:
        BenchError: the two have no group with the same protocol and budget.
    """
    found = []
    if look := min(card.core.look if card.core else 0 for card in (first, second)):
        logs = [core_logs(card).values() for card in (first, second)]
        core = {}
        for name in formulas.CORE_METRICS:
            mean, other = (mean_over_groups(each, name, look) for each in logs)
            core[name] = mean.mean, other.mean, Difference.of(mean, other)
        found.append(Comparison(CORE, "sequential", STANDARD_BUDGET, core, look))
    others = {(name, protocol, score.budget) for name, protocol, score in second.scores()}
    for name, protocol, score in first.scores():
        if (name, protocol, score.budget) in others:
            metrics, groups = {}, SUITES.get(name, (name,))
            for metric in formulas.METRICS[protocol]:
                a, b = (estimate(card.groups, groups, protocol, metric) for card in (first, second))
                if a is not None and b is not None:
                    metrics[metric.name] = a.mean, b.mean, Difference.of(a, b)
            found.append(Comparison(name, protocol, score.budget, metrics))
    if not found:
        message = f"{first.name} and {second.name} have no group with the same protocol and budget."
        raise BenchError("nothing-to-compare", message, hint="Compare submissions of one board.")
    return found


@dataclass(frozen=True, order=True)
class BoardKey:
    """Group or suite, protocol and budget of a board, and whether agents observe the task in evaluation."""

    group: str
    protocol: str
    budget: str
    task_conditioned: bool

    @property
    def groups(self) -> tuple[str, ...]:
        """The groups that the board's scores are means over."""
        return {**SUITES, **CORES}.get(self.group, (self.group,))


def lookup(card: Scorecard, key: BoardKey) -> GroupScore | SuiteScore | None:
    """The scores of a submission on a board, or None if it is not on it."""
    score = (card.suites if key.group in SUITES else card.groups).get(key.group, {}).get(key.protocol)
    on_board = score is not None and score.budget == key.budget and not card.withdrawn
    return score if on_board and is_task_conditioned(card) == key.task_conditioned else None


def logs_on(card: Scorecard, key: BoardKey, protocol: str = "") -> dict[str, GroupScore]:
    """A submission's logs of a protocol (the board's if empty) on the groups of a board, by group id."""
    return {name: log for name in key.groups if (log := card.log(name, protocol or key.protocol))}


def board_level(card: Scorecard, key: BoardKey, protocol: str = "") -> review.Level:
    """The lowest level of these logs."""
    levels = [log.level for log in logs_on(card, key, protocol).values()]
    return min(levels, key=review.LEVELS.index, default=review.VERIFIED)


def is_task_conditioned(card: Scorecard) -> bool:
    """Whether the agent observes the task in evaluation. Such submissions have separate boards."""
    return card.manifest is not None and card.manifest.observes.task_in_evaluation


def best_first(submissions: Iterable[AnyRow], metric: formulas.Metric) -> list[AnyRow]:
    """Ranked submissions, then the others; the best on a metric first, those without a value last."""

    def order(submission: AnyRow) -> tuple[bool, float, str]:
        mean = submission.metrics[metric.name].mean
        return not submission.ranked, math.inf if mean is None else -mean, submission.name

    return sorted(submissions, key=order)


def board_keys(cards: Sequence[Scorecard]) -> list[BoardKey]:
    """Every board that the scorecards have a submission for, sorted, with groups before suites."""
    keys = {
        BoardKey(name, protocol, score.budget, is_task_conditioned(card))
        for card in cards
        if not card.withdrawn
        for name, protocol, score in card.scores()
        if BUDGETS[score.budget].on_boards and protocol != "cumulative"  # a control, not a contest
    }
    budgets, protocols = list(BUDGETS), list(PROTOCOLS)

    def order(key: BoardKey) -> tuple[object, ...]:
        places = protocols.index(key.protocol), budgets.index(key.budget)
        return key.group in SUITES, key.group, *places, key.task_conditioned

    return sorted(keys, key=order)
