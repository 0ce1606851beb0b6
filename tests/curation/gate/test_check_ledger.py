"""Pull requests with lines of the ledger or challenges: a maintainer decides, or a rule refuses them."""

from __future__ import annotations

import hashlib
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.curation.ledger.append import Author, append, repeated
from gym_extensions.curation.ledger.chain import read
from gym_extensions.curation.ledger.verify import check_folders

from ..repositories import commit
from .checks import checked, rules

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the gate needs limits that Windows lacks")


def test_appended_lines_of_the_ledger_go_to_a_maintainer(project: Path) -> None:
    line = read(project / "submissions")[-1]
    append(project / "submissions", [repeated(line, "challenged", Author("2026-01-02", "In doubt."))])
    commit(project)
    report = checked(project)
    assert (report.kind, report.verdict, report.labels) == ("ledger", "review", ("ledger",))


def test_an_edited_line_of_the_ledger_is_refused_even_with_a_whole_chain(project: Path) -> None:
    line = read(project / "submissions")[-1]
    (project / "submissions" / "ledger.jsonl").unlink()
    append(project / "submissions", [replace(line, reason="Another reason.")])
    commit(project)
    assert rules(checked(project)) == [("ledger-edited", "submissions/ledger.jsonl")]


def test_a_line_that_breaks_the_chain_is_refused(project: Path) -> None:
    path = project / "submissions" / "ledger.jsonl"
    line = repeated(read(project / "submissions")[-1], "challenged", Author("2026-01-02", "In doubt."))
    commit(project, {"submissions/ledger.jsonl": path.read_bytes() + line.encode()})
    assert rules(checked(project)) == [("ledger-chain", "submissions/ledger.jsonl, row 2")]


def test_a_line_about_other_files_is_refused(project: Path) -> None:
    line = replace(read(project / "submissions")[-1], entry="absent", date="2026-01-02")
    append(project / "submissions", [line])
    commit(project)
    assert rules(checked(project)) == [("ledger-entry", "absent")]


def test_a_line_about_an_entry_without_files_is_refused(project: Path) -> None:
    line = read(project / "submissions")[-1]
    nothing = hashlib.sha256(b"").hexdigest()
    append(project / "submissions", [replace(line, entry="absent", digest=nothing)])
    commit(project)
    assert rules(checked(project)) == [("ledger-entry", "absent")]
    assert [(problem.rule, problem.message) for problem in check_folders(project / "submissions")] == [
        ("ledger-entry", "The folder is absent.")
    ]


@pytest.mark.parametrize(
    ("path", "text", "expected"),
    [
        ("challenges/old/a.txt", "In doubt.\n", []),
        ("challenges/new/a.txt", "In doubt.\n", [("unknown-entry", "challenges/new/a.txt")]),
        ("challenges/old/a.html", "<b>\n", [("challenge-name", "challenges/old/a.html")]),
        ("challenges/old/a.txt", "\x1b[2J\n", [("challenge-text", "challenges/old/a.txt")]),
    ],
)
def test_a_challenge_goes_to_a_maintainer_if_it_is_plain_text_about_an_entry(
    project: Path, path: str, text: str, expected: list[tuple[str, str]]
) -> None:
    commit(project, {path: text})
    report = checked(project)
    assert (report.kind, rules(report)) == ("challenge", expected)
    assert report.verdict == ("refused" if expected else "review")
