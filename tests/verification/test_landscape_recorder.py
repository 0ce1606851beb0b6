"""Landscapes are measured from the stored policies alone, and agree with the logs at trained values."""

import shutil
from itertools import product
from pathlib import Path
from statistics import fmean
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.worlds import axes
from gym_extensions.curation.cli import maintain
from gym_extensions.submissions import landscapes as stored
from gym_extensions.submissions.layout import DOCUMENT, LANDSCAPES, run_file
from gym_extensions.submissions.policies.files import policies_of, read_arrays
from gym_extensions.submissions.submission import runs_folder
from gym_extensions.verification.recorders import returns_of

from .made_submissions import GROUP, change_document, copy, honest, network

HERE = GROUPS[GROUP]
SUBMISSIONS = Path(__file__).parents[2] / "submissions"
MEASURED = sorted(SUBMISSIONS.glob(f"*/{LANDSCAPES}/*.json"))


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A submission of two runs with a landscape. It must not be changed."""
    submission = copy(honest(), tmp_path_factory.mktemp("measured") / "mine")
    for path in submission.glob("*/*/run[2-4].*"):
        path.unlink()
    assert landscapes(submission) == 0
    return submission


@pytest.fixture
def submission(measured: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(measured, tmp_path / "mine"))


def landscapes(submission: Path, *options: str) -> int:
    return maintain(["landscapes", str(submission), "--cache", str(submission.parent / "cache"), *options])


def landscape(submission: Path) -> stored.Landscape:
    (found,) = stored.landscapes_of(submission).values()
    return found


def test_every_run_has_a_return_and_a_deviation_per_stage_and_value(measured: Path) -> None:
    found = landscape(measured)
    assert (found.group, found.runs, found.episodes) == (HERE.id, (0, 1), 10)
    (axis,) = found.axes
    assert np.shape(axis.returns) == np.shape(axis.deviations) == (2, 3, len(axes(HERE)[0].points))
    assert len({axis.returns[0], axis.returns[1]}) == 2
    assert stored.path_of(measured, HERE).stat().st_size < 60_000


def test_the_same_machine_writes_the_same_file_whatever_the_number_of_jobs(submission: Path) -> None:
    before = stored.path_of(submission, HERE).read_bytes()
    assert landscapes(submission, "--again", "--jobs", "2", "--groups", GROUP) == 0
    assert stored.path_of(submission, HERE).read_bytes() == before


def test_a_landscape_that_is_up_to_date_is_not_measured_again(
    submission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert landscapes(submission) == 0
    assert capsys.readouterr().out == f"mine, {GROUP}: up to date.\n"


def test_a_landscape_of_other_policies_is_not_shown(submission: Path) -> None:
    document = submission / run_file(GROUP, "sequential", 1, DOCUMENT)
    change_document(document, policies=None)
    assert stored.load(submission, HERE) == stored.OTHER_RUNS
    assert stored.landscapes_of(submission) == {}


def test_a_submission_without_policies_has_none(submission: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.rmtree(submission / LANDSCAPES)
    assert stored.load(submission, HERE) == stored.NOT_MEASURED
    change_document(submission / run_file(GROUP, "sequential", 0, DOCUMENT), policies=None)
    assert landscapes(submission) == 0
    assert "not published" in capsys.readouterr().out
    assert not (submission / LANDSCAPES).exists()


@pytest.mark.parametrize(
    ("name", "message"),
    [("nav-state", "nav-state varies no quantity."), ("hoper", "There is no group 'hoper'")],
)
def test_a_group_without_worlds_is_refused(
    measured: Path, name: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert landscapes(measured, "--groups", name) == 2
    assert message in capsys.readouterr().err


def test_an_agent_that_observes_the_task_is_told_the_nearest_one() -> None:
    gravity, told = GROUPS["hopper-gravity"], list[int]()

    def act(observations: Any, rng: np.random.Generator, task: int) -> Any:
        told.append(task)
        return network(0, inputs=11).act(observations)

    policy: Any = SimpleNamespace(num_actions=3, reset=lambda: None, act=act)
    returns_of(gravity, policy, axes(gravity)[0], 5, 0)
    assert list(dict.fromkeys(told)) == [0, 1, 2, 3, 4]


@pytest.mark.committed
@pytest.mark.parametrize("path", MEASURED, ids=lambda path: f"{path.parts[-3]}-{path.stem}")
def test_at_trained_values_a_committed_landscape_agrees_with_the_logs(path: Path) -> None:
    submission, group = path.parents[1], GROUPS[path.stem]
    found = stored.load(submission, group)
    assert isinstance(found, stored.Landscape), found
    runs = runs_folder(submission, group.name, "sequential")
    numbers = sum(2 * np.size(axis.returns) for axis in found.axes)
    assert path.stat().st_size < 20 * numbers
    differences = []
    for index, run in enumerate(found.runs):
        file = runs / run_file(group.name, "sequential", run, ".csv")
        log = pd.read_csv(file, usecols=["stage", "task", "return"])
        cells = log.groupby(["stage", "task"])["return"].agg(["mean", "sem"])
        for axis, stage in product(axes(group), range(len(group.tasks) + 1)):
            measured = found.axis(axis.name)
            for each in axis.trained:  # a wall stands anywhere in a range of several points
                at = [each.low <= point <= each.high for point in axis.points]
                logged, error = cells.loc[[(stage, group.task_ids[each.task])]].to_numpy()[0]
                means = np.array(measured.returns[index][stage])[at]
                deviation = np.array(measured.deviations[index][stage])[at].max()
                error = np.hypot(error, deviation / 9**0.5) + 1.0
                differences.append((np.clip(logged, means.min(), means.max()) - logged) / error)
    assert abs(fmean(differences)) < 0.5
    assert np.std(differences) < 1.6
    assert np.std(differences) > 0.3 or "wall" in path.stem
    assert np.mean(np.abs(differences) > 3) < 0.04


@pytest.mark.committed
def test_a_stage_of_a_committed_landscape_is_measured_again() -> None:
    """Golden numbers: equal, or close at most points if the file is of the first arithmetic."""
    submission, group, stage = SUBMISSIONS / "sac", GROUPS["hopper-gravity"], 1
    found, (axis,) = stored.landscapes_of(submission)[group.id], axes(group)
    arrays = read_arrays(submission, group, "sequential", 0)
    policy = policies_of(arrays, group, "sequential")[stage, None]
    returns = np.array(returns_of(group, policy, axis, stage, 0))
    golden = np.array(found.axes[0].returns[0][stage])
    if "arithmetic" in found.versions:
        assert returns.mean(axis=1).round(1).tolist() == golden.tolist()
    error = np.array(found.axes[0].deviations[0][stage]) / 3
    close = np.abs(returns.mean(axis=1) - golden) <= 4 * 2**0.5 * error + 0.1
    assert close.mean() > 0.8, "one fall more among ten episodes is far off where the others are alike"
