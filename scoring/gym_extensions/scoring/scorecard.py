"""The scorecard: one submission's metrics, intervals and notes as a typed document.

docs/scorecard.md describes every key.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec

from gym_extensions.documents import JsonDocument, about, filled
from gym_extensions.metrics.formulas import Profile
from gym_extensions.metrics.order_effects import OrderEffects
from gym_extensions.metrics.values import Estimate, MetricValue
from gym_extensions.submissions.manifest import Code, Hyperparameter, Observes, Protocol, Tuning
from gym_extensions.submissions.problem import Problem
from gym_extensions.submissions.review import Decision, Level, is_withdrawn
from gym_extensions.submissions.run import Memory, RunDocument

if TYPE_CHECKING:
    from gym_extensions.references import Reference, References

NO_RUNS = "It has no runs: the project trains its code after the merge (docs/submit.md)."
"""Of a submission that is code alone."""


@dataclass(frozen=True, slots=True)
class ManifestSummary:
    """What a submission says of itself: submission.toml, and the memory of its runs."""

    authors: Annotated[tuple[str, ...], about("names")]
    description: Annotated[str, about("free text")]
    code: Code
    protocol: Protocol
    hyperparameters: Annotated[dict[str, Hyperparameter], about("free keys")]
    observes: Observes
    tuning: Annotated[Tuning | None, about("null in a reported submission")]
    memory: Annotated[Memory | None, about("the largest of all runs; null in a reported submission")]


@dataclass(frozen=True, slots=True, kw_only=True)
class VerificationSummary:
    """What one verification of the submission's runs found (`review.toml`)."""

    date: Annotated[str, about("YYYY-MM-DD")]
    version: Annotated[str, about("version of gym-extensions that verified them")]
    value: Annotated[str, about("hexadecimal digits from which the new seeds follow")]
    logs: Annotated[tuple[str, ...], about("logs with a run that it covers, such as `hopper-gravity/single`")]
    runs: Annotated[int, about("number of runs that it covers")]
    current: Annotated[int, about("how many of them are still as they were verified")]
    episodes: Annotated[int, about("number of logged episodes that were tried to repeat")]
    repeated: Annotated[int, about("how many were repeated: bit for bit, or nearly if there is a runtime")]
    runtime: Annotated[str, about("what ran ONNX networks, with its version; empty for plain policies")] = ""
    difference: Annotated[str, about("where the first difference lies and how large it is; empty without")]
    cells: Annotated[int, about("number of cells that were evaluated on new seeds")]
    p_value: Annotated[float, about("of the test that the logged returns are not higher")]
    second_p_value: Annotated[float | None, about("of the second draw; null unless there was one")]
    passed: Annotated[bool, about("whether the returns agree")]
    retrained: Annotated[tuple[str, ...], about("runs that were trained again, and agree: reproduced")]
    undecided: Annotated[str | None, about("why nothing was found out: slow policies; else null")] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingSummary:
    """What the project trained of the submission's code (`trained/2.toml`)."""

    attempts: Annotated[int, about("number of versions of the code that were trained; this is the last")]
    date: Annotated[str, about("day on which it began, YYYY-MM-DD")]
    finished: Annotated[str, about("day on which its last sequential run ended; empty without one")] = ""
    version: Annotated[str, about("version of gym-extensions that trained it")]
    commit: Annotated[str, about("the one that merged this version of the code")]
    value: Annotated[str, about("public hexadecimal digits that were fixed after it; may be empty")]
    agent: Annotated[str, about("digest of the code")]
    failed: Annotated[dict[str, str], about("why the agent failed, by run; such a run counts as the floor")]
    outdated: Annotated[bool, about("whether the submission's code was changed since")]


