"""The story of a record: a pull request with two files, the gate, the merge, the review; and forgeries."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.curation.cli import maintain
from gym_extensions.curation.gate_report import comment
from gym_extensions.scoring.records import Record, read_record_review

from ..verification.made_records import change_card, claim_more, lower_the_bar, make_record, record_path
from .repositories import checked, commit, git, make_repository, rules

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the gate needs limits that Windows lacks")

HOPPER = "records/Hopper"


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, in_this_process: None) -> Path:
    """A repository whose branch ``request``, which is checked out, adds a record. It runs in this process."""
    lower_the_bar(monkeypatch)
    folder = make_repository(tmp_path / "project")
    commit(folder, {"records/README.md": "Records.\n", "scoring/rank.py": "rank = 1\n"})
    git(folder, "switch", "--quiet", "-c", "request")
    make_record(folder / "records")
    commit(folder)
    return folder


def test_a_record_is_shown_after_one_pull_request(project: Path, tmp_path: Path) -> None:
    report = checked(project)
    assert (report.kind, report.verdict, report.submission) == ("record", "passed", "Hopper/mine")
    assert (report.labels, report.episodes) == (["record"], 20)
    assert "Record `Hopper/mine`." in comment(report)
    git(project, "switch", "--quiet", "main")
    git(project, "merge", "--quiet", "--no-ff", "--no-edit", "request")
    merge, reviews = git(project, "rev-parse", "HEAD"), tmp_path / "reviews"
    assert maintain(["review", str(project / "records"), "--record", str(reviews)]) == 0
    file = reviews / HOPPER / "mine.review.json"
    card, other = record_path(project), "3f" * 20
    for old, new in (
        (merge, other),
        ('"problem": ""', '"problem": "It falls."'),
        ('"episodes": 100', '"episodes": 99'),
        (Record(card).digest, "0" * 64),
    ):
        forged = tmp_path / "forged.json"
        forged.write_text(file.read_text().replace(old, new))
        assert maintain(["review", str(card), "--take", str(forged)]) == 2
        assert git(project, "status", "--porcelain") == ""
    assert maintain(["review", str(card), "--take", str(file)]) == 0
    assert git(project, "status", "--porcelain").split() == ["??", f"{HOPPER}/mine.review.json"]
    assert (Record(card).verified, read_record_review(file).value) == (True, merge)
    assert maintain(["review", str(card), "--take", str(file)]) == 2, "the first draw stands"


def other_policy(project: Path) -> None:
    record_path(project).with_suffix(".npz").write_bytes(b"no archive")


def other_fingerprint(project: Path) -> None:
    record = Record(record_path(project))
    change_card(record, record.card.fingerprint, "0" * 16)


WRONG: dict[str, tuple[str, Callable[[Path], object]]] = {
    "a claim that is too high": ("no-record", lambda project: claim_more(Record(record_path(project)))),
    "a card of another definition of the task": ("foreign-fingerprint", other_fingerprint),
    "a file that is no policy": ("bad-policy", other_policy),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_record_with_wrong_files_is_refused_by_name(project: Path, name: str) -> None:
    rule, change = WRONG[name]
    change(project)
    commit(project)
    report = checked(project)
    assert report.verdict == "refused"
    assert rules(report) == [(rule, "Hopper/mine")]


BESIDES = {
    "the scorer": ("code-and-data", "scoring/rank.py", {"scoring/rank.py": "rank = 2\n"}),
    "the text about records": ("code-and-data", "records/README.md", {"records/README.md": "Mine.\n"}),
    "a submission": ("several-submissions", "submissions", {"submissions/new/README.md": "x"}),
    "a review": ("written-by-the-base", f"{HOPPER}/mine.review.json", {f"{HOPPER}/mine.review.json": "{}"}),
    "a second record": (
        "several-submissions",
        "submissions",
        {f"{HOPPER}/b.npz": "x", f"{HOPPER}/b.json": "{}"},
    ),
    "half a record": ("new-record", f"{HOPPER}/half", {f"{HOPPER}/half.npz": "x"}),
    "a record of no task": ("new-record", "records/Hoper/a", {"records/Hoper/a.npz": "x"}),
    "a file of another kind": ("stray-file", f"{HOPPER}/mine.txt", {f"{HOPPER}/mine.txt": "x"}),
    "a large card": ("too-large", f"{HOPPER}/mine.json", {f"{HOPPER}/mine.json": "x" * 70_000}),
}


@pytest.mark.parametrize("name", BESIDES)
def test_a_record_and_something_else_is_refused_by_name(project: Path, name: str) -> None:
    rule, where, files = BESIDES[name]
    commit(project, files)
    report = checked(project)
    assert report.verdict == "refused"
    assert (rule, where) in rules(report)


def test_a_record_never_changes_and_is_not_copied(project: Path) -> None:
    git(project, "switch", "--quiet", "main")
    git(project, "merge", "--quiet", "--ff-only", "request")
    git(project, "switch", "--quiet", "request")
    change_card(Record(record_path(project)), "A. Author", "B. Author")
    policy = record_path(project).with_suffix(".npz").read_bytes()
    commit(project, {f"{HOPPER}/copy.npz": policy})
    found = rules(checked(project))
    assert ("new-record", f"{HOPPER}/mine") in found
    assert ("copied-run", f"{HOPPER}/copy.npz") in found
