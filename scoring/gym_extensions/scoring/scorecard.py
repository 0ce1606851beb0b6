"""The scorecard: one submission's metrics, intervals and notes as a typed document.

docs/scorecard.md describes every key.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

import msgspec

from gym_extensions.rollouts.manifest import Code, Observes, Protocol, Tuning
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.review import Action, Level, Verification
from gym_extensions.rollouts.run import Memory, RunDocument
from gym_extensions.rollouts.submission import Submission
from gym_extensions.scoring.documents import JsonDocument, about
from gym_extensions.scoring.metrics import MetricValue, Profile
from gym_extensions.scoring.published import PaperColumns, PaperRow

Scalar = str | int | float | bool
Hyperparameter = Scalar | tuple[Scalar, ...]


@dataclass(frozen=True, slots=True)
class ManifestSummary:
    """What a submission says of itself: submission.toml, and the memory of its runs."""

    authors: Annotated[tuple[str, ...], about("names")]
    description: Annotated[str, about("free text")]
    code: Code
    protocol: Protocol
    hyperparameters: Annotated[dict[str, Hyperparameter], about("free keys")]
    observes: Observes
    tuning: Annotated[Tuning | None, about("null in a reported entry")]
    memory: Annotated[Memory | None, about("the largest of all runs; null in a reported entry")]


def summarize_manifest(submission: Submission) -> ManifestSummary | None:
    """What a submission says of itself; None if its manifest has problems."""
    manifest = submission.manifest
    if manifest is None:
        return None
    return ManifestSummary(
        authors=manifest.authors,
        description=manifest.description,
        code=manifest.code,
        protocol=manifest.protocol,
        hyperparameters={
            name: tuple(value) if isinstance(value, list) else value
            for name, value in manifest.hyperparameters.items()
        },
        observes=manifest.observes,
        tuning=manifest.tuning,
        memory=submission.memory,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class VerificationSummary:
    """What one verification of the entry's runs found (`review.toml`)."""

    date: Annotated[str, about("YYYY-MM-DD")]
    version: Annotated[str, about("version of gym-extensions that verified them")]
    value: Annotated[str, about("hexadecimal digits from which the new seeds follow")]
    logs: Annotated[tuple[str, ...], about("logs with a run that it covers, such as `hopper-gravity/single`")]
    runs: Annotated[int, about("number of runs that it covers")]
    current: Annotated[int, about("how many of them are still as they were verified")]
    episodes: Annotated[int, about("number of logged episodes that were tried to repeat")]
    repeated: Annotated[int, about("how many of them were repeated bit for bit")]
    difference: Annotated[str, about("where the first difference lies and how large it is; empty without")]
    kernels: Annotated[str, about("BLAS kernels of the machine that verified them")]
    cells: Annotated[int, about("number of cells that were evaluated on new seeds")]
    p_value: Annotated[float, about("of the test that the logged returns are not higher")]
    second_p_value: Annotated[float | None, about("of the second draw; null unless there was one")]
    passed: Annotated[bool, about("whether the returns agree")]
    retrained: Annotated[tuple[str, ...], about("runs that were trained again, and agree")]


@dataclass(frozen=True, slots=True)
class DecisionSummary:
    """What a maintainer decided about the entry (`review.toml`)."""

    action: Annotated[Action, about("`accepted`, `withdrawn` or `challenged`")]
    by: Annotated[str, about("who decided")]
    date: Annotated[str, about("YYYY-MM-DD")]
    reason: Annotated[str, about("why")]


def summarize_verification(part: Verification, digests: Mapping[str, str]) -> VerificationSummary:
    """What a verification found, given the digest of every run as it is now, by the run's name."""
    return VerificationSummary(
        date=part.date,
        version=part.version,
        value=part.value,
        logs=tuple(sorted({key.rpartition("/")[0] for key in part.runs})),
        runs=len(part.runs),
        current=sum(digests.get(key) == digest for key, digest in part.runs.items()),
        episodes=part.episodes,
        repeated=part.repeated,
        difference=part.difference,
        kernels=part.kernels,
        cells=part.cells,
        p_value=part.p_value,
        second_p_value=part.second_p_value,
        passed=part.passed,
        retrained=tuple(part.retrained),
    )


