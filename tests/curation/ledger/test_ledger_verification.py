"""Verification of a ledger: its git history, the digests of the entries, their evidence and their salts."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from gym_extensions.curation.digest import folder_digest, tree_digest
from gym_extensions.curation.git import Repository
from gym_extensions.curation.ledger.chain import FILE, read
from gym_extensions.curation.ledger.verify import check_folders
from gym_extensions.scoring.leaderboard.board import boards

from ..repositories import commit, git, write_entry
from .commands import VALUE, cards, ledger, problem, record


def test_verify_passes_and_names_what_it_checked(
    history: tuple[Path, list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert ledger(history[0], "verify", "--replay") == 0
    last = read(history[0] / "submissions")[-1].sha256
    assert capsys.readouterr().out.splitlines() == [
        f"chain: 5 lines, last {last}",
        "git history: 3 versions, lines were only appended",
        "digests: 1 of 1 entries agree",
        "replay: first: as stated",
    ]


def test_a_ledger_that_was_started_anew_with_a_whole_chain_is_refused(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (repository / "submissions" / FILE).unlink()
    record(repository, "2026-02-01")
    expected = "Row 1 is not the one of commit "
    assert expected in problem(capsys, repository, "verify")
    commit(repository)
    assert expected in problem(capsys, repository, "verify")
    assert ledger(repository, "verify", "--no-history") == 0


def test_a_ledger_that_was_removed_for_a_time_is_refused(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    content = (repository / "submissions" / FILE).read_bytes()
    commit(repository, {f"submissions/{FILE}": None})
    commit(repository, {f"submissions/{FILE}": content})
    assert "removed the ledger." in problem(capsys, repository, "verify")


def test_a_shallow_clone_cannot_check_the_history(
    history: tuple[Path, list[str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    git(tmp_path, "clone", "--quiet", "--depth", "1", history[0].as_uri(), "clone")
    assert "The clone lacks older commits." in problem(capsys, tmp_path / "clone", "verify")


def test_changed_files_are_named_and_their_entry_is_not_ranked(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_entry(repository / "submissions", "first", bonus=21.0)
    assert ledger(repository, "verify") == 1
    assert "first: ledger-entry: The files are not the accepted ones." in capsys.readouterr().out
    (row,) = boards(list(cards(repository).values())).boards[0].rows
    assert (row.ranked, row.why) == (False, "Not accepted yet: the ledger does not have its files.")


def test_evidence_that_the_ledger_states_wrongly_is_named(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = repository / "submissions" / FILE
    path.unlink()
    record(repository, "2026-01-01")
    path.write_bytes(
        path.read_bytes().replace(b'"validated"', b'"replayed"').replace(b'"replayed":0', b'"replayed":3')
    )
    assert ledger(repository, "verify", "--no-history", "--replay") == 1
    expected = "first: ledger-evidence: Replay verified 0 of 200 episodes; the ledger states 3 of 200."
    assert expected in capsys.readouterr().out


def test_a_salt_that_does_not_follow_from_its_value_is_named(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = repository / "submissions" / FILE
    path.unlink()
    record(repository, "2026-01-01", "A reason.", "--value", VALUE)
    path.write_bytes(path.read_bytes().replace(VALUE.encode(), b"0" * 40))
    assert ledger(repository, "verify", "--no-history") == 1
    assert "first: ledger-salt: The salt of its line does not follow" in capsys.readouterr().out


def test_the_committed_ledger_agrees_with_the_committed_submissions() -> None:
    folder = Path(__file__).parents[3] / "submissions"
    assert (len(read(folder)) > 0, check_folders(folder)) == (True, ())


@pytest.mark.skipif(sys.platform != "linux", reason="the command is that of GNU coreutils")
def test_the_digest_is_what_coreutils_and_git_give(repository: Path) -> None:
    folder = repository / "submissions" / "first"
    (folder / ".progress").mkdir(exist_ok=True)
    (folder / ".progress" / "train.log").write_text("not part of the submission")
    command = "find * -type f | LC_ALL=C sort | xargs sha256sum | sha256sum"
    shown = subprocess.run(command, shell=True, cwd=folder, capture_output=True, text=True, check=True)
    versions = Repository(repository)
    files = versions.tree("HEAD", "submissions/first")
    assert folder_digest(folder) == shown.stdout.split()[0]
    assert tree_digest(versions, files, "submissions/first/") == shown.stdout.split()[0]
