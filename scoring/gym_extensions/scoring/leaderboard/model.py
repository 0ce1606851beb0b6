"""Boards and comparisons as typed documents. docs/scorecard.md describes every key."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from gym_extensions.rollouts.manifest import Evaluation, Memory, Observes, Steps
from gym_extensions.scoring.documents import JsonDocument, about
from gym_extensions.scoring.statistics.intervals import Interval


@dataclass(frozen=True, slots=True)
class Difference:
    """The difference of two means, with Welch's 95 % interval for this pair alone."""

    mean: Annotated[float, about("difference of the means")]
    low: Annotated[float | None, about("lower end; null where an entry has one run")]
    high: Annotated[float | None, about("upper end; null where an entry has one run")]

    @classmethod
    def of(cls, interval: Interval) -> Difference:
        """The mean and the ends of an interval."""
        return cls(interval.mean, interval.low, interval.high)


@dataclass(frozen=True, slots=True)
class BoardMetric:
    """A metric of an entry: the scorecard's value, and its rank on this board."""

    mean: Annotated[float | None, about("as in the scorecard")]
    low: Annotated[float | None, about("as in the scorecard")]
    high: Annotated[float | None, about("as in the scorecard")]
    why: Annotated[str, about("as in the scorecard")]
    rank: Annotated[tuple[int, int] | None, about("`[first, last]` possible rank; null without a rank")] = (
        None
    )
    rank_note: Annotated[
        str, about("why forgetting has no rank: nothing was learned that could be forgotten; else empty")
    ] = ""


@dataclass(frozen=True, slots=True)
class VersusNext:
    """A ranked entry against the ranked entry below it."""

    name: Annotated[str, about("the entry below")]
    difference: Annotated[Difference, about("of the metric that sorts the board")]
    separated: Annotated[bool, about("whether the board's test separates the two")]
    more_runs: Annotated[
        int | None,
        about("about how many more runs each would separate them; 0 if separated, null beyond 100 runs each"),
    ]


@dataclass(frozen=True, slots=True)
class VersusLeader:
    """A ranked entry against the first entry of the board."""

    name: Annotated[str, about("the first entry")]
    difference: Annotated[Difference, about("first − this entry, of the metric that sorts the board")]
    separated: Annotated[
        bool,
        about("whether Welch's test separates the two, with Holm's correction over the M − 1 such tests"),
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardEntry:
    """One submission on one board."""

    name: Annotated[str, about("as in the scorecard")]
    title: Annotated[str, about("as in the scorecard")]
    trust: Annotated[str | None, about("as in the scorecard")]
    runs: Annotated[int, about("number of runs; on a suite the fewest of its groups")]
    ranked: Annotated[bool, about("whether the board ranks it")]
    why: Annotated[
        str,
        about(
            "why it is not ranked: fewer than five runs, missing traces, reported, a copy, no score; else "
            "empty"
        ),
    ] = ""
    steps: Annotated[
        Steps | None, about("whether the training steps are `recorded` or `claimed`, as in the manifest")
    ]
    evaluation: Annotated[
        Evaluation | None, about("how actions are selected in evaluation, as in the scorecard's manifest")
    ]
    authors: Annotated[tuple[str, ...], about("as in the scorecard's manifest")] = ()
    accepted: Annotated[
        str, about("date on which the ledger accepted its files, YYYY-MM-DD; empty if it did not")
    ] = ""
    observes: Annotated[Observes | None, about("as in the scorecard's manifest")]
    memory: Annotated[Memory | None, about("as in the scorecard's manifest")]
    metrics: Annotated[dict[str, BoardMetric], about("every metric of the protocol by name")]
    related: Annotated[
        tuple[str, ...],
        about(
            "other entries of the board with a common author and the same family of algorithms (the name of "
            "the algorithm up to its first dash), sorted"
        ),
    ] = ()
    vs_next: Annotated[VersusNext | None, about("ranked entries but the last; else null")] = None
    vs_leader: Annotated[VersusLeader | None, about("ranked entries but the first; else null")] = None
    duplicate_of: Annotated[
        str | None,
        about(
            "the entry above it with most of the same episodes after the last stage in half of its runs. "
            "Agents without randomness rightly have them; otherwise one is a copy. Null without one"
        ),
    ] = None


@dataclass(frozen=True, slots=True)
class Board:
    """Entries of one group or suite, protocol and budget."""

    group: Annotated[str, about("group id or suite name")]
    published: Annotated[bool, about("false for a custom group, which `score --groups` adds")]
    protocol: Annotated[str, about("`sequential`, `single` or `joint`")]
    budget: Annotated[str, about("name of the budget")]
    task_conditioned: Annotated[bool, about("whether its agents observe the task in evaluation")]
    ranked: Annotated[int, about("M, the number of ranked entries")]
    rows: Annotated[
        tuple[BoardEntry, ...],
        about(
            "ranked entries by the first metric, best first; then the others; an identical entry follows the "
            "one that it equals"
        ),
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardsDocument(JsonDocument):
    """Every board."""

    format: Annotated[Literal[1], about("1")] = 1
    boards: Annotated[tuple[Board, ...], about("boards of groups, then of suites")]


@dataclass(frozen=True, slots=True)
class ComparedMetric:
    """A metric that both entries have."""

    first: Annotated[float, about("mean of the first entry")]
    second: Annotated[float, about("mean of the second entry")]
    difference: Annotated[Difference, about("first − second")]


@dataclass(frozen=True, slots=True)
class ComparedScore:
    """What two entries have in common on one group or suite under one protocol."""

    budget: Annotated[str, about("name of the budget")]
    metrics: Annotated[dict[str, ComparedMetric], about("metrics that both have, by name")]


ComparedScores = dict[str, dict[str, ComparedScore]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison(JsonDocument):
    """Two entries side by side. Intervals are not corrected for multiple comparisons."""

    format: Annotated[Literal[1], about("1")] = 1
    first: Annotated[str, about("name of the first entry")]
    second: Annotated[str, about("name of the second entry")]
    groups: Annotated[ComparedScores, about("by group id and protocol")]
    suites: Annotated[ComparedScores, about("by suite and protocol")]