@dataclass(frozen=True, slots=True)
class ReferenceValue:
    """A task's floor and expert in raw returns; null if not measured."""

    floor: Annotated[float | None, about("return of an agent that ignores observations")] = None
    expert: Annotated[float | None, about("mean return of the expert; null also if open")] = None
    open: Annotated[bool | None, about("whether no known expert is clearly better than the floor")] = None
    standard_error: Annotated[float | None, about("of the expert's mean return")] = None
    df: Annotated[float | None, about("degrees of freedom of the standard error, 0 if unknown")] = None
    provisional: Annotated[str, about("why the expert does not do what the task is for; else empty")] = ""

    @classmethod
    def of(cls, known: Reference | None) -> ReferenceValue:
        """The values of a reference; of None, a task without one."""
        if known is None:
            return cls()
        floor, expert = known.floor.mean, known.expert
        if expert is None:
            return cls(floor, None, True, 0.0, 0.0)
        return cls(floor, expert.mean, False, expert.standard_error, expert.df, expert.provisional)

    @property
    def span(self) -> float | None:
        """expert − floor; None without one of the two."""
        return None if self.floor is None or self.expert is None else self.expert - self.floor

    def normalize(self, value: float) -> float | None:
        """(value − floor) / (expert − floor), not clipped; None without an expert."""
        return (value - (self.floor or 0.0)) / self.span if self.span else None


PAPER_COLUMNS = {
    "fully_trained": "Fully Trained",
    "after_env_training": "After Env Training",
    "first_step": "First Step",
    "single_env": "Single Env",
}
"""The paper's columns: ``R[T][j]``, ``R[j][j]``, ``R[j−1][j]``, ``S[j]``."""


@dataclass(frozen=True, slots=True)
class PaperCell:
    """Raw returns of episodes, all runs pooled."""

    mean: Annotated[float, about("mean return")]
    std: Annotated[float, about("population standard deviation over episodes")]


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperColumns:
    """The four cells of a row or of a total; null where the submission has no such log."""

    fully_trained: Annotated[PaperCell | None, about("after the last stage")] = None
    after_env_training: Annotated[PaperCell | None, about("right after training on the task")] = None
    first_step: Annotated[PaperCell | None, about("right before training on the task")] = None
    single_env: Annotated[PaperCell | None, about("trained on the task alone")] = None

    def cell(self, column: str) -> PaperCell | None:
        """The cell of a column of ``PAPER_COLUMNS``."""
        return getattr(self, column)

    def cells(self) -> list[PaperCell | None]:
        """The four cells in the order of ``PAPER_COLUMNS``."""
        return [self.cell(column) for column in PAPER_COLUMNS]


