"""The result of the gate as a JSON document, which the second workflow reads, and as a comment."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Annotated, Literal, TypeAlias

from msgspec import Meta

from gym_extensions.catalog.protocol import BUDGETS, FULL_SUBMISSION_RUNS
from gym_extensions.documents import JsonDocument
from gym_extensions.errors import BenchError
from gym_extensions.scoring.output.screen import number
from gym_extensions.submissions import layout, problem
from gym_extensions.submissions.review import CLAIMED, REPORTED

Kind = Literal["submission", "edit", "donation", "code", "none"]
Verdict = Literal["passed", "review", "refused", "not-judged"]
Level = Literal["reported", "claimed"]
MAX_BYTES = 2**20
MAX_PROBLEMS = 50
"""Most problems and most notes of a report."""
MAX_BLOCK = 20_000
"""Characters of each of the three blocks of a comment: GitHub takes 65,536 in all."""
KIND_LABELS: dict[Kind, str] = {
    "submission": "submission",
    "edit": "edits-submission",
    "donation": "donation",
}
CommitId: TypeAlias = Annotated[str, Meta(pattern="^[0-9a-f]{40,64}$")]
Note = Annotated[str, Meta(max_length=problem.MAX_TEXT)]


@dataclass(frozen=True, slots=True)
class GateScore:
    """The first metric of a submission on a group (its id) and protocol, with its interval."""

    group: str
    protocol: str
    budget: str
    runs: int
    metric: str
    mean: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class GateReport(JsonDocument):
    """What the gate says of a pull request.

    Attributes:
        pull_request: its number; None outside of a code host.
        base, head: the commit of the branch that it is for, whose code judged, and its last commit.
        kind: ``submission`` (a new submission), ``edit`` (of an existing one), ``donation`` (further runs of
            an agent of this project), ``code``, or ``none`` if it changes nothing.
        verdict: ``review``: passed, and its owner or a maintainer must agree; ``not-judged``: it changes code
            alone, which the ordinary tests check.
        submission: name of the submission.
        level: of the submission; None unless judged without a problem.
        trains: whether it has code, which is trained after the merge.
        repeated: number of sampled episodes that were repeated, of ``episodes``.
        without_policies: number of its runs that publish none, which cannot be verified.
        problems: the first broken rules; ``more_problems`` counts the others.
        notes: what scoring did and noticed.
    """

    format: Literal[1] = 1
    pull_request: int | None
    base: CommitId
    head: CommitId
    kind: Kind
    verdict: Verdict
    submission: Annotated[str, Meta(pattern=f"^({layout.NAME.pattern})?$")] = ""
    level: Level | None = None
    trains: bool = False
    repeated: int = 0
    episodes: int = 0
    without_policies: int = 0
    problems: Annotated[tuple[problem.Problem, ...], Meta(max_length=MAX_PROBLEMS)] = ()
    more_problems: int = 0
    scores: Annotated[tuple[GateScore, ...], Meta(max_length=400)] = ()
    notes: Annotated[tuple[Note, ...], Meta(max_length=MAX_PROBLEMS)] = ()

    @property
    def labels(self) -> list[str]:
        """What the code host shows beside the title."""
        verdict = "refused" if self.verdict == "refused" else self.level if self.level == CLAIMED else None
        return sorted(label for label in (KIND_LABELS.get(self.kind), verdict) if label)


def read_report(data: bytes) -> GateReport:
    """The report of a JSON text, strictly: unknown keys, other types and longer texts are refused.

    Raises:
        BenchError: the text is not a report of this version.
    """
    try:
        if len(data) > MAX_BYTES:
            raise ValueError(f"it has more than {MAX_BYTES} bytes")
        report = GateReport.from_json(data)
        if report.to_json().encode() != data:
            raise ValueError("it has unknown keys, another spelling, or longer texts than the command writes")
    except ValueError as error:
        hint = "Write it with `gym-extensions check-pr --json` of the same version."
        raise BenchError("malformed-report", f"It is not a report: {error}.", hint=hint) from None
    return report


HEADINGS = {
    "passed": "The submission passed",
    "review": "Passed; an owner or a maintainer has to agree",
    "refused": "Refused",
    "not-judged": "Not a submission",
}
NEXT = "There is nothing more to do. After the merge, new seeds follow from the merge commit."
FOLLOWS = {
    "submission": "If the returns of the policies on them agree with the log, the submission is verified{}.",
    "edit": "Runs that are new or changed, and all runs if the settings changed, are verified on them.",
    "donation": "If the returns of the policies on them agree with the log, the run is verified. It is "
    "scored as soon as all runs with lower numbers are there, unless the submission is withdrawn.",
}
TRAINS = (
    "There is nothing more to do. After the merge, the code is trained on the core in a box, five runs on "
    "seeds that follow from the merge commit. Then it is trained here and has a rank on the core. Whether it "
    "gives the same bytes twice is in the summary of the check."
)
TABLE = "There is nothing more to do. A published table is shown, without a rank."


def code_block(lines: Sequence[str], more: int = 0) -> str:
    """Lines as a code block that no text in them can end: texts of a pull request have no active markup.

    What goes beyond ``MAX_BLOCK`` is counted, with ``more`` lines that are not given.
    """
    ends = accumulate(len(line) + 1 for line in lines)
    kept = [line.replace("\n", " ") for line, end in zip(lines, ends, strict=True) if end <= MAX_BLOCK]
    more += len(lines) - len(kept)
    text = "\n".join([*kept, *([f"… and {more} more"] if more else [])])
    longest = max((len(run) for run in re.findall("`+", text)), default=0)
    fence = "`" * max(3, longest + 1)
    return f"{fence}text\n{text}\n{fence}"


def comment(report: GateReport) -> str:
    """The comment as Markdown."""
    parts = [f"### {HEADINGS[report.verdict]}"]
    if report.submission:
        parts.append(f"Submission `{report.submission}`.")
    if report.verdict == "not-judged":
        parts.append("It changes code alone, which the ordinary tests check.")
    if report.problems:
        lines = [f"{each.where}: {each.rule}: {each.message} {each.hint}" for each in report.problems]
        parts.append(code_block(lines, report.more_problems))
    if report.level is not None:
        counts = f"{report.repeated} of {report.episodes} sampled episodes are repeated"
        parts.append(f"Level: **{report.level}**{f': {counts}' if report.episodes else ''}.")
    if report.scores:
        rows = [
            f"{each.group}  {each.protocol}  {each.budget}  {problem.count(each.runs, 'run')}  "
            f"{each.metric} {number(each.mean, 2)} [{number(each.low, 2)}, {number(each.high, 2)}]"
            for each in report.scores
        ]
        parts.append(code_block(rows))
    if report.notes:
        parts += ["Notes, for a reader to judge:", code_block(report.notes)]
    if report.verdict in ("passed", "review"):
        parts += [TRAINS] if report.trains else _what_follows(report)
    parts.append(f"Judged by the code of {report.base[:12]}, for {report.head[:12]}.")
    return "\n\n".join(parts) + "\n"


def _what_follows(report: GateReport) -> list[str]:
    """What a submission without code gets after the merge, and what keeps it from the boards or a rank."""
    limits = []
    if report.kind == "submission" and report.scores:
        off_boards = {name for name, each in BUDGETS.items() if not each.on_boards}
        if off_boards.issuperset(score.budget for score in report.scores):
            budget = report.scores[0].budget
            limits = [f"The budget `{budget}` is for trials: its submissions appear on no board."]
        elif all(score.runs < FULL_SUBMISSION_RUNS for score in report.scores):
            limits = [f"A rank needs {FULL_SUBMISSION_RUNS} runs."]
    if report.without_policies:
        runs = problem.count(report.without_policies, "run")
        return [
            f"The submission cannot be verified and gets no rank, because {runs} published no policies.",
            *limits,
        ]
    follows = FOLLOWS[report.kind].format("" if limits else " and has a rank")
    return [TABLE if report.level == REPORTED else f"{NEXT} {follows}", *limits]
