"""The ledger command: recording entries, their salts, and what is refused by name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.curation.digest import folder_hashes
from gym_extensions.curation.evidence import prove
from gym_extensions.curation.ledger import append
from gym_extensions.curation.ledger.chain import FILE, read
from gym_extensions.curation.salt import derive_salt
from gym_extensions.rollouts.auditing.submission_digest import digest_without_traces
from gym_extensions.rollouts.problem import Problem

from ..repositories import commit, git, write_entry
from .commands import VALUE, ledger, problem, record


def test_recording_accepts_new_entries_supersedes_changed_ones_and_withdraws_removed_ones(
    history: tuple[Path, list[str]],
) -> None:
    lines = read(history[0] / "submissions")
    assert [(line.date, line.event, line.entry) for line in lines] == [
        ("2026-01-01", "accepted", "first"),
        ("2026-01-01", "accepted", "second"),
        ("2026-01-02", "superseded", "first"),
        ("2026-01-02", "accepted", "first"),
        ("2026-01-03", "withdrawn", "second"),
    ]
    assert {(line.level, line.replayed) for line in lines} == {("validated", 0)}
    salt = derive_salt(digest_without_traces(folder_hashes(history[0] / "submissions" / "first")), VALUE)
    assert [(line.value, line.salt) for line in lines][3:] == [(VALUE, salt), ("", "")]


def test_recording_again_appends_nothing(repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (repository / "submissions" / FILE).read_bytes()
    record(repository, "2026-02-01")
    assert capsys.readouterr().out == "The ledger agrees with the folder.\n"
    assert (repository / "submissions" / FILE).read_bytes() == before


def test_the_commit_that_fixed_an_entry_gives_its_salt_whatever_happens_to_its_traces(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    merged = git(repository, "rev-list", "--reverse", "HEAD").split()[1]
    commit(repository, {"submissions/first/halfcheetah-gravity/traces/salt.txt": "x"})
    (repository / "submissions/first/halfcheetah-gravity/traces/salt.txt").unlink()
    reason = ("--reason", "Salted.", "--date", "2026-02-01", "--value", "merge")
    assert ledger(repository, "add", "rescored", "first", *reason) == 0
    line = read(repository / "submissions")[-1]
    digest = digest_without_traces(folder_hashes(repository / "submissions" / "first"))
    assert (line.value, line.salt) == (merged, derive_salt(digest, merged))
    capsys.readouterr()
    assert ledger(repository, "salt", "first") == 0
    assert capsys.readouterr().out == f"{line.salt}\n"
    assert ledger(repository, "salt", "first", "--value", "5" * 64) == 0
    assert capsys.readouterr().out == f"{derive_salt(digest, '5' * 64)}\n"
    (repository / "submissions" / "first" / "README.md").write_text("Not committed.\n")
    assert "Its files are not those of the last commit." in problem(
        capsys, repository, "add", "rescored", "first", *reason
    )


def test_an_entry_without_a_commit_on_the_branch_has_no_salt(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (repository / "submissions" / "second" / ".progress").mkdir(parents=True)
    assert "No commit of this branch has the entry." in problem(capsys, repository, "salt", "second")


def test_a_salted_entry_needs_the_value_of_its_salt(
    repository: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    evidence = prove(repository / "submissions" / "first")
    other = replace(evidence, level=None, problems=(Problem("other-salt", "salt.txt", "Another.", ""),))
    monkeypatch.setattr(append, "prove", lambda *_: other)
    message = problem(capsys, repository, "add", "rescored", "first", "--reason", "Why.")
    assert "It has 1 problem, first other-salt: Another. Pass --value merge if the salt of" in message


@pytest.mark.parametrize("reason", ["", " "])
def test_an_empty_reason_is_refused(
    repository: Path, capsys: pytest.CaptureFixture[str], reason: str
) -> None:
    message = problem(capsys, repository, "add", "withdrawn", "first", "--reason", reason)
    assert message == "error: --reason: The reason is empty. Give one sentence.\n"


def test_a_submission_with_problems_is_not_accepted(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (repository / "submissions" / FILE).read_bytes()
    write_entry(repository / "submissions", "broken")
    (repository / "submissions" / "broken" / "notes.txt").write_text("x")
    message = problem(capsys, repository, "add", "accepted", "broken", "--reason", "Why.")
    assert "broken/notes.txt: It has 1 problem, first unexpected-name:" in message
    assert (repository / "submissions" / FILE).read_bytes() == before


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("add accepted frist", "There is no submission 'frist'. Did you mean 'first'?"),
        ("add withdrawn frist", "The ledger has no entry 'frist'. Did you mean 'first'?"),
        ("add accepted first", "The entry 'first' was accepted already."),
        ("add rescored first --value xyz", "The value 'xyz' is malformed."),
        ("add challenged first --date 2025-01-01", "2025-01-01 is before 2026-01-03."),
        (
            "add rescored first --level reproduced",
            "The level reproduced needs another evidence than validated.",
        ),
        ("add rescored first --level re-evaluated", "reevaluations/first.json: The file does not exist."),
    ],
)
def test_wrong_arguments_are_named(
    repository: Path, capsys: pytest.CaptureFixture[str], command: str, message: str
) -> None:
    assert message in problem(capsys, repository, *command.split(), "--reason", "Why.")


def test_the_salt_of_an_entry_that_does_not_exist_is_refused(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "There is no submission 'frist'. Did you mean" in problem(capsys, repository, "salt", "frist")


def test_a_board_after_lines_that_do_not_exist_is_refused(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    message = problem(capsys, repository, "board", "--lines", "9", "--out", "boards.json")
    assert "The ledger has 5 lines, so there is no line 9." in message


def test_a_folder_outside_of_git_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_entry(tmp_path / "submissions", "first")
    assert "There is no ledger." in problem(capsys, tmp_path, "verify")
    record(tmp_path, "2026-01-01")
    assert "It is not a git work tree." in problem(capsys, tmp_path, "verify")
