"""The record of a re-evaluation: the command that writes it, and the scorecard that shows it."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.__main__ import main
from gym_extensions.baselines import train
from gym_extensions.curation.digest import folder_hashes
from gym_extensions.curation.reevaluation import require_reevaluation
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.submission_digest import digest_without_traces, submission_digest
from gym_extensions.scoring import score_folder
from gym_extensions.scoring.reevaluation.record import FOLDER, load, path_of, with_record, write
from gym_extensions.site.cli import main as site

GROUP = "hopper-motor-noise"
SALT = "5a" * 32


@pytest.fixture(scope="module")
def repository(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the submission `honest` and the record of its re-evaluation."""
    folder = tmp_path_factory.mktemp("repository")
    entry = folder / "submissions" / "honest"
    train("random", GROUP, "single", "smoke", [0], out=entry, progress=False)
    out = str(folder / FOLDER)
    assert main(["reevaluate", str(entry), "--salt", SALT, "--out", out]) == 0
    return folder


@pytest.fixture
def copy(repository: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(repository, tmp_path / "copy", ignore=shutil.ignore_patterns(".progress")))


def entry(folder: Path) -> Path:
    return folder / "submissions" / "honest"


def test_the_scorecard_shows_the_returns_on_new_seeds_beside_those_of_the_log(repository: Path) -> None:
    record = load(repository / FOLDER, "honest")
    assert record is not None and record.is_complete
    card = with_record(score_folder(entry(repository)), record)
    (returns,) = [score.reevaluation for score in card.groups[f"{GROUP}-v0"].values()]
    assert returns is not None and returns == record.groups[f"{GROUP}-v0"]["single"]
    assert [(cell.run, cell.stage) for cell in returns.cells] == [(0, 1), (0, 1)]
    assert card.new_seeds is not None
    assert (card.new_seeds.salt, card.new_seeds.digest) == (SALT, submission_digest(entry(repository)))


def test_the_page_of_the_entry_shows_the_new_mean(repository: Path, tmp_path: Path) -> None:
    options = ["--out", str(tmp_path / "site"), "--reevaluations", str(repository / FOLDER)]
    assert site([str(repository / "submissions"), *options]) == 0
    page = (tmp_path / "site" / "submissions" / "honest.html").read_text(encoding="utf-8")
    record = load(repository / FOLDER, "honest")
    assert record is not None
    mean = record.groups[f"{GROUP}-v0"]["single"].fresh
    assert f"On new seeds, the submitted policies return {mean:.1f} on average" in page


def test_a_record_of_another_log_is_not_shown(repository: Path) -> None:
    record = load(repository / FOLDER, "honest")
    assert record is not None
    card = score_folder(entry(repository))
    returns = record.groups[f"{GROUP}-v0"]["single"]
    first = replace(returns.cells[0], logged=returns.cells[0].logged + 1)
    other = replace(returns, cells=(first, *returns.cells[1:]))
    changed = replace(record, groups={f"{GROUP}-v0": {"single": other}})
    assert with_record(card, changed) == card
    assert with_record(card, replace(record, groups={"nav-state-v0": {"single": returns}})) == card
    assert with_record(card, None) == card


def test_a_file_that_is_not_a_record_is_named(copy: Path) -> None:
    path_of(copy / FOLDER, "honest").write_text('{"format": 2}')
    with pytest.raises(BenchError, match="It cannot be read") as error:
        load(copy / FOLDER, "honest")
    assert error.value.where == str(path_of(copy / FOLDER, "honest"))


def test_the_level_needs_a_complete_record_of_these_files_and_this_salt(copy: Path) -> None:
    digest = digest_without_traces(folder_hashes(entry(copy)))
    require_reevaluation(entry(copy), digest, SALT)
    for other in ((digest, "b7" * 32), ("0" * 64, SALT)):
        with pytest.raises(BenchError, match="of other files or of another salt"):
            require_reevaluation(entry(copy), *other)
    record = load(copy / FOLDER, "honest")
    assert record is not None
    path = write(copy / FOLDER, replace(record, is_complete=False))
    with pytest.raises(BenchError, match="Not all logs"):
        require_reevaluation(entry(copy), digest, SALT)
    path.unlink()
    with pytest.raises(BenchError, match="does not exist") as error:
        require_reevaluation(entry(copy), digest, SALT)
    assert error.value.code == "unproven-level"


def test_a_submission_without_policies_or_with_problems_has_no_record(
    copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.rmtree(entry(copy) / GROUP / "policies")
    out = copy / "records"
    command = ["reevaluate", str(entry(copy)), "--salt", SALT, "--out", str(out)]
    assert main(command) == 2
    assert "The submission has no policies." in capsys.readouterr().err
    (entry(copy) / "notes.txt").write_text("x")
    assert main(command) == 1
    assert "unexpected-name" in capsys.readouterr().err
    assert not out.exists()
