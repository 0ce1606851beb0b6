"""The files of a submission: their content, adding runs, and runs that cannot be added."""

from __future__ import annotations

import csv
import errno
import shutil
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import Card, train
from gym_extensions.baselines.algorithms.random import Random
from gym_extensions.baselines.training.events import Event, StageStarted, TrainingStarted
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import evaluation_seed
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.sample import audit_sample
from gym_extensions.rollouts.layout import trace_name

from ..conftest import QUICK_GROUP, SHORT_GROUP, digests

GROUP = group(SHORT_GROUP)


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_sequential_log_has_every_cell_with_the_prescribed_seeds(trpo_submission: Path) -> None:
    logged = rows(trpo_submission / SHORT_GROUP / "sequential.csv")
    expected = [
        (str(stage), task, str(episode), str(evaluation_seed(GROUP.id, task, episode)), published(task))
        for stage in range(3)
        for task in GROUP.task_ids
        for episode in range(20)
    ]
    columns = ("stage", "task", "episode", "seed", "fingerprint")
    assert [tuple(row[name] for name in columns) for row in logged] == expected


def test_every_stage_is_trained_and_joint_training_takes_all_tasks(trpo_submission: Path) -> None:
    points = rows(trpo_submission / SHORT_GROUP / "curves.csv")
    sequential = {(row["task"], int(row["step"])) for row in points if row["protocol"] == "sequential"}
    assert {task for task, _ in sequential} == set(GROUP.task_ids)
    assert max(step for _, step in sequential) <= 1000 * 1.02
    joint = {(row["task"], int(row["step"])) for row in points if row["protocol"] == "joint"}
    assert {task for task, _ in joint} == set(GROUP.task_ids)
    assert 1000 < max(step for _, step in joint) <= 2000 * 1.02


def test_the_log_selects_the_audit_sample_and_its_traces_have_the_logged_returns(
    trpo_submission: Path,
) -> None:
    folder = trpo_submission / SHORT_GROUP
    log = folder / "sequential.csv"
    sample = audit_sample("sequential", log.read_bytes(), [0], GROUP.tasks)
    names = {task.id: task.name for task in GROUP.tasks}
    expected = {trace_name("sequential", 0, row.stage, names[row.task], row.episode): row for row in sample}
    assert {path.name for path in (folder / "traces").glob("sequential-*")} == expected.keys()
    logged = {(row["stage"], row["task"], row["episode"]): row for row in rows(log)}
    for name, row in expected.items():
        with np.load(folder / "traces" / name, allow_pickle=False) as trace:
            line = logged[str(row.stage), row.task, str(row.episode)]
            assert len(trace["actions"]) == int(line["length"])
            assert sum(trace["segment_returns"]) == pytest.approx(float(line["return"]), abs=1e-9)


def test_the_manifest_describes_the_run(trpo_submission: Path) -> None:
    manifest = tomllib.loads((trpo_submission / "submission.toml").read_text())
    assert manifest["protocol"] == {
        "budget": "smoke",
        "algorithm": "trpo",
        "evaluation": "deterministic",
        "steps": "recorded",
    }
    assert manifest["hyperparameters"]["hidden"] == [64, 64]
    # Policy 23-64-64-7 and seven log σ; value function 23-64-64-1.
    policy, value = 24 * 64 + 65 * 64 + 65 * 7 + 7, 24 * 64 + 65 * 64 + 65
    assert manifest["memory"] == {
        "stored_steps": 250,
        "parameters_first": policy + value,
        "parameters_last": policy + value,
    }
    assert manifest["versions"]["mujoco"] == "4.0.0"


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
        f"{trace.name}, which is missing. Restore it or the traces of all episodes in .progress, or train "
        "all runs in another --out."
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
        BenchError, match=r"hyperparameters\.num_envs is None in this submission and 3 in the new run"
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


@pytest.fixture(scope="module")
def first_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """random, joint, run 0."""
    folder = tmp_path_factory.mktemp("first-run") / "random"
    train("random", QUICK_GROUP, "joint", "smoke", 0, out=folder)
    return folder


@pytest.fixture(scope="module")
def three_runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """random, joint, runs 0, 1 and 2 at once."""
    folder = tmp_path_factory.mktemp("three-runs") / "random"
    train("random", QUICK_GROUP, "joint", "smoke", [0, 1, 2], out=folder)
    return folder


@pytest.mark.parametrize("name", ["joint.csv", ".npz", "submission.toml"])
def test_a_full_disk_leaves_the_submission_as_it_was_and_the_run_can_be_written_later(
    name: str, first_run: Path, three_runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = Path(shutil.copytree(first_run, tmp_path / "mine"))
    before, write = digests(out), Path.write_bytes

    def fill_disk(path: Path, content: bytes) -> int:
        if path.name.endswith(f"{name}.partial") and "staged" in path.parts:
            write(path, content[:10])
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(path, content)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", fill_disk)
        with pytest.raises(BenchError) as error:
            train("random", QUICK_GROUP, "joint", "smoke", [1, 2], out=out)
    cause = "The disk is full: No space left on device. Free some disk space."
    assert [line.strip() for line in error.value.message.splitlines()] == [
        "2 of 2 jobs failed.",
        *(f"{QUICK_GROUP.name} joint-run{run}: {cause}" for run in (1, 2)),
    ]
    assert error.value.hint.endswith("The same command continues; it reuses 2 finished stages.")
    assert digests(out) == before
    assert not list(out.rglob("*.partial"))
    train("random", QUICK_GROUP, "joint", "smoke", [1, 2], out=out, callback=refuse_training)
    assert digests(out) == digests(three_runs)


def test_a_manifest_that_breaks_during_training_fails_the_runs_that_it_meets_and_loses_none(
    first_run: Path, three_runs: Path, tmp_path: Path
) -> None:
    out = Path(shutil.copytree(first_run, tmp_path / "mine"))
    manifest = (out / "submission.toml").read_bytes()

    def edit(event: Event) -> None:
        if isinstance(event, StageStarted):
            (out / "submission.toml").write_text("title = ")

    with pytest.raises(BenchError) as error:
        train("random", QUICK_GROUP, "joint", "smoke", [1, 2], out=out, callback=edit)
    assert error.value.code == "jobs-failed"
    assert error.value.message.startswith("2 of 2 jobs failed.")
    assert error.value.hint.endswith("The same command continues; it reuses 2 finished stages.")
    (out / "submission.toml").write_bytes(manifest)
    train("random", QUICK_GROUP, "joint", "smoke", [1, 2], out=out, callback=refuse_training)
    assert digests(out) == digests(three_runs)


def refuse_training(event: Event) -> None:
    assert not isinstance(event, StageStarted), "a finished stage was repeated"
