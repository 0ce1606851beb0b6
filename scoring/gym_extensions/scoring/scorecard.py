"""The scorecard: one submission's metrics, intervals and notes as a typed document.

docs/scorecard.md describes every key.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Literal

from gym_extensions.documents import JsonDocument, about
from gym_extensions.metrics.values import Estimate, MetricValue
from gym_extensions.scoring.group_score import GroupScore, SuiteScore
from gym_extensions.submissions.manifest import Code, Hyperparameter, Observes, Protocol, Tuning
from gym_extensions.submissions.problem import Problem
from gym_extensions.submissions.review import Decision, Level, is_withdrawn
from gym_extensions.submissions.run import Memory

if TYPE_CHECKING:
    from gym_extensions.references import References

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
