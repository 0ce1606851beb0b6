"""Runs of code that were trained here are read by all that reads runs of an author."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from gym_extensions import policies, results
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.curation.cli import maintain
from gym_extensions.export import cli as export
from gym_extensions.scoring.pipeline import score_folder
from gym_extensions.submissions import diagnostics, landscapes, poses
from gym_extensions.submissions.policies.files import policy_keys
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.submission import runs_folder

from ..conftest import trained_here, write_submission
from . import made_submissions as submissions
from .made_submissions import GROUP, copy, honest, network, verify

RUNS = 2
HERE = GROUPS[GROUP]


@pytest.fixture
def code(tmp_path: Path) -> Path:
    """A submission of code alone, and the runs that were trained of it."""
    submission = copy(honest(runs=RUNS), tmp_path / "mine")
    trained_here(submission)
    shutil.rmtree(submission / GROUP)
    return submission


def test_data_frames_have_their_rows(code: Path) -> None:
    for table in (results.episodes, results.evaluations, results.policies):
        own, known = table(code), table(honest(runs=RUNS))
        assert own.drop(columns="submission").equals(known.drop(columns="submission"))
        assert set(own["submission"]) == {"mine"}


def test_their_policies_are_loaded(code: Path) -> None:
    own, known = (policies.load(folder, GROUP, run=1) for folder in (code, honest(runs=RUNS)))
    assert np.array_equal(own.flat_weights(), known.flat_weights())


def test_anybody_verifies_them_and_no_result_is_stored(
    code: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(code.rglob("*"))
    assert verify(code) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"mine: verified, {RUNS} runs.\n  repeated bit for bit: ")
    assert verify(code, "--write") == 0
    assert "mine: it has no runs of its own" in capsys.readouterr().out
    assert sorted(code.rglob("*")) == before


def test_before_the_first_run_has_finished_nothing_is_verified_or_trained_again(
    code: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.rmtree(code / "trained/1")
    for option in ((), ("--retrain",)):
        assert verify(code, *option) == 0
        assert "mine: it has no runs of its own" in capsys.readouterr().out


def test_maintainers_measure_them(code: Path) -> None:
    for kind in ("poses", "landscapes", "diagnostics"):
        assert maintain([kind, str(code), "--cache", str(code.parent / "cache"), "--groups", GROUP]) == 0
    assert list(poses.load_submission(code)) == [HERE.id]
    assert list(landscapes.landscapes_of(code)) == [HERE.id]
    assert len(diagnostics.load(code, HERE)) == RUNS


def test_they_are_exported(code: Path, tmp_path: Path) -> None:
    assert export.main(["hugging-face", str(code), "--out", str(tmp_path / "hf")]) == 0
    model = tmp_path / "hf/models/mine"
    found, known = (policies.load(folder, GROUP) for folder in (model, code))
    assert np.array_equal(found.flat_weights(), known.flat_weights())


def test_they_count_where_the_author_has_trials(code: Path, tmp_path: Path) -> None:
    """With the budget ``smoke``, which is on no board."""
    trials = write_submission(tmp_path, name="trials", groups=(GROUP,), protocols=("sequential",))
    shutil.copytree(trials / GROUP, code / GROUP)
    manifest = (code / "submission.toml").read_text(encoding="utf-8").replace('"100k"', '"smoke"')
    (code / "submission.toml").write_text(manifest, encoding="utf-8")
    log = score_folder(code).groups[HERE.id]["sequential"]
    assert (log.level, log.budget) == ("trained here", "100k")
    test_data_frames_have_their_rows(code)
    test_their_policies_are_loaded(code)
    cache = str(tmp_path / "cache")
    assert maintain(["diagnostics", str(code), "--cache", cache, "--groups", GROUP]) == 0
    made = [document.policies for document in read(code / "trained/1").documents.values()]
    found = [run.policies for run in diagnostics.load(code, HERE).values()]
    assert found == [each.sha256 for each in made if each]


def test_runs_that_were_trained_here_come_first(code: Path) -> None:
    submissions.write_run_files(code, "single", 0, {key: network(1) for key in policy_keys("single", HERE)})
    assert runs_folder(code, GROUP, "sequential") == code / "trained/1"
    assert runs_folder(code, GROUP, "single") == code
    logs = score_folder(code).groups[HERE.id]
    assert {protocol: log.level for protocol, log in logs.items()} == {
        "sequential": "trained here",
        "single": "claimed",
    }
    assert set(results.episodes(code)["protocol"]) == {"sequential", "single"}
    before = results.episodes(code)
    shutil.copytree(code / "trained/1" / GROUP / "sequential", code / GROUP / "sequential")
    for path in (code / GROUP / "sequential").glob("run1.*"):
        path.unlink()
    assert runs_folder(code, GROUP, "sequential") == code / "trained/1"
    assert results.episodes(code).equals(before)
