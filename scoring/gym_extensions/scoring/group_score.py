"""The scores in a scorecard: those of a submission on a group under a protocol, and on a suite.

docs/scorecard.md describes every key.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated

import msgspec

from gym_extensions.documents import about, filled
from gym_extensions.metrics.formulas import Profile
from gym_extensions.metrics.order_effects import OrderEffects
from gym_extensions.metrics.values import Estimate, MetricValue
from gym_extensions.submissions.review import Level
from gym_extensions.submissions.run import Memory, RunDocument

if TYPE_CHECKING:
    from gym_extensions.references import Reference


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