@dataclass(frozen=True, slots=True)
class ReferenceValue:
    """A task's floor and expert in raw returns."""

    floor: Annotated[
        float | None, about("return of a policy that ignores observations; null if not measured")
    ] = None
    expert: Annotated[float | None, about("mean return of the expert; null if open or not measured")] = None
    open: Annotated[
        bool | None,
        about("whether no expert is known that is clearly better than the floor; null if not measured"),
    ] = None
    standard_error: Annotated[float | None, about("of the expert's mean return; null if not measured")] = None
    df: Annotated[
        float | None, about("degrees of freedom of the standard error, 0 if unknown; null if not measured")
    ] = None
    provisional: Annotated[
        str, about("why the expert does not do what the task is for; empty if it does")
    ] = ""

    def normalize(self, value: float) -> float | None:
        """(value − floor) / (expert − floor), not clipped; None without an expert."""
        if self.floor is None or self.expert is None or self.expert == self.floor:
            return None
        return (value - self.floor) / (self.expert - self.floor)


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
class RunProvenance:
    """How a run was trained."""

    run: Annotated[int, about("training seed")]
    command: Annotated[str, about("what trained it; empty if it is not known")]
    commit: Annotated[str, about("of the code; empty if it is not known")]
    by: Annotated[str, about("who donated the run; empty if the authors of the entry trained it")]
    date: Annotated[str | None, about("YYYY-MM-DD; null if it is not known")]
    versions: Annotated[dict[str, str], about("of packages, Python, platform and BLAS kernels")]
    processor: Annotated[str, about("of the machine; empty if it is not known")]
    steps: Annotated[int, about("training steps over all stages")]
    cpu_seconds: Annotated[float | None, about("processor time; null if it is not known")]
    peak_memory_mb: Annotated[float | None, about("largest memory; null if it is not known")]
    memory: Annotated[Memory, about("transitions stored at once, and the agent's parameters")]
    policies: Annotated[bool, about("whether the run publishes its policies")]

    @classmethod
    def of(cls, document: RunDocument) -> RunProvenance:
        """What the document of a run says."""
        versions = msgspec.to_builtins(document.versions) | document.packages
        return cls(
            run=document.run,
            command=document.command,
            commit=document.commit,
            by=document.by,
            date=document.date,
            versions={name: version for name, version in versions.items() if version},
            processor=document.machine.processor if document.machine else "",
            steps=document.steps,
            cpu_seconds=document.cpu_seconds,
            peak_memory_mb=document.peak_memory_mb,
            memory=document.memory,
            policies=document.policies is not None,
        )


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class GroupScore:
    """One submission on one group under one protocol."""

    published: Annotated[bool, about("false for a custom group, which `score --groups` adds")] = True
    level: Annotated[Level, about("level of the log: `reported`, `claimed`, `verified` or `reproduced`")]
    why_claimed: Annotated[str, about("why the log is not verified, in words; else empty")] = ""
    budget: Annotated[str, about("name of the budget")]
    runs: Annotated[tuple[int, ...], about("training seeds; empty in a reported entry")]
    provenance: Annotated[
        tuple[RunProvenance, ...], about("how each run was trained; empty in a reported entry")
    ] = ()
    tasks: Annotated[tuple[str, ...], about("task ids in training order")]
    metrics: Annotated[dict[str, MetricValue], about("every metric of the protocol by name")]
    profile: Annotated[Profile | None, about("performance profile of p[T][j] over runs and tasks")] = None
    iqm: Annotated[float | None, about("interquartile mean of p[T][j] over runs and tasks")] = None
    reference: Annotated[dict[str, ReferenceValue], about("floor and expert by task id")]
    return_matrix: Annotated[
        tuple[tuple[tuple[float, ...], ...], ...],
        about(
            "mean raw returns `[run][stage][task]`: stages 0 to T in `sequential`, the last stage alone in "
            "the other protocols; empty in a reported entry"
        ),
    ]
    success_rates: Annotated[
        tuple[tuple[tuple[float | None, ...], ...], ...],
        about(
            "share of successful episodes `[run][stage][task]`, as in `return_matrix`; null where the task "
            "defines no success; empty if no task of the group does, and in a reported entry"
        ),
    ] = ()
    curves: Annotated[tuple[Curve, ...], about("training curves, one per run and task")] = ()
    episode_sketches: Annotated[
        tuple[tuple[str, ...], ...],
        about(
            "what equal runs have in common, by which boards recognize copies: 16 digests of episodes per "
            "run, in navigation the digest of the policies; empty but in `sequential`"
        ),
    ] = ()
    missing_for_full_entry: Annotated[tuple[str, ...], about("what a full entry still needs, in words")] = ()
    paper_table: Annotated[tuple[PaperRow, ...], about("one row per task; empty outside `sequential`")] = ()
    paper_total: Annotated[
        PaperColumns | None,
        about("totals of the paper's table: mean of the rows' means, deviation of all episodes pooled"),
    ] = None
    printed_total: Annotated[
        PaperColumns | None, about("reported entries: the totals as printed; else null")
    ] = None
    notes: Annotated[tuple[str, ...], about("reported entries: contradictions between printed numbers")] = ()

    def __repr__(self) -> str:
        means = {key: round(value.mean, 3) for key, value in self.metrics.items() if value.mean is not None}
        return f"GroupScore(level={self.level!r}, budget={self.budget!r}, runs={self.runs}, metrics={means})"


