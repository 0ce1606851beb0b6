"""Reading a submission: what it holds, and everything that is wrong with it at once."""

from collections.abc import Callable
from pathlib import Path

from gym_extensions.submissions.problem import PROBLEMS_LISTED, Problem, escape, summarize
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import VERIFIED, level

from .examples import DOCUMENT, GROUP, LOG, TOML, CopySubmission, cell, edit, put, remove, rules


def test_a_submission_has_its_logs_documents_and_review(make_submission: Callable[..., Path]) -> None:
    read_ = read(make_submission(runs=(0, 1, 2, 3, 4), curves=3))
    assert read_.problems == ()
    assert read_.name == "submission"
    (group,) = read_.groups.values()
    assert {protocol: log.runs for protocol, log in group.logs.items()} == {
        "sequential": (0, 1, 2, 3, 4),
        "single": (0, 1, 2, 3, 4),
    }
    assert group.runs["single"][4].run == 4
    assert read_.manifest is not None
    assert level(read_.review, read_.manifest.digest, group.digests("sequential")) == VERIFIED
    assert len(read_.documents) == 10
    assert read_.memory is not None
    assert read_.memory.parameters_last == 100


def test_the_only_run_without_its_document_is_a_problem(make_submission: Callable[..., Path]) -> None:
    folder = make_submission(runs=(0,))
    remove(DOCUMENT)(folder)
    assert {problem.rule for problem in read(folder).problems} == {"missing-file"}


def test_problems_of_all_files_are_reported_at_once(make_submission: Callable[..., Path]) -> None:
    folder = make_submission()
    cell(2, 5, "nan")(folder)
    cell(3, 3, "7")(folder)
    edit("boundaries = false\n", "", TOML)(folder)
    put("notes.txt", b"")(folder)
    cell(2, 4, "12", f"{GROUP}/single/run0.csv")(folder)
    put("hopper-gravity/single/run1.json", b"{}")(folder)
    assert set(rules(read(folder).problems)) == {
        "different-log",
        "malformed-document",
        "missing-key",
        "not-finite",
        "unexpected-name",
        "unfinished-episode",
        "wrong-seed",
    }


def problem(rule: str, where: str) -> Problem:
    return Problem(rule, where, "It is wrong.", "Mend it.")


def test_unprintable_characters_are_escaped_in_problems_too() -> None:
    assert escape("plain: ü 強") == "plain: ü 強"
    assert escape("a\n\x1b[31m\u202e\udcff") == "a\\n\\x1b[31m\\u202e\\udcff"
    escaped = Problem("rule", "a\nb", "\x1b[31m", "\u202e")
    assert (escaped.where, escaped.message, escaped.hint) == ("a\\nb", "\\x1b[31m", "\\u202e")


def test_further_problems_are_counted_per_rule_after_the_listed_ones() -> None:
    problems = [
        *(problem("a", str(number)) for number in range(22)),
        *(problem("b", str(number)) for number in range(21)),
        problem("c", "0"),
    ]
    assert summarize(problems, "submission") == (
        *problems[:20],
        *problems[22:42],
        problems[43],
        Problem("a", "submission", "2 more problems of this rule.", "Mend it."),
        Problem("b", "submission", "1 more problem of this rule.", "Mend it."),
    )


def test_each_rule_lists_twenty_problems_and_counts_the_rest(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    for number in range(25):
        (folder / f"notes{number:04}.txt").touch()
    cell(2, 5, "nan")(folder)
    problems = read(folder).problems
    assert [problem.where for problem in problems[:PROBLEMS_LISTED]] == [
        f"notes{number:04}.txt" for number in range(PROBLEMS_LISTED)
    ]
    assert [problem.where for problem in problems[PROBLEMS_LISTED:]] == [LOG, f"{LOG}, line 2", "submission"]
    assert "5 more" in problems[-1].message
