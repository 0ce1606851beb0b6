"""Runs that are added to a submission: its files are those of training all at once, or they are refused."""

from __future__ import annotations

import shutil
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines import Card, train
from gym_extensions.baselines.algorithms.random import Random
from gym_extensions.baselines.training.events import Event, TrainingStarted
from gym_extensions.errors import BenchError

from ..conftest import QUICK_GROUP, digests


@pytest.fixture(scope="module")
def first_single_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """random, single, run 0."""
    folder = tmp_path_factory.mktemp("first-single-run") / "random"
    train("random", QUICK_GROUP, "single", "smoke", 0, out=folder)
    return folder


def test_worker_processes_write_the_same_files(first_single_run: Path, tmp_path: Path) -> None:
    train("random", QUICK_GROUP, "single", "smoke", [0], out=tmp_path / "again", jobs=2)
    assert digests(tmp_path / "again") == digests(first_single_run)


def test_adding_a_run_later_writes_the_files_of_training_both_at_once(
    first_single_run: Path, tmp_path: Path
) -> None:
    shutil.copytree(first_single_run, tmp_path / "added")
    train("random", QUICK_GROUP, "single", "smoke", [1], out=tmp_path / "added")
    train("random", QUICK_GROUP, "single", "smoke", [0, 1], out=tmp_path / "together")
    assert digests(tmp_path / "added") == digests(tmp_path / "together")


def test_a_finished_run_is_not_repeated(first_single_run: Path, tmp_path: Path) -> None:
    shutil.copytree(first_single_run, tmp_path / "same")
    events: list[Event] = []
    train("random", QUICK_GROUP, "single", "smoke", 0, out=tmp_path / "same", callback=events.append)
    assert events == [TrainingStarted(())]
    assert not (tmp_path / "same/.progress/train.log").read_text().count("0 jobs")


def test_values_that_the_author_edited_stay(first_single_run: Path, tmp_path: Path) -> None:
    out = tmp_path / "mine"
    shutil.copytree(first_single_run, out)
    path = out / "submission.toml"
    text = path.read_text().replace('title = "Random actions"', 'title = "Dice"')
    text = text.replace("authors = []", 'authors = ["A. Person"]').replace(
        'url = ""', 'url = "https://example.org"'
    )
    path.write_text(text)
    train("random", QUICK_GROUP, "single", "smoke", 1, out=out)
    manifest = tomllib.loads(path.read_text())
    assert (manifest["title"], manifest["authors"]) == ("Dice", ["A. Person"])
    assert manifest["code"]["url"] == "https://example.org"


def test_a_run_is_added_to_the_files_of_a_submission_alone(first_single_run: Path, tmp_path: Path) -> None:
    ignore = shutil.ignore_patterns(".progress")
    for name, add in (("cloned", ignore), ("original", None)):
        shutil.copytree(first_single_run, tmp_path / name, ignore=add)
        train("random", QUICK_GROUP, "single", "smoke", 1, out=tmp_path / name)
    assert digests(tmp_path / "cloned") == digests(tmp_path / "original")


def test_a_run_cannot_be_added_if_traces_are_missing(first_single_run: Path, tmp_path: Path) -> None:
    out = tmp_path / "cloned"
    shutil.copytree(first_single_run, out, ignore=shutil.ignore_patterns(".progress"))
    trace = sorted((out / QUICK_GROUP.name / "traces").iterdir())[0]
    trace.unlink()
    with pytest.raises(BenchError) as error:
        train("random", QUICK_GROUP, "single", "smoke", 1, out=out)
    assert str(error.value) == (
        f"{trace.parent}: The audit sample of run 0 in {QUICK_GROUP.name}/single.csv needs the trace "
        f"{trace.name}, which is missing. Run gym-extensions trace, restore the traces of all episodes in "
        ".progress, or train all runs in another --out."
    )


MIXED = [
    (("zero", "smoke"), "protocol.algorithm is 'random' in this submission and 'zero' in the new run."),
    (("random", "100k"), "protocol.budget is 'smoke' in this submission and '100k' in the new run."),
]


@pytest.mark.parametrize(("run", "message"), MIXED)
def test_a_submission_has_one_algorithm_and_one_budget(
    first_single_run: Path, run: tuple[str, str], message: str
) -> None:
    agent, budget = run
    with pytest.raises(BenchError) as error:
        train(agent, QUICK_GROUP, "single", budget, 0, out=first_single_run)
    assert str(error.value) == (
        f"{first_single_run / 'submission.toml'}: {message} "
        "A submission has one algorithm, one budget and one set of hyperparameters; choose another --out."
    )


def test_the_number_of_training_environments_is_a_hyperparameter(first_single_run: Path) -> None:
    with pytest.raises(
        BenchError, match=r"hyperparameters\.num_envs is not stated in this submission and 3 in the new run"
    ):
        train("random", QUICK_GROUP, "single", "smoke", 1, out=first_single_run, num_envs=3)


MIXED_TUPLE: dict[str, Any] = {"train_freq": (8, "step")}


class Tupled(Random):
    """An agent whose card has a tuple, which TOML writes as a list."""

    def card(self) -> Card:
        return replace(super().card(), hyperparameters=MIXED_TUPLE)


def test_a_tuple_equals_itself_when_a_run_is_added(tmp_path: Path) -> None:
    for run in (0, 1):
        train(Tupled, QUICK_GROUP, "single", "smoke", run, out=tmp_path / "tupled", jobs=0)
    manifest = tomllib.loads((tmp_path / "tupled" / "submission.toml").read_text())
    assert manifest["hyperparameters"]["train_freq"] == [8, "step"]
