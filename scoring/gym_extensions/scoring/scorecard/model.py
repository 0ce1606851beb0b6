"""The scorecard holds one submission's metrics, intervals and notes.

docs/scorecard.md describes every key.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

from gym_extensions.rollouts.problem import Problem
from gym_extensions.scoring.documents import JsonDocument, about
from gym_extensions.scoring.metrics.aggregates import Profile
from gym_extensions.scoring.metrics.paper_table import PaperColumns, PaperRow
from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.scoring.scorecard.manifest import ManifestSummary
from gym_extensions.scoring.scorecard.record import Challenge, LedgerRecord

REPORTED = "reported"
VALIDATED = "validated"


@dataclass(frozen=True, slots=True)
class ReferenceValue:
    """A task's floor and ceiling in raw returns."""

    floor: Annotated[
        float | None, about("return of a policy that ignores observations; null if not measured")
    ]
    ceiling: Annotated[float | None, about("return of the reference agent; null if unsolved or not measured")]
    unsolved: Annotated[
        bool | None, about("whether the reference agent did not learn it; null if not measured")
    ]

    def normalize(self, value: float) -> float | None:
        """(value − floor) / (ceiling − floor), not clipped; None without a ceiling."""
        if self.floor is None or self.ceiling is None or self.ceiling == self.floor:
            return None
        return (value - self.floor) / (self.ceiling - self.floor)


@dataclass(frozen=True, slots=True)
class Curve:
    """One training curve."""

    run: Annotated[int, about("training seed")]
    task: Annotated[str, about("task id")]
    points: Annotated[
        tuple[tuple[int, float], ...],
        about("`[training step, mean return of the training episodes ended since the point before]`"),
    ]


@dataclass(frozen=True, slots=True)
class FreshCell:
    """A run, stage and task whose policy was evaluated on new seeds."""

    run: Annotated[int, about("training seed")]
    stage: Annotated[int, about("number of tasks trained so far")]
    task: Annotated[str, about("task id")]
    logged: Annotated[float, about("mean raw return of the 20 logged episodes")]
    fresh: Annotated[float, about("mean raw return of the 20 episodes on new seeds")]


@dataclass(frozen=True, slots=True)
class FreshScore:
    """The policies of one log on new seeds (`score --reevaluate`)."""

    logged: Annotated[float, about("mean of the cells' logged returns")]
    fresh: Annotated[float, about("mean of the cells' returns on new seeds")]
    cells: Annotated[tuple[FreshCell, ...], about("R[T][j] and R[j][j], or S[j], of every run")]


