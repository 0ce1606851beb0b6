"""The result of the gate as a JSON document, which the second workflow reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

import msgspec

from gym_extensions.curation.gate.judgement import GateScore
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.problem import Problem
from gym_extensions.scoring.documents import JsonDocument, about
from gym_extensions.scoring.scorecard.record import Level

Kind = Literal["submission", "edit", "ledger", "challenge", "code", "none"]
Verdict = Literal["passed", "review", "refused", "not-judged"]
Label = Literal["submission", "edits-entry", "ledger", "challenge", "refused", "validated", "replayed"]
MAX_BYTES = 2**20
MAX_PROBLEMS = 50
MAX_TEXT = 500
"""Problems and notes of a report, and characters of each of their texts."""

OWNER = "@[A-Za-z0-9][A-Za-z0-9-]*(/[A-Za-z0-9._-]+)?"
"""A user or team of the code host."""
CommitId: TypeAlias = Annotated[str, msgspec.Meta(pattern="^[0-9a-f]{40,64}$")]
Sha256: TypeAlias = Annotated[str, msgspec.Meta(pattern="^([0-9a-f]{64})?$")]


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
            "`submission` (a new entry), `edit` (of an existing one), `ledger`, `challenge`, `code`, or "
            "`none` if it changes nothing that has a kind"
        ),
    ]
    verdict: Annotated[
        Verdict,
        about(
            "`passed`; `review`: passed, and its owner or a maintainer must agree; `refused`: it has "
            "problems; `not-judged`: it changes code alone, which the ordinary tests check"
        ),
    ]
    entry: Annotated[str, msgspec.Meta(pattern=r"^([A-Za-z0-9][A-Za-z0-9._-]{0,63})?$")] = ""
    owners: Annotated[
        tuple[Annotated[str, msgspec.Meta(pattern=f"^{OWNER}$")], ...],
        msgspec.Meta(max_length=MAX_PROBLEMS, description="owners of the entry, from CODEOWNERS of the base"),
    ] = ()
    digest: Annotated[Sha256, about("digest of the entry's files; empty unless judged")] = ""
    value: Annotated[
        str, msgspec.Meta(pattern="^([0-9a-f]{40,128})?$", description="what the salt was derived from")
    ] = ""
    salt: Annotated[Sha256, about("salt of the audit sample; empty without a value")] = ""
    level: Annotated[Level | None, about("level of trust; null unless judged without a problem")] = None
    replayed: Annotated[int, about("number of episodes that were replayed")] = 0
    episodes: Annotated[int, about("number of episodes in the logs")] = 0
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


def cut_problem(problem: Problem) -> Problem:
    """A problem whose texts have at most ``MAX_TEXT`` characters."""
    return Problem(problem.rule, cut(problem.where), cut(problem.message), cut(problem.hint))


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
