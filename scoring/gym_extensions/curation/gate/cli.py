"""``gym-extensions check-pr``: checks a pull request with a submission."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from gym_extensions.curation.gate.check import Request, check_pull_request
from gym_extensions.curation.gate.comment import comment
from gym_extensions.curation.gate.report import GateReport, read_report
from gym_extensions.curation.gate.rules import RULES
from gym_extensions.curation.git import Repository
from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.scoring.documents import json_schema


def parser() -> argparse.ArgumentParser:
    """The command's arguments."""
    command = argparse.ArgumentParser(
        prog="gym-extensions check-pr",
        description="Check a pull request with a submission. Its files are read from git and never executed.",
        epilog="Exit status: 0 passed or code alone, 1 refused, 2 wrong usage.",
    )
    add = command.add_argument
    add("--base", default="main", metavar="BRANCH", help="branch that it is for (default: main)")
    add("--head", default="HEAD", metavar="COMMIT", help="its last commit (default: HEAD)")
    add("--repository", type=Path, default=Path(), metavar="DIR", help="a clone (default: this folder)")
    add(
        "--value",
        default="",
        metavar="HEX",
        help="derive the salt of the audit sample from this number (default: from the commit that fixed the "
        "entry, if only its traces change; else no salt)",
    )
    add("--number", type=int, metavar="N", help="number of the pull request, for the report")
    output = command.add_mutually_exclusive_group()
    output.add_argument("--json", action="store_true", help="print the report as JSON")
    output.add_argument("--schema", action="store_true", help="print the JSON Schema of reports")
    output.add_argument("--rules", action="store_true", help="print the rules")
    output.add_argument("--comment", type=Path, metavar="REPORT", help="print a report as Markdown")
    output.add_argument("--labels", type=Path, metavar="REPORT", help="print the labels of a report")
    return command


def _read(path: Path) -> GateReport:
    try:
        return read_report(path.read_bytes())
    except OSError as error:
        raise BenchError("no-report", f"{error.strerror}.", str(path), "Name a file.") from None


def _print(text: str) -> None:
    sys.stdout.flush()
    sys.stdout.buffer.write(text.encode())
    sys.stdout.buffer.flush()


def _document(options: argparse.Namespace) -> str | None:
    """What the options that check nothing print; None for the others."""
    if options.schema:
        return json.dumps(json_schema(GateReport), indent=1, sort_keys=True) + "\n"
    if options.rules:
        rows = [f"{name}: {' '.join((rule.__doc__ or '').split())}\n" for name, rule in RULES.items()]
        return "".join(rows)
    if options.comment:
        return comment(_read(options.comment))
    if options.labels:
        return "".join(f"{label}\n" for label in _read(options.labels).labels)
    return None


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs the command and returns the exit status."""
    options = parser().parse_args(argv)
    if (document := _document(options)) is not None:
        _print(document)
        return 0
    repository = Repository(options.repository)
    report = check_pull_request(
        Request(repository, options.base, options.head, options.value, options.number)
    )
    _print(report.to_json() if options.json else comment(report))
    return 1 if report.verdict == "refused" else 0


if __name__ == "__main__":
    sys.exit(main())