@dataclass(frozen=True, slots=True)
class NewSeeds:
    """What the new seeds of a re-evaluation follow from, and its test."""

    digest: Annotated[str, about("digest of the submission")]
    salt: Annotated[str, about("value that was fixed after the submission")]
    p_value: Annotated[
        float, about("of the test that the logged returns are not higher, over all cells; refused up to .004")
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupScore:
    """One submission on one group under one protocol."""

    published: Annotated[bool, about("false for a custom group, which `score --groups` adds")] = True
    budget: Annotated[str, about("name of the budget")]
    runs: Annotated[tuple[int, ...], about("training seeds; empty in a reported entry")]
    tasks: Annotated[tuple[str, ...], about("task ids in training order")]
    metrics: Annotated[dict[str, MetricValue], about("every metric of the protocol by name")]
    profile: Annotated[Profile | None, about("performance profile of p[T][j] over runs and tasks")] = None
    iqm: Annotated[float | None, about("interquartile mean of p[T][j] over runs and tasks")] = None
    reference: Annotated[dict[str, ReferenceValue], about("floor and ceiling by task id")]
    return_matrix: Annotated[
        tuple[tuple[tuple[float, ...], ...], ...],
        about(
            "mean raw returns `[run][stage][task]`: stages 0 to T in `sequential`, the last stage alone in "
            "`single` and `joint`; empty in a reported entry"
        ),
    ]
    success_rates: Annotated[
        tuple[tuple[tuple[float | None, ...], ...], ...],
        about(
            "share of successful episodes `[run][stage][task]`, as in `return_matrix`; null where the task "
            "defines no success; empty if no task of the group does, and in a reported entry"
        ),
    ] = ()
    curves: Annotated[
        tuple[Curve, ...], about("training curves, one per run and task; empty without `curves.csv`")
    ] = ()
    episode_sketches: Annotated[
        tuple[tuple[str, ...], ...],
        about("16 digests of episodes per run, by which boards recognize copies; empty in a reported entry"),
    ] = ()
    reevaluation: Annotated[
        FreshScore | None, about("the policies on new seeds; null unless they were evaluated")
    ] = None
    missing_evidence: Annotated[
        str,
        about(
            "why the traces do not suffice for a rank, in words; empty if the audit sample is complete or "
            "all episodes were replayed or repeated"
        ),
    ] = ""
    missing_for_full_entry: Annotated[tuple[str, ...], about("what a full entry still needs, in words")] = ()
    paper_table: Annotated[
        tuple[PaperRow, ...], about("one row per task; empty in `single` and `joint`")
    ] = ()
    paper_total: Annotated[
        PaperColumns | None,
        about("totals of the paper's table: mean of the rows' means, deviation of all episodes pooled"),
    ] = None
    printed_total: Annotated[
        PaperColumns | None, about("reported entries: the totals as printed; else null")
    ] = None
    notes: Annotated[tuple[str, ...], about("reported entries: contradictions between printed numbers")] = ()


@dataclass(frozen=True, slots=True)
class SuiteScore:
    """One submission on a suite under one protocol: means over the suite's groups."""

    budget: Annotated[str, about("name of the budget")]
    groups: Annotated[tuple[str, ...], about("group ids")]
    metrics: Annotated[dict[str, MetricValue], about("every metric of the protocol by name")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scorecard:
    """One submission. With a problem it has neither trust nor scores."""

    name: Annotated[str, about("name of the submission's folder")]
    title: Annotated[str, about("from `submission.toml`; the name if that cannot be read")]
    trust: Annotated[
        str | None,
        about(
            "`reported` < `validated` < `replayed (…)` < `re-evaluated (…)` < `reproduced (…)`; null with "
            "problems"
        ),
    ]
    problems: Annotated[
        tuple[Problem, ...],
        about(
            "broken rules of docs/rollout-log.md; `fault-of-the-scorer` where scoring failed, a mistake of "
            "gym-extensions that should be reported"
        ),
    ] = ()
    manifest: Annotated[ManifestSummary | None, about("`submission.toml`; null if it has problems")]
    readme: Annotated[
        str, about("text of `README.md`, plain and never markup; empty without one or if it has problems")
    ] = ""
    new_seeds: Annotated[NewSeeds | None, about("the evaluation on new seeds; null unless it was made")] = (
        None
    )
    notes: Annotated[tuple[str, ...], about("what scoring did, such as counting identical runs as one")] = ()
    signs: Annotated[
        tuple[str, ...],
        about("unusual patterns in the logs, for a reader to judge; none of them is a verdict"),
    ] = ()
    ledger: Annotated[
        LedgerRecord | None,
        about("what the ledger says of the submission; null where it was scored without a ledger"),
    ] = None
    challenges: Annotated[
        tuple[Challenge, ...], about("challenges to the entry, as they were submitted (`challenges/`)")
    ] = ()
    groups: Annotated[dict[str, dict[str, GroupScore]], about("scores by group id and protocol")] = field(
        default_factory=dict
    )
    suites: Annotated[
        dict[str, dict[str, SuiteScore]], about("scores by suite and protocol, for suites with every group")
    ] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ReferencesInfo:
    """Which frozen floors and ceilings normalize the scores."""

    version: Annotated[str, about("benchmark version")]
    provisional: Annotated[
        bool,
        about("true if a ceiling has fewer than five runs or another budget than `300k`; an oracle has one"),
    ]
    sha256: Annotated[str, about("SHA-256 of the references' file")]


@dataclass(frozen=True, slots=True, kw_only=True)
class ScorecardDocument(JsonDocument):
    """Scorecards and the references that they use."""

    format: Annotated[Literal[1], about("1")] = 1
    references: ReferencesInfo
    submissions: Annotated[tuple[Scorecard, ...], about("scorecards, sorted by name")]