@dataclass(frozen=True, slots=True)
class PaperRow(PaperColumns):
    """One task's row."""

    task: Annotated[str, about("the task's id")]
    printed_task: Annotated[str, about("its name in the publication; empty in submissions with logs")] = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class StageScore(Estimate):
    """A task after a stage, over runs: its score, which a task without an expert lacks, and its return."""

    mean_return: Annotated[float, about("mean raw return over runs")]
    success_rate: Annotated[
        float | None, about("mean over runs of the share of successful episodes; null where undefined")
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskChange(Estimate):
    """The change of a task since right after its training: its score at the end minus that one, over runs."""

    normalized: Annotated[bool, about("false for raw returns, where the task has no expert")]

    @property
    def is_certain(self) -> bool:
        """Whether its interval excludes 0. A single run has no interval, and is not certain."""
        return self.ends is not None and not self.ends[0] <= 0 <= self.ends[1]


@dataclass(frozen=True, slots=True)
class LargestChange:
    """The task that changes most, if a test over runs finds its change; its mean return in two columns."""

    task: Annotated[str, about("task id")]
    before: Annotated[float, about("in the first of the two columns")]
    after: Annotated[float, about("in the second one")]


@dataclass(frozen=True, slots=True)
class TrainingCurve:
    """One training curve."""

    run: Annotated[int, about("training seed")]
    task: Annotated[str, about("task id")]
    points: Annotated[tuple[tuple[int, float], ...], about("`[training step, mean training return]`")]


@dataclass(frozen=True, slots=True)
class RunProvenance:
    """How a run was trained."""

    run: Annotated[int, about("training seed")]
    command: Annotated[str, about("what trained it; empty if it is not known")]
    commit: Annotated[str, about("of the code; empty if it is not known")]
    by: Annotated[str, about("who donated the run; empty if the authors of the submission trained it")]
    date: Annotated[str | None, about("YYYY-MM-DD; null if it is not known")]
    versions: Annotated[
        dict[str, str], about("of packages, Python and platform, and the BLAS kernels of the training")
    ]
    processor: Annotated[str, about("of the machine; empty if it is not known")]
    steps: Annotated[int, about("training steps over all stages")]
    cpu_seconds: Annotated[float | None, about("processor time; null if it is not known")]
    peak_memory_mb: Annotated[float | None, about("largest memory; null if it is not known")]
    memory: Annotated[Memory, about("transitions stored at once, and the agent's parameters")]
    policies: Annotated[bool, about("whether the run publishes its policies")]
    reproduced: Annotated[bool, about("whether it was trained again from its seed, and agrees")]

    @classmethod
    def of(cls, document: RunDocument, reproduced: bool = False) -> RunProvenance:
        """What the document of a run says, and whether it was reproduced."""
        versions = msgspec.to_builtins(document.versions) | document.packages
        return filled(
            cls,
            document,
            versions={name: version for name, version in versions.items() if version},
            processor=document.machine.processor if document.machine else "",
            policies=document.policies is not None,
            reproduced=reproduced,
        )


Sketch = tuple[str, ...]
SKETCH_SIZE = 16
"""Digests per run: the smallest of those of all its last episodes (a bottom-k sketch)."""


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class GroupScore:
    """One submission on one group under one protocol."""

    published: Annotated[bool, about("false for a custom group, which `score --groups` adds")] = True
    level: Annotated[Level, about("level of the log: `reported`, `claimed`, `verified` or `trained here`")]
    why_claimed: Annotated[str, about("why the log is not verified, in words; else empty")] = ""
    budget: Annotated[str, about("name of the budget")]
    runs: Annotated[tuple[int, ...], about("training seeds; empty in a reported submission")]
    unverified: Annotated[tuple[int, ...], about("training seeds of the runs that are not verified")] = ()
    provenance: Annotated[tuple[RunProvenance, ...], about("how each run was trained")] = ()
    tasks: Annotated[tuple[str, ...], about("task ids in the order of the group")]
    metrics: Annotated[dict[str, MetricValue], about("every metric of the protocol by name")]
    profile: Annotated[Profile | None, about("performance profile of p[T][j] over runs and tasks")] = None
    iqm: Annotated[float | None, about("interquartile mean of p[T][j] over runs and tasks")] = None
    reference: Annotated[dict[str, ReferenceValue], about("floor and expert by task id")]
    return_matrix: Annotated[
        tuple[tuple[tuple[float, ...], ...], ...],
        about(
            "mean raw returns `[run][stage][task]`: stages 0 to T where tasks are learned one after another, "
            "else the last stage only"
        ),
    ]
    success_rates: Annotated[
        tuple[tuple[tuple[float | None, ...], ...], ...],
        about("share of successful episodes; null where the task defines no success, empty if no task does"),
    ] = ()
    stages: Annotated[
        tuple[tuple[StageScore, ...], ...],
        about("means over runs `[stage][task]`, of the same stages; empty in `balanced`"),
    ] = ()
    changes: Annotated[
        tuple[TaskChange, ...], about("of each task but the last; empty outside `sequential`")
    ] = ()
    top_score: Annotated[float, about("highest score of a run on a task after a stage, at least 1")] = 1.0
    largest_loss: Annotated[
        LargestChange | None, about("the most forgotten task, from right after its training to the end")
    ] = None
    highlights: Annotated[
        tuple[str, ...],
        about("sentences on the largest changes and on open tasks; empty outside `sequential`"),
    ] = ()
    curves: Annotated[tuple[TrainingCurve, ...], about("training curves, one per run and task")] = ()
    episode_sketches: Annotated[
        tuple[Sketch, ...],
        about("hashes of episodes (navigation: of policies) per run, by which boards find copies"),
    ] = ()
    paper_table: Annotated[tuple[PaperRow, ...], about("one row per task; empty outside `sequential`")] = ()
    paper_total: Annotated[PaperColumns | None, about("its total: mean of means, pooled deviation")] = None
    order_effects: Annotated[
        dict[str, OrderEffects],
        about("of final performance and forgetting, by name, over whole squares; empty outside `balanced`"),
    ] = field(default_factory=dict)
    printed_total: Annotated[PaperColumns | None, about("the total as printed, in reported submissions")] = (
        None
    )
    notes: Annotated[tuple[str, ...], about("reported submissions: contradictions of printed numbers")] = ()

    def scores(self, at: int) -> list[list[float]] | None:
        """The scores of a task, given its position from 0, by run and stage; None without an expert."""
        reference = self.reference.get(self.tasks[at], ReferenceValue())
        rows = [[reference.normalize(stage[at]) for stage in run] for run in self.return_matrix]
        scores = [[score for score in row if score is not None] for row in rows]
        return scores if scores == rows else None

    def __repr__(self) -> str:
        means = {key: round(value.mean, 3) for key, value in self.metrics.items() if value.mean is not None}
        return f"GroupScore(level={self.level!r}, budget={self.budget!r}, runs={self.runs}, metrics={means})"


@dataclass(frozen=True, slots=True)
class SuiteScore:
    """One submission on a suite under one protocol: means over the suite's groups."""

    budget: Annotated[str, about("name of the budget")]
    groups: Annotated[tuple[str, ...], about("group ids")]
    metrics: Annotated[dict[str, MetricValue], about("every metric of the protocol by name")]


@dataclass(frozen=True, slots=True)
class CoreGroup(Estimate):
    """Final performance of a submission on a group of the core, over the compared runs."""

    runs: Annotated[int, about("number of these runs, 0 to N − 1")] = 0
    others: Annotated[
        dict[str, float], about("means over the same runs: learning performance, forgetting, transfer")
    ] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Claim:
    """The core score of the author's own runs against that of the runs that were trained here."""

    difference: Annotated[float, about("the author's − the project's, as a mean over groups")]
    p_value: Annotated[float, about("one-sided, of no higher claim")]
    agrees: Annotated[bool, about("whether the claim is not significantly higher, at level .005")]


@dataclass(frozen=True, slots=True, kw_only=True)
class CoreCost:
    """What one run of the core takes, as its documents state it: all groups of the core together.

    Nothing is estimated: a number that some group's runs do not state is null, and so are the steps and the
    time of a submission that lacks a group. Its memory is that of the groups that it has.
    """

    steps: Annotated[float | None, about("training steps: the sum over groups of the mean over runs")] = None
    cpu_seconds: Annotated[float | None, about("processor time: the same sum, where runs state it")] = None
    peak_memory_mb: Annotated[float | None, about("largest memory of a process, of all runs")] = None
    stored_steps: Annotated[int | None, about("most transitions that a run stores at once")] = None
    parameters: Annotated[int | None, about("parameters at the end of training, in the largest group")] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CoreRuns:
    """What a submission has on the core, whether or not it is compared with others."""

    parent: Annotated[str, about("the algorithm with the same first stage, or its own")]
    look: Annotated[int, about("n: runs 0 to n − 1 of every group are compared; 0 without a complete look")]
    next_look: Annotated[int | None, about("the next look; null after the last")]
    missing: Annotated[tuple[str, ...], about("groups without sequential runs; it has no scores then")] = ()
    groups: Annotated[dict[str, CoreGroup], about("final performance by group id")]
    trained_here: Annotated[bool, about("whether these are runs that the project trained")] = False
    claim: Annotated[Claim | None, about("the author's own runs beside them; null without")] = None
    retention: Annotated[
        Estimate, about("share of what was learned on all tasks but the last that is left at the end")
    ] = field(default_factory=Estimate)
    cost: CoreCost
    notes: Annotated[tuple[str, ...], about("what is not compared, and a code for each")] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class CoreScore(CoreRuns):
    """A submission with sequential runs on a group of the core, before it is compared with others."""

    why: Annotated[str, about("why it cannot be compared: claimed, groups or runs missing; else empty")] = ""
    metrics: Annotated[dict[str, MetricValue], about("means over groups, over runs 0 to n − 1")]


@dataclass(frozen=True, slots=True)
class RunCost:
    """What a run takes: all groups of the core that the submission has, or all of its groups, together."""

    steps: Annotated[float, about("training steps: the sum over groups of the mean over runs")]
    groups: Annotated[int, about("number of these groups")]
    cpu_seconds: Annotated[float, about("processor time: the same sum, of the groups that state it")]
    timed_groups: Annotated[int, about("number of groups with a run that states its processor time")]
    timed_runs: Annotated[
        tuple[int, int],
        about("fewest and most runs of these groups that state it; (0, 0) without such a group"),
    ] = (0, 0)


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Scorecard:
    """One submission. With a problem it has neither a level nor scores."""

    name: Annotated[str, about("name of the submission's folder")]
    title: Annotated[str, about("from `submission.toml`; the name if that cannot be read")]
    level: Annotated[
        Level | None,
        about("the lowest level of its logs; null with problems or without runs of the chosen groups"),
    ]
    arithmetic: Annotated[int, about("1 if other processors do not repeat a verified episode; else 2")] = 2
    steps_counted: Annotated[
        bool, about("whether the loop counted the training steps of all runs; false for a printed table")
    ] = True
    problems: Annotated[tuple[Problem, ...], about("broken rules of docs/rollout-log.md")] = ()
    manifest: Annotated[ManifestSummary | None, about("`submission.toml`; null if it has problems")]
    readme: Annotated[str, about("text of `README.md`, plain and never markup; empty without one")] = ""
    notes: Annotated[tuple[str, ...], about("what scoring did, such as leaving out runs after a gap")] = ()
    verifications: Annotated[tuple[VerificationSummary, ...], about("their results, oldest first")] = ()
    decisions: Annotated[tuple[Decision, ...], about("decisions of maintainers, oldest first")] = ()
    training: Annotated[TrainingSummary | None, about("of its code; null without")] = None
    groups: Annotated[dict[str, dict[str, GroupScore]], about("scores by group id and protocol")]
    own: Annotated[
        dict[str, GroupScore],
        about("by group id, the author's sequential runs, where `groups` has those trained here"),
    ] = field(default_factory=dict)
    suites: Annotated[dict[str, dict[str, SuiteScore]], about("of complete suites, by suite and protocol")]
    core: Annotated[CoreScore | None, about("on the core; null without runs there, and if withdrawn")] = None
    cost: Annotated[RunCost | None, about("what a run takes; null where no run states it")] = None

    def __repr__(self) -> str:
        return f"Scorecard({self.name!r}, level={self.level!r}, groups={list(self.groups)})"

    def log(self, group: str, protocol: str) -> GroupScore | None:
        """The score of the runs on a group, given its id, under a protocol; None without any."""
        return self.groups.get(group, {}).get(protocol)

    def scores(self) -> Iterator[tuple[str, str, GroupScore | SuiteScore]]:
        """All scores, each with the group id or suite, and the protocol: groups before suites."""
        for groups in (self.groups, self.suites):
            for name, protocols in groups.items():
                for protocol, score in protocols.items():
                    yield name, protocol, score

    @property
    def accepted(self) -> str:
        """The date of the last acceptance, YYYY-MM-DD; empty without one."""
        return next((part.date for part in reversed(self.decisions) if part.action == "accepted"), "")

    @property
    def withdrawn(self) -> bool:
        """Whether the last acceptance or withdrawal is a withdrawal; such a submission is on no board."""
        return is_withdrawn(self.decisions)

    @property
    def challenges(self) -> tuple[Decision, ...]:
        """The challenges since the last acceptance or withdrawal."""
        standing = [index for index, part in enumerate(self.decisions, 1) if part.action != "challenged"]
        return self.decisions[max(standing, default=0) :]

    @property
    def doubts(self) -> tuple[str, ...]:
        """The withdrawal and the last challenge that hold, with date and reason."""
        last = {part.action: part for part in self.decisions}
        found = [("withdrawn from all boards", last["withdrawn"])] if self.withdrawn else []
        found += [("challenged", part) for part in self.challenges[-1:]]
        return tuple(f"{what} on {part.date}: {part.reason}" for what, part in found)


@dataclass(frozen=True, slots=True)
class ReferencesInfo:
    """Which frozen floors and experts normalize the scores."""

    version: Annotated[str, about("benchmark version")]
    sha256: Annotated[str, about("SHA-256 of the references' file")]

    @classmethod
    def of(cls, known: References) -> ReferencesInfo:
        """The name of these references."""
        return cls(known.version, known.digest)


@dataclass(frozen=True, slots=True, kw_only=True)
class ScorecardDocument(JsonDocument):
    """Scorecards and the references that they use."""

    format: Annotated[Literal[1], about("1")] = 1
    references: ReferencesInfo
    submissions: Annotated[tuple[Scorecard, ...], about("scorecards, sorted by name")]
