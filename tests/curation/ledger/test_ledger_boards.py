"""What boards, scorecards and pages show of the ledger and of challenges."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from gym_extensions.curation.ledger.chain import FILE
from gym_extensions.errors import BenchError
from gym_extensions.scoring.leaderboard.board import boards
from gym_extensions.site.cli import main as site

from ..repositories import commit, write_entry
from .commands import cards, ledger, record


@pytest.mark.parametrize(("lines", "step"), [(2, 0), (4, 1), (5, 2)])
def test_an_old_board_is_rebuilt_byte_for_byte(
    history: tuple[Path, list[str]], tmp_path: Path, lines: int, step: int
) -> None:
    folder, shown = history
    assert ledger(folder, "board", "--lines", str(lines), "--out", str(tmp_path / "boards.json")) == 0
    assert (tmp_path / "boards.json").read_text() == shown[step]
    assert len(set(shown)) == 3


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


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such names")
def test_a_folder_with_an_unprintable_name_is_refused_alone(repository: Path) -> None:
    (repository / "submissions" / "first").rename(repository / "submissions" / "first\x07")
    assert [bool(card.problems) for card in cards(repository).values()].count(True) == 1
