"""The check of a pull request to a test's project, and the rules that it names."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from gym_extensions.curation.gate import Request, check_pull_request
from gym_extensions.curation.git import Repository
from gym_extensions.curation.report import GateReport


def checked(project: Path, **changes: object) -> GateReport:
    """The report on the project's branch that is checked out, as a pull request to ``main``."""
    request = Request(Repository(project), "main")
    return check_pull_request(replace(request, **changes))  # type: ignore[arg-type]


def rules(report: GateReport) -> list[tuple[str, str]]:
    """The rule and the place of every problem."""
    return [(problem.rule, problem.where) for problem in report.problems]
