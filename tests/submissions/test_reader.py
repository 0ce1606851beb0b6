"""Reading a submission: what it holds, and everything that is wrong with it at once."""

from collections.abc import Callable
from pathlib import Path

from gym_extensions.submissions.problem import PROBLEMS_LISTED
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import VERIFIED, level

from .examples import GROUP, LOG, TOML, cell, edit, put


def test_a_submission_has_its_logs_documents_and_review(make_submission: Callable[..., Path]) -> None:
    read_ = read(make_submission(runs=(0, 1, 2, 3, 4), curves=3))
    assert read_.problems == ()
    assert read_.name == "submission"
    (group,) = read_.groups.values()
    runs = {protocol: log.runs for protocol, log in group.logs.items()}
    assert runs == dict.fromkeys(("sequential", "single"), (0, 1, 2, 3, 4))
    assert group.runs["single"][4].run == 4
    assert read_.manifest is not None
    assert level(read_.review, read_.manifest.digest, group.digests("sequential")) == VERIFIED
    assert len(read_.documents) == 10
    assert read_.memory is not None
    assert read_.memory.parameters_last == 100


def test_problems_of_all_files_are_reported_at_once(make_submission: Callable[..., Path]) -> None:
    folder = make_submission()
    cell(2, 5, "nan")(folder)
    cell(3, 3, "7")(folder)
    edit("boundaries = false\n", "", TOML)(folder)
    put("notes.txt", b"")(folder)
    cell(2, 4, "12", f"{GROUP}/single/run0.csv")(folder)
    put("hopper-gravity/single/run1.json", b"{}")(folder)
    assert {problem.rule for problem in read(folder).problems} == {
        "different-log",
        "malformed-document",
        "missing-key",
        "not-finite",
        "unexpected-name",
        "unfinished-episode",
        "wrong-seed",
    }


def test_each_rule_lists_twenty_problems_and_counts_the_rest(folder: Path) -> None:
    for number in range(25):
        (folder / f"notes{number:04}.txt").touch()
    cell(2, 5, "nan")(folder)
    problems = read(folder).problems
    assert [problem.where for problem in problems[:PROBLEMS_LISTED]] == [
        f"notes{number:04}.txt" for number in range(PROBLEMS_LISTED)
    ]
    assert [problem.where for problem in problems[PROBLEMS_LISTED:]] == [LOG, f"{LOG}, line 2", "submission"]
    assert "5 more" in problems[-1].message
