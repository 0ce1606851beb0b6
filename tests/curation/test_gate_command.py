"""The gate's command: its report as JSON, labels and comment, its error messages, and its list of rules."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.curation.cli import check_pr as main
from gym_extensions.curation.pull_request import RULES
from gym_extensions.curation.report import read_report

from .repositories import commit

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the gate needs limits that Windows lacks")


@pytest.mark.usefixtures("no_judge")
def test_the_command_prints_a_report_that_its_schema_allows_and_reads_it_back(
    project: Path, tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    commit(project, {"submissions/old/README.md": "A text.\n"})
    assert main(["--repository", str(project), "--base", "main", "--json", "--number", "3"]) == 0
    printed = capfdbinary.readouterr().out
    report = read_report(printed)
    assert (report.pull_request, report.kind, report.verdict) == (3, "edit", "review")
    path = project / "report.json"
    path.write_bytes(printed)
    assert main(["--labels", str(path)]) == 0
    assert capfdbinary.readouterr().out == b"claimed\nedits-entry\n"
    without = tmp_path / "without.json"
    without.write_text(replace(report, kind="code", verdict="not-judged", labels=()).to_json())
    assert main(["--labels", str(without)]) == 0
    assert capfdbinary.readouterr().out == b""
    assert main(["--comment", str(path)]) == 0
    assert b"\n`@alice` <img>\n```" in capfdbinary.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--base", "absent"], "There is no commit 'absent'."),
        (["--head=--all"], "There is no commit '--all'."),
        (["--repository", "/"], "It is not a git work tree."),
        (["--comment", "absent.json"], "absent.json: No such file or directory."),
    ],
)
def test_wrong_arguments_are_named(
    project: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    assert main(["--repository", str(project), *options]) == 2
    assert message in capsys.readouterr().err


def test_every_rule_has_a_text(capfdbinary: pytest.CaptureFixture[bytes]) -> None:
    assert main(["--rules"]) == 0
    lines = capfdbinary.readouterr().out.decode().splitlines()
    assert [line.split(": ")[0] for line in lines] == list(RULES)
    assert all(line.split(": ", 1)[1].endswith((".", ")")) for line in lines)
