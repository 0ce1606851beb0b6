"""The ledger command on a small repository: recording entries, git's history, and boards built from it."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gym_extensions.curation.digest import folder_digest, folder_hashes, tree_digest
from gym_extensions.curation.git import Repository
from gym_extensions.curation.ledger.apply import with_ledgers
from gym_extensions.curation.ledger.chain import FILE, read
from gym_extensions.curation.ledger.cli import main
from gym_extensions.curation.ledger.verify import check_folders
from gym_extensions.curation.salt import derive_salt
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.submission_digest import digest_without_traces
from gym_extensions.scoring.leaderboard.board import boards
from gym_extensions.scoring.pipeline.score import find_submissions, score_folders
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.cli import main as site

from ..repositories import commit, git, make_repository, write_entry

VALUE = "d" * 40
SCORED = "halfcheetah-gravity"
"""A group with references, so that its boards have scores."""


def ledger(folder: Path, *arguments: str) -> int:
    return main(["--submissions", str(folder / "submissions"), *arguments])


def record(folder: Path, date: str, reason: str = "A reason.", *options: str) -> None:
    assert ledger(folder, "record", "--reason", reason, "--date", date, *options) == 0


def cards(folder: Path) -> dict[str, Scorecard]:
    paths = [folder / "submissions"]
    scored = with_ledgers(score_folders(paths).submissions, find_submissions(paths))
    return {card.name: card for card in scored}


def board(folder: Path) -> str:
    return boards(list(cards(folder).values())).to_json()


@pytest.fixture(scope="module")
def history(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    """A repository whose ledger grew in three steps, and the board after each of them."""
    folder = make_repository(tmp_path_factory.mktemp("history"))
    shown = []
    write_entry(folder / "submissions", "first", group=SCORED)
    write_entry(folder / "submissions", "second", bonus=5.0, group=SCORED)
    record(folder, "2026-01-01")
    commit(folder)
    shown.append(board(folder))
    write_entry(folder / "submissions", "first", bonus=20.0, group=SCORED)
    record(folder, "2026-01-02", "Recorded again.", "--value", VALUE)
    commit(folder)
    shown.append(board(folder))
    shutil.rmtree(folder / "submissions" / "second")
    record(folder, "2026-01-03", "Asked for by its author.")
    commit(folder)
    shown.append(board(folder))
    return folder, shown


@pytest.fixture
def repository(history: tuple[Path, list[str]], tmp_path: Path) -> Path:
    """A copy of that repository, to change."""
    return Path(shutil.copytree(history[0], tmp_path / "repository"))


def problem(capsys: pytest.CaptureFixture[str], folder: Path, *arguments: str) -> str:
    """The error of a command that exits with status 2."""
    capsys.readouterr()
    assert ledger(folder, *arguments) == 2
    return capsys.readouterr().err


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


@pytest.mark.parametrize(("lines", "step"), [(2, 0), (4, 1), (5, 2)])
def test_an_old_board_is_rebuilt_byte_for_byte(
    history: tuple[Path, list[str]], tmp_path: Path, lines: int, step: int
) -> None:
    folder, shown = history
    assert ledger(folder, "board", "--lines", str(lines), "--out", str(tmp_path / "boards.json")) == 0
    assert (tmp_path / "boards.json").read_text() == shown[step]
    assert len(set(shown)) == 3


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


def test_a_salt_that_does_not_follow_from_its_value_is_named(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = repository / "submissions" / FILE
    path.unlink()
    record(repository, "2026-01-01", "A reason.", "--value", VALUE)
    path.write_bytes(path.read_bytes().replace(VALUE.encode(), b"0" * 40))
    assert ledger(repository, "verify", "--no-history") == 1
    assert "first: ledger-salt: The salt of its line does not follow" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("event", "on_board"),
    [("challenged", True), ("rescored", True), ("withdrawn", False), ("superseded", False)],
)
def test_an_event_is_shown_on_the_scorecard_and_decides_whether_the_entry_is_on_the_board(
    repository: Path, event: str, on_board: bool
) -> None:
    assert ledger(repository, "add", event, "first", "--reason", "Why.", "--date", "2026-02-01") == 0
    card = cards(repository)["first"]
    assert card.ledger is not None
    assert (card.ledger.event, card.ledger.reason) == (event, "Why.")
    assert (card.ledger.accepted, card.ledger.date) == ("2026-01-02", "2026-02-01")
    assert bool(boards([card]).boards) == on_board


def test_the_recorded_level_is_shown_without_replay_only_for_the_recorded_files(repository: Path) -> None:
    path = repository / "submissions" / FILE
    path.unlink()
    record(repository, "2026-01-01")
    path.write_bytes(
        path.read_bytes().replace(b'"validated"', b'"replayed"').replace(b'"replayed":0', b'"replayed":3')
    )
    assert cards(repository)["first"].trust == "replayed (unsalted sample: 3 of 200 episodes)"
    readme = repository / "submissions" / "first" / "README.md"
    readme.write_text("Another file.\n")
    assert cards(repository)["first"].trust == "validated"


def test_the_site_command_names_entries_that_are_not_accepted_yet(
    repository: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_entry(repository / "submissions", "third")
    assert site(["--out", str(tmp_path / "site"), str(repository / "submissions")]) == 0
    assert "Not accepted yet, so without a rank (docs/ledger.md): third\n" in capsys.readouterr().out


def test_the_committed_ledger_agrees_with_the_committed_submissions() -> None:
    folder = Path(__file__).parents[3] / "submissions"
    assert (len(read(folder)) > 0, check_folders(folder)) == (True, ())


def test_challenges_are_shown_as_they_are(repository: Path) -> None:
    text = "Returns of run 3 <b>look</b> invented.\nSee row 17.\n"
    commit(repository, {"challenges/first/run-3.txt": text, "challenges/other/x.txt": "Another.\n"})
    (challenge,) = cards(repository)["first"].challenges
    assert (challenge.file, challenge.text) == ("challenges/first/run-3.txt", text)


@pytest.mark.parametrize(
    ("name", "content", "code"),
    [
        ("challenges/first/a.md", b"Text.\n", "challenge-name"),
        ("challenges/a.txt", b"Text.\n", "challenge-name"),
        ("challenges/first/a.txt", b"\xff\n", "challenge-text"),
        ("challenges/first/a.txt", b"a\x1b[2Jb\n", "challenge-text"),
        ("challenges/first/a.txt", b"\n", "challenge-text"),
        ("challenges/first/a.txt", b"x" * 65537, "challenge-size"),
    ],
)
def test_a_challenge_that_is_not_plain_text_is_a_named_problem(
    repository: Path, name: str, content: bytes, code: str
) -> None:
    path = repository / name
    path.parent.mkdir(parents=True)
    path.write_bytes(content)
    with pytest.raises(BenchError) as error:
        cards(repository)
    assert (error.value.code, error.value.where) == (code, name)


def test_a_submission_with_problems_is_not_accepted(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (repository / "submissions" / FILE).read_bytes()
    write_entry(repository / "submissions", "broken")
    (repository / "submissions" / "broken" / "notes.txt").write_text("x")
    message = problem(capsys, repository, "add", "accepted", "broken", "--reason", "Why.")
    assert "broken/notes.txt: It has 1 problems, first unexpected-name:" in message
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


@pytest.mark.skipif(sys.platform != "linux", reason="the command is that of GNU coreutils")
def test_the_digest_is_what_coreutils_and_git_give(history: tuple[Path, list[str]]) -> None:
    folder = history[0] / "submissions" / "first"
    (folder / ".progress").mkdir(exist_ok=True)
    (folder / ".progress" / "train.log").write_text("not part of the submission")
    command = "find * -type f | LC_ALL=C sort | xargs sha256sum | sha256sum"
    shown = subprocess.run(command, shell=True, cwd=folder, capture_output=True, text=True, check=True)
    repository = Repository(history[0])
    files = repository.tree("HEAD", "submissions/first")
    assert folder_digest(folder) == shown.stdout.split()[0]
    assert tree_digest(repository, files, "submissions/first/") == shown.stdout.split()[0]
