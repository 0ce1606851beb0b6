"""The ledger counts the episodes of a committed repetition, so that an entry without traces has a rank."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.baselines import train
from gym_extensions.curation.gate.check import Request, check_pull_request
from gym_extensions.curation.git import Repository
from gym_extensions.curation.ledger.chain import read
from gym_extensions.scoring import score_folder
from gym_extensions.scoring.leaderboard.board import boards
from gym_extensions.scoring.repetition.cli import main as repeat
from gym_extensions.scoring.repetition.record import FOLDER, load, write

from .ledger.commands import cards, ledger
from .repositories import commit, git, make_repository

EPISODES = 200
"""Five runs of two tasks."""


@pytest.fixture(scope="module")
def repeated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A repository with an entry that has policies and no traces, and the record of its repetition."""
    folder = make_repository(tmp_path_factory.mktemp("repository"))
    entry = folder / "submissions" / "trpo"
    train("trpo", "pusher", "single", "smoke", range(5), out=entry, progress=False)
    for name in (".progress", "pusher/traces"):
        shutil.rmtree(entry / name)
    manifest = entry / "submission.toml"
    manifest.write_text(manifest.read_text().replace('budget = "smoke"', 'budget = "300k"'), newline="\n")
    assert repeat([str(entry), "--out", str(folder / FOLDER)]) == 0
    commit(folder)
    return folder


@pytest.fixture
def repository(repeated: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(repeated, tmp_path / "repository"))


def accept(folder: Path) -> None:
    assert ledger(folder, "record", "--reason", "Added.", "--date", "2026-01-01") == 0


def row(folder: Path) -> tuple[bool, str, str | None]:
    """Whether the entry has a rank, why not, and its level of trust."""
    (board,) = boards(list(cards(folder).values())).boards
    (entry,) = board.rows
    return entry.ranked, entry.why, entry.trust


def test_a_repeated_entry_without_traces_has_a_rank(repository: Path) -> None:
    accept(repository)
    (line,) = read(repository / "submissions")
    assert (line.level, line.replayed, line.episodes) == ("replayed", EPISODES, EPISODES)
    assert row(repository) == (True, "", "replayed (all)")
    assert ledger(repository, "verify", "--replay", "--no-history") == 0


def test_without_the_record_it_has_none(repository: Path) -> None:
    shutil.rmtree(repository / FOLDER)
    accept(repository)
    (line,) = read(repository / "submissions")
    assert (line.level, line.replayed) == ("validated", 0)
    is_ranked, why, trust = row(repository)
    assert (is_ranked, trust) == (False, "validated")
    assert "traces of the audit sample are missing" in why


def test_the_check_of_a_pull_request_reads_the_record_of_the_base(repository: Path) -> None:
    git(repository, "switch", "--quiet", "-c", "request")
    manifest = repository / "submissions" / "trpo" / "submission.toml"
    commit(repository, {"submissions/trpo/submission.toml": manifest.read_text().replace("TRPO", "Trpo")})
    report = check_pull_request(Request(Repository(repository), "main", "request"))
    assert (report.problems, report.replayed, report.episodes) == ((), EPISODES, EPISODES)


@pytest.mark.parametrize("lacks", ["a run", "the digest"])
def test_a_record_that_lacks_a_run_or_is_of_other_rows_proves_nothing(repository: Path, lacks: str) -> None:
    record = load(repository / FOLDER, "trpo")
    assert record is not None
    first, *others = record.runs
    kept = [] if lacks == "a run" else [replace(first, digest="0" * 64)]
    write(repository / FOLDER, replace(record, runs=(*kept, *others)))
    accept(repository)
    assert read(repository / "submissions")[0].level == "validated"


def test_verification_needs_the_record(repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    accept(repository)
    shutil.rmtree(repository / FOLDER)
    assert ledger(repository, "verify", "--replay", "--no-history") == 1
    expected = f"Replay verified 0 of {EPISODES} episodes; the ledger states {EPISODES} of {EPISODES}."
    assert expected in capsys.readouterr().out


def test_boards_without_a_ledger_read_the_record(repository: Path) -> None:
    entry = repository / "submissions" / "trpo"
    (score,) = score_folder(entry).groups["pusher-v0"].values()
    assert score.missing_evidence == ""
    shutil.rmtree(repository / FOLDER)
    (score,) = score_folder(entry).groups["pusher-v0"].values()
    assert score.missing_evidence.endswith("traces of the audit sample are missing.")
