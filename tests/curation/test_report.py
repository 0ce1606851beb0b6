"""Reports are read strictly, and their comment has no active markup of strangers."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from gym_extensions.curation.report import MAX_BYTES, GateReport, GateScore, code_block, comment, read_report
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.problem import Problem

REPORT = GateReport(
    pull_request=3,
    base="a" * 40,
    head="b" * 40,
    kind="submission",
    verdict="passed",
    entry="entry",
    level="claimed",
    repeated=380,
    episodes=400,
    scores=(GateScore("hopper-gravity-v0", "sequential", "1M", 5, "final_performance", 1.234, 1.0, None),),
    labels=("claimed", "submission"),
)


def test_a_report_is_read_back_as_it_was() -> None:
    assert read_report(REPORT.to_json().encode()) == REPORT


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("format", 2),
        ("head", "--all"),
        ("kind", "praise"),
        ("verdict", "merged"),
        ("entry", "../entry"),
        ("level", "verified"),
        ("labels", ["maintainer-approved"]),
        ("owners", ["@x)\n\n# Refused [Sign in](https://example.org)"]),
        ("owners", ["x"]),
        ("notes", ["x" * 501]),
        ("problems", [{"rule": "r", "where": "", "message": "\x1b[2J", "hint": ""}]),
        ("problems", [{"rule": "r", "where": "", "message": "", "hint": ""}] * 51),
        ("unknown", 1),
    ],
)
def test_a_value_that_the_gate_never_writes_is_refused(key: str, value: object) -> None:
    values = {**json.loads(REPORT.to_json()), key: value}
    text = json.dumps(values, sort_keys=True, ensure_ascii=False, indent=1) + "\n"
    with pytest.raises(BenchError) as error:
        read_report(text.encode())
    assert error.value.code == "malformed-report"


@pytest.mark.parametrize("data", [b"", b"[]", b"\xff", b"x" * (MAX_BYTES + 1)])
def test_bytes_that_are_not_a_report_are_refused(data: bytes) -> None:
    with pytest.raises(BenchError) as error:
        read_report(data)
    assert error.value.code == "malformed-report"


def test_the_comment_says_what_was_proven() -> None:
    text = comment(REPORT)
    assert text.startswith("### The submission passed\n\nEntry `entry`.")
    assert "Level: **claimed**: 380 of 400 sampled episodes are repeated." in text
    assert "hopper-gravity-v0  sequential  1M  5 runs  final_performance 1.23 [1.00, –]" in text


@pytest.mark.parametrize(
    ("budget", "runs", "sentence"),
    [
        ("smoke", 5, "The budget `smoke` is for tests: no board will have the entry."),
        ("300k", 4, "A rank needs 5 runs."),
        ("300k", 5, ""),
    ],
)
def test_the_comment_says_what_keeps_an_entry_from_a_rank(budget: str, runs: int, sentence: str) -> None:
    scores = tuple(replace(score, budget=budget, runs=runs) for score in REPORT.scores)
    lines = comment(replace(REPORT, scores=scores)).splitlines()
    shown = [line for line in lines if line.startswith(("The budget", "A rank"))]
    assert shown == ([sentence] if sentence else [])


def test_texts_of_the_pull_request_stay_in_a_code_block() -> None:
    problem = Problem("rule", "a```b", "@alice ![x](https://example.org)\n# heading", "<script>")
    text = comment(replace(REPORT, verdict="refused", problems=(problem,), more_problems=2))
    block = "````text\na```b: rule: @alice ![x](https://example.org)\\n# heading <script>\n… and 2 more\n````"
    assert block in text
    assert code_block(["`````"]) == "``````text\n`````\n``````"