@dataclass(frozen=True, slots=True)
class SuiteScore:
    """One submission on a suite under one protocol: means over the suite's groups."""

    budget: Annotated[str, about("name of the budget")]
    groups: Annotated[tuple[str, ...], about("group ids")]
    metrics: Annotated[dict[str, MetricValue], about("every metric of the protocol by name")]


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Scorecard:
    """One submission. With a problem it has neither a level nor scores."""

    name: Annotated[str, about("name of the submission's folder")]
    title: Annotated[str, about("from `submission.toml`; the name if that cannot be read")]
    level: Annotated[
        Level | None,
        about(
            "`reported` (a printed table), `claimed` (the files keep to the rules), `verified` (its policies "
            "agree with its logs on new seeds) or `reproduced` (a run was trained again): the lowest of its "
            "logs; null with problems"
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
    notes: Annotated[tuple[str, ...], about("what scoring did, such as counting identical runs as one")] = ()
    signs: Annotated[
        tuple[str, ...],
        about("unusual patterns in the logs, for a reader to judge; none of them is a verdict"),
    ] = ()
    verifications: Annotated[
        tuple[VerificationSummary, ...], about("what verifications found, oldest first")
    ] = ()
    decisions: Annotated[tuple[DecisionSummary, ...], about("decisions of maintainers, oldest first")] = ()
    groups: Annotated[dict[str, dict[str, GroupScore]], about("scores by group id and protocol")] = field(
        default_factory=dict
    )
    suites: Annotated[
        dict[str, dict[str, SuiteScore]], about("scores by suite and protocol, for suites with every group")
    ] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"Scorecard({self.name!r}, level={self.level!r}, groups={list(self.groups)})"

    @property
    def accepted(self) -> str:
        """The date of the last acceptance, YYYY-MM-DD; empty without one."""
        return next((part.date for part in reversed(self.decisions) if part.action == "accepted"), "")

    @property
    def withdrawn(self) -> bool:
        """Whether the last acceptance or withdrawal is a withdrawal; such an entry is on no board."""
        standing = [part.action for part in self.decisions if part.action != "challenged"]
        return standing[-1:] == ["withdrawn"]

    @property
    def challenges(self) -> tuple[DecisionSummary, ...]:
        """The challenges since the last acceptance or withdrawal."""
        standing = [index for index, part in enumerate(self.decisions, 1) if part.action != "challenged"]
        return self.decisions[max(standing, default=0) :]


@dataclass(frozen=True, slots=True)
class ReferencesInfo:
    """Which frozen floors and experts normalize the scores."""

    version: Annotated[str, about("benchmark version")]
    sha256: Annotated[str, about("SHA-256 of the references' file")]


@dataclass(frozen=True, slots=True, kw_only=True)
class ScorecardDocument(JsonDocument):
    """Scorecards and the references that they use."""

    format: Annotated[Literal[1], about("1")] = 1
    references: ReferencesInfo
    submissions: Annotated[tuple[Scorecard, ...], about("scorecards, sorted by name")]
