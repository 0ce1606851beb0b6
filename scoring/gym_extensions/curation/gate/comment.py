"""A report as a Markdown comment. Texts of the pull request are in code blocks, where no markup is active."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.protocol import FULL_ENTRY_RUNS
from gym_extensions.curation.gate.report import GateReport

HEADINGS = {
    "passed": "The submission passed",
    "review": "Passed; an owner or a maintainer has to agree",
    "refused": "Refused",
    "not-judged": "Not a submission",
}
CODE = "It changes code alone, which the ordinary tests check."
NEXT = {
    "submission": "After the merge, the merge commit determines the salt of the audit sample, and a second "
    "pull request replaces the traces by those of that sample. A maintainer then appends `accepted` to the "
    "ledger. Until then the boards list the entry without a rank.",
    "edit": "After the merge, a maintainer appends `accepted` to the ledger, after `superseded` where an "
    "earlier state of the files was accepted.",
    "ledger": "A maintainer has to agree to the new lines.",
    "challenge": "A maintainer has to agree that it is shown on the entry's page.",
}


def code_block(lines: Sequence[str]) -> str:
    """Lines in a fenced block, whose fence is longer than every run of backticks in them."""
    text = "\n".join(line.replace("\n", " ") for line in lines)
    fence = "`" * max(3, 1 + max((len(run) for run in re.findall("`+", text)), default=0))
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
    replayed = f": {report.replayed} of {report.episodes} episodes" if report.replayed else ""
    salt = f", salt {report.salt}" if report.salt else ""
    return [f"Level: **{report.level}**{replayed}.", code_block([f"digest {report.digest}{salt}"])]


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
        owners = (
            f" (owners: {', '.join(f'`{name}`' for name in report.owners)})"
            if report.kind == "edit" and report.owners
            else ""
        )
        parts.append(f"Entry `{report.entry}`{owners}.")
    if report.kind == "code" and report.verdict == "not-judged":
        parts.append(CODE)
    if report.problems:
        rows = [
            f"{problem.where}: {problem.rule}: {problem.message} {problem.hint}"
            for problem in report.problems
        ]
        more = [f"… and {report.more_problems} more"] if report.more_problems else []
        parts.append(code_block([*rows, *more]))
    parts += [*_evidence(report), *_scores(report)]
    if report.notes:
        parts += ["Notes, for a reader to judge:", code_block(report.notes)]
    if report.verdict in ("passed", "review") and report.kind in NEXT:
        parts += [NEXT[report.kind], *_limits(report)]
    parts.append(f"Judged by the code of {report.base[:12]}, for {report.head[:12]}.")
    return "\n\n".join(parts) + "\n"
