"""The result of the gate as a JSON document, which the second workflow reads, and as a comment."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

import msgspec

from gym_extensions.catalog.protocol import BUDGETS, FULL_ENTRY_RUNS
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.problem import Problem
from gym_extensions.scoring.documents import JsonDocument, about

Kind = Literal["submission", "edit", "donation", "record", "code", "none"]
Verdict = Literal["passed", "review", "refused", "not-judged"]
Label = Literal["submission", "edits-entry", "donation", "record", "refused", "claimed"]
Level = Literal["reported", "claimed"]
MAX_BYTES = 2**20
MAX_PROBLEMS = 50
MAX_TEXT = 500
"""Problems and notes of a report, and characters of each of their texts."""

OWNER = "@[A-Za-z0-9][A-Za-z0-9-]*(/[A-Za-z0-9._-]+)?"
"""A user or team of the code host."""
CommitId: TypeAlias = Annotated[str, msgspec.Meta(pattern="^[0-9a-f]{40,64}$")]


@dataclass(frozen=True, slots=True)
class GateScore:
    """The first metric of a submission on a group and protocol."""

    group: Annotated[str, about("group id")]
    protocol: Annotated[str, about("`sequential`, `single`, `joint` or `cumulative`")]
    budget: Annotated[str, about("name of the budget")]
    runs: Annotated[int, about("number of runs")]
    metric: Annotated[str, about("name of the metric")]
    mean: Annotated[float | None, about("as in the scorecard")]
    low: Annotated[float | None, about("as in the scorecard")]
    high: Annotated[float | None, about("as in the scorecard")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement(JsonDocument):
    """What the process with limits found out about an entry."""

    level: Level | None = None
    repeated: int = 0
    episodes: int = 0
    problems: tuple[Problem, ...] = ()
    scores: tuple[GateScore, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class GateReport(JsonDocument):
    """What the gate says of a pull request."""

    format: Annotated[Literal[1], about("1")] = 1
    pull_request: Annotated[int | None, about("its number; null outside of a code host")] = None
    base: Annotated[CommitId, about("commit of the branch that it is for; its code judged")]
    head: Annotated[CommitId, about("its last commit")]
    kind: Annotated[
        Kind,
        about(
            "`submission` (a new entry), `edit` (of an existing one), `donation` (further runs of an "
            "agent of this project), `record`, `code`, or `none` if it changes nothing"
        ),
    ]
    verdict: Annotated[
        Verdict,
        about(
            "`passed`; `review`: passed, and its owner or a maintainer must agree; `refused`: it has "
            "problems; `not-judged`: it changes code alone, which the ordinary tests check"
        ),
    ]
    entry: Annotated[
        str,
        msgspec.Meta(
            pattern=r"^([A-Za-z0-9][A-Za-z0-9._-]{0,63}(/[A-Za-z0-9_-]{1,64})?)?$",
            description="name of the entry, or task and name of the record",
        ),
    ] = ""
    owners: Annotated[
        tuple[Annotated[str, msgspec.Meta(pattern=f"^{OWNER}$")], ...],
        msgspec.Meta(max_length=MAX_PROBLEMS, description="owners of the entry, from CODEOWNERS of the base"),
    ] = ()
    level: Annotated[Level | None, about("level of the entry; null unless judged without a problem")] = None
    repeated: Annotated[int, about("number of sampled episodes that were repeated bit for bit")] = 0
    episodes: Annotated[int, about("number of sampled episodes")] = 0
    problems: Annotated[
        tuple[Problem, ...],
        msgspec.Meta(max_length=MAX_PROBLEMS, description="broken rules, at most 50"),
    ] = ()
    more_problems: Annotated[int, about("number of problems that are not listed")] = 0
    scores: Annotated[
        tuple[GateScore, ...], msgspec.Meta(max_length=400, description="first metrics, by group")
    ] = ()
    notes: Annotated[
        tuple[str, ...], msgspec.Meta(max_length=MAX_PROBLEMS, description="what scoring did and noticed")
    ] = ()
    labels: Annotated[tuple[Label, ...], about("labels for the pull request, sorted")] = ()


def cut(text: str) -> str:
    """A text with at most ``MAX_TEXT`` characters."""
    return text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT - 1]}…"


def read_report(data: bytes) -> GateReport:
    """The report of a JSON text, strictly: unknown keys, other types and longer texts are refused.

    Raises:
        BenchError: the text is not a report of this version.
    """
    hint = "Write it with `gym-extensions check-pr --json` of the same version."
    if len(data) > MAX_BYTES:
        raise BenchError("malformed-report", f"It has more than {MAX_BYTES} bytes.", hint=hint)
    try:
        report = GateReport.from_json(data)
        is_spelled_so = report.to_json().encode() == data
    except ValueError as error:
        raise BenchError("malformed-report", f"It is not a report: {error}.", hint=hint) from None
    texts = [text for problem in report.problems for text in problem.as_dict().values()]
    if not is_spelled_so or any(len(text) > MAX_TEXT for text in (*texts, *report.notes)):
        message = "It has unknown keys, another spelling, or longer texts than the command writes."
        raise BenchError("malformed-report", message, hint=hint)
    return report


HEADINGS = {
    "passed": "The submission passed",
    "review": "Passed; an owner or a maintainer has to agree",
    "refused": "Refused",
    "not-judged": "Not a submission",
}
CODE = "It changes code alone, which the ordinary tests check."
NEXT_RECORD = (
    "There is nothing more to do. After the merge, the policy is run on 100 new seeds that follow from the "
    "merge commit. If it keeps its claim and beats the expert there, the page of the task shows it."
)
NEXT = (
    "There is nothing more to do. After the merge, the policies are run on new seeds that follow from the "
    "merge commit. If the returns agree with the log, the entry is verified and has a rank."
)


def code_block(lines: Sequence[str]) -> str:
    """Lines as a code block that no text in them can end: texts of a pull request have no active markup."""
    text = "\n".join(line.replace("\n", " ") for line in lines)
    longest = max((len(run) for run in re.findall("`+", text)), default=0)
    fence = "`" * max(3, longest + 1)
    return f"{fence}text\n{text}\n{fence}"


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def _scores(report: GateReport) -> list[str]:
    rows = [
        f"{score.group}  {score.protocol}  {score.budget}  "
        f"{score.runs} {'run' if score.runs == 1 else 'runs'}  {score.metric} "
        f"{_number(score.mean)} [{_number(score.low)}, {_number(score.high)}]"
        for score in report.scores
    ]
    return [code_block(rows)] if rows else []


def _evidence(report: GateReport) -> list[str]:
    if report.level is None:
        return []
    sample = (
        f": {report.repeated} of {report.episodes} sampled episodes are repeated" if report.episodes else ""
    )
    return [f"Level: **{report.level}**{sample}."]


def _limits(report: GateReport) -> list[str]:
    """What keeps a new entry from the boards or from a rank, whatever follows."""
    off_boards = {name for name, each in BUDGETS.items() if not each.on_boards}
    if report.kind != "submission" or not report.scores:
        return []
    if all(score.budget in off_boards for score in report.scores):
        return [f"The budget `{report.scores[0].budget}` is for tests: no board will have the entry."]
    if all(score.runs < FULL_ENTRY_RUNS for score in report.scores):
        return [f"A rank needs {FULL_ENTRY_RUNS} runs."]
    return []


def comment(report: GateReport) -> str:
    """The comment as Markdown."""
    parts = [f"### {HEADINGS[report.verdict]}"]
    if report.entry:
        owners = ", ".join(f"`{name}`" for name in report.owners) if report.kind == "edit" else ""
        kind = "Record" if report.kind == "record" else "Entry"
        parts.append(f"{kind} `{report.entry}`{f' (owners: {owners})' if owners else ''}.")
    if report.verdict == "not-judged":
        parts.append(CODE)
    if report.problems:
        lines = [f"{each.where}: {each.rule}: {each.message} {each.hint}" for each in report.problems]
        more = [f"… and {report.more_problems} more"] if report.more_problems else []
        parts.append(code_block([*lines, *more]))
    parts += [*_evidence(report), *_scores(report)]
    if report.notes:
        parts += ["Notes, for a reader to judge:", code_block(report.notes)]
    if report.verdict in ("passed", "review"):
        parts += [NEXT_RECORD if report.kind == "record" else NEXT, *_limits(report)]
    parts.append(f"Judged by the code of {report.base[:12]}, for {report.head[:12]}.")
    return "\n\n".join(parts) + "\n"
