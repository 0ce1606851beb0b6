"""The files of a submission after training: the log, the curves, the traces and the manifest."""

from __future__ import annotations

import csv
import tomllib
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import evaluation_seed
from gym_extensions.rollouts.auditing.sample import audit_sample
from gym_extensions.rollouts.layout import trace_name

from ..conftest import SHORT_GROUP

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
