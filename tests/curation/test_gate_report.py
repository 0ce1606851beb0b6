"""The report of the gate: its command, its strict reader, and a comment without active markup."""

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.curation import gate_report
from gym_extensions.curation.cli import check_pr as main
from gym_extensions.submissions.problem import Problem

from ..conftest import refused
from .repositories import commit

REPORT = gate_report.GateReport(
    pull_request=3,
    base="a" * 40,
    head="b" * 40,
    kind="submission",
    verdict="passed",
    submission="submission",
    level="claimed",
    repeated=380,
    episodes=400,
    scores=(
        gate_report.GateScore("hopper-v0", "sequential", "1M", 5, "final_performance", 1.234, 1.0, None),
    ),
)


def test_a_report_is_read_back_as_it_was() -> None:
    assert gate_report.read_report(REPORT.to_json().encode()) == REPORT


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("format", 2),
        ("head", "--all"),
        ("kind", "praise"),
        ("verdict", "merged"),
        ("submission", "../submission"),
        ("level", "verified"),
        ("notes", ["x" * 501]),
        ("problems", [{"rule": "r", "where": "", "message": "\x1b[2J", "hint": ""}]),
        ("problems", [{"rule": "r", "where": "", "message": "", "hint": ""}] * 51),
        ("unknown", 1),
    ],
)
def test_a_value_that_the_gate_never_writes_is_refused(key: str, value: object) -> None:
    values = {**json.loads(REPORT.to_json()), key: value}
    text = json.dumps(values, sort_keys=True, ensure_ascii=False, indent=1) + "\n"
    with refused("malformed-report"):
        gate_report.read_report(text.encode())


@pytest.mark.parametrize("data", [b"", b"[]", b"\xff", b"x" * (gate_report.MAX_BYTES + 1)])
def test_bytes_that_are_not_a_report_are_refused(data: bytes) -> None:
    with refused("malformed-report"):
        gate_report.read_report(data)


def test_the_comment_says_what_was_proven() -> None:
    text = gate_report.comment(REPORT)
    assert text.startswith("### The submission passed\n\nSubmission `submission`.")
    assert "Level: **claimed**: 380 of 400 sampled episodes are repeated." in text
    assert "hopper-v0  sequential  1M  5 runs  final_performance 1.23 [1.00, –]" in text


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({}, "the submission is verified and has a rank"),
        ({"scores": (replace(REPORT.scores[0], runs=4),)}, "is verified.\n\nA rank needs 5 runs."),
        ({"without_policies": 4}, "gets no rank, because 4 runs published no policies"),
        ({"kind": "edit"}, "and all runs if the settings changed, are verified on them."),
        ({"kind": "donation"}, "It is scored as soon as all runs with lower numbers are there"),
        ({"level": "reported", "repeated": 0, "episodes": 0}, "A published table is shown, without a rank"),
    ],
)
def test_the_comment_says_what_follows(changes: dict[str, Any], text: str) -> None:
    said = gate_report.comment(replace(REPORT, **changes))
    assert text in said
    assert ("has a rank" in said) == (not changes)


def test_texts_of_the_pull_request_stay_in_a_code_block() -> None:
    problem = Problem("rule", "a```b", "@alice ![x](https://example.org)\n# heading", "<script>")
    text = gate_report.comment(replace(REPORT, verdict="refused", problems=(problem,), more_problems=2))
    block = "````text\na```b: rule: @alice ![x](https://example.org)\\n# heading <script>\n… and 2 more\n````"
    assert block in text
    assert gate_report.code_block(["`````"]) == "``````text\n`````\n``````"


def test_a_long_comment_is_cut_to_what_the_code_host_takes() -> None:
    problem = Problem("malformed-toml", *("x" * 500,) * 3)
    report = replace(
        REPORT,
        problems=(problem,) * gate_report.MAX_PROBLEMS,
        more_problems=7,
        notes=("`" * 500,) * gate_report.MAX_PROBLEMS,
        scores=REPORT.scores * 400,
    )
    text = gate_report.comment(report)
    assert len(text) < 65_536
    shown = text.count("malformed-toml")
    assert f"x\n… and {gate_report.MAX_PROBLEMS + 7 - shown} more\n```" in text


@pytest.mark.skipif(sys.platform == "win32", reason="the gate needs limits that Windows lacks")
@pytest.mark.usefixtures("no_judge")
def test_the_command_prints_a_report_that_its_schema_allows_and_reads_it_back(
    project: Path, tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    commit(project, {"submissions/old/README.md": "A text.\n"})
    assert main(["--repository", str(project), "--base", "main", "--json", "--number", "3"]) == 0
    printed = capfdbinary.readouterr().out
    report = gate_report.read_report(printed)
    assert (report.pull_request, report.kind, report.verdict) == (3, "edit", "review")
    path, without = tmp_path / "report.json", tmp_path / "without.json"
    path.write_bytes(printed)
    without.write_text(replace(report, kind="code", verdict="not-judged", level=None).to_json())
    for each, labels in ((path, b"claimed\nedits-submission\n"), (without, b"")):
        assert main(["--labels", str(each)]) == 0
        assert capfdbinary.readouterr().out == labels
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
