"""From an agent to a submission: its rows, its bytes, what is added and what is refused."""

from __future__ import annotations

import csv
import shutil
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.baselines.algorithms.random import Random
from gym_extensions.baselines.train import train
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import evaluation_seed
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.audit import audit_sample, audited_cells
from gym_extensions.rollouts.layout import trace_name

from ..conftest import digests

GROUP = group("hopper-gravity")


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_sequential_log_has_every_cell_with_the_prescribed_seeds(trpo_submission):
    found = rows(trpo_submission / "hopper-gravity/sequential.csv")
    expected = [
        (str(stage), task, str(episode), str(evaluation_seed(GROUP.id, task, episode)), published(task))
        for stage in range(6)
        for task in GROUP.task_ids
        for episode in range(20)
    ]
    columns = ("stage", "task", "episode", "seed", "fingerprint")
    assert [tuple(row[name] for name in columns) for row in found] == expected


def test_every_stage_is_trained_and_joint_training_takes_all_tasks(trpo_submission):
    found = rows(trpo_submission / "hopper-gravity/curves.csv")
    sequential = {(row["task"], int(row["step"])) for row in found if row["protocol"] == "sequential"}
    assert {task for task, _ in sequential} == set(GROUP.task_ids)
    assert max(step for _, step in sequential) <= 1000 * 1.02
    joint = {(row["task"], int(row["step"])) for row in found if row["protocol"] == "joint"}
    assert {task for task, _ in joint} == set(GROUP.task_ids)
    assert 4000 < max(step for _, step in joint) <= 5000 * 1.02


def test_the_audit_sample_is_what_the_log_chooses_and_holds_the_logged_returns(trpo_submission):
    folder = trpo_submission / "hopper-gravity"
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


def test_the_sample_has_an_episode_for_each_column_of_the_table():
    # T = 5: five of R[5][j] and five of R[j][j]; R[5][5] stands in both columns and gives two.
    cells = audited_cells("sequential", GROUP.tasks)
    assert len(cells) == 10
    assert cells.count((5, GROUP.tasks[4])) == 2
    sample = audit_sample("sequential", b"log", [0, 3], GROUP.tasks)
    assert len(set(sample)) == len(sample) == 20
    assert audit_sample("sequential", b"another", [0, 3], GROUP.tasks) != sample
    assert len(audit_sample("single", b"log", [0], GROUP.tasks)) == 5


def test_the_manifest_says_what_was_run(trpo_submission):
    found = tomllib.loads((trpo_submission / "submission.toml").read_text())
    assert found["protocol"] == {"budget": "smoke", "algorithm": "trpo", "evaluation": "deterministic"}
    assert found["hyperparameters"]["hidden"] == [64, 64]
    # Policy 11-64-64-3 and three log σ; value function 11-64-64-1.
    policy, value = 12 * 64 + 65 * 64 + 65 * 3 + 3, 12 * 64 + 65 * 64 + 65
    assert found["memory"] == {
        "stored_steps": 250,
        "parameters_first": policy + value,
        "parameters_last": policy + value,
    }
    assert found["versions"]["mujoco"] == "4.0.0"


def test_made_again_in_other_processes_the_files_are_the_same(random_submission, tmp_path):
    train("random", "hopper-gravity", "single", "smoke", [0], out=tmp_path / "again", jobs=2)
    assert digests(tmp_path / "again") == digests(random_submission)


def test_runs_added_later_give_the_files_of_one_go(random_submission, tmp_path):
    shutil.copytree(random_submission, tmp_path / "grown")
    train("random", "hopper-gravity", "single", "smoke", [1], out=tmp_path / "grown")
    train("random", "hopper-gravity", "single", "smoke", [0, 1], out=tmp_path / "once")
    assert digests(tmp_path / "grown") == digests(tmp_path / "once")


def test_a_finished_run_is_not_run_again(random_submission, tmp_path):
    shutil.copytree(random_submission, tmp_path / "same")
    announced = []
    train("random", "hopper-gravity", "single", "smoke", 0, out=tmp_path / "same", announce=announced.append)
    assert announced == [{}]


def test_what_the_author_wrote_stays(random_submission, tmp_path):
    out = tmp_path / "mine"
    shutil.copytree(random_submission, out)
    path = out / "submission.toml"
    text = path.read_text().replace('title = "Random actions"', 'title = "Dice"')
    text = text.replace("authors = []", 'authors = ["A. Person"]').replace(
        'url = ""', 'url = "https://example.org"'
    )
    path.write_text(text)
    train("random", "hopper-gravity", "single", "smoke", 1, out=out)
    found = tomllib.loads(path.read_text())
    assert (found["title"], found["authors"]) == ("Dice", ["A. Person"])
    assert found["code"]["url"] == "https://example.org"


def test_runs_without_their_traces_take_no_further_run(random_submission, tmp_path):
    out = tmp_path / "cloned"
    shutil.copytree(random_submission, out, ignore=shutil.ignore_patterns(".progress"))
    with pytest.raises(BenchError) as told:
        train("random", "hopper-gravity", "single", "smoke", 1, out=out)
    assert str(told.value) == (
        f"{out / '.progress/hopper-gravity/traces'}: No run can be added to hopper-gravity/single.csv: run 0 "
        "lacks traces. Put the complete set back there, or train all runs in another --out."
    )


MIXED = [
    (("still", "smoke"), "protocol.algorithm is 'random' in this submission and 'still' in the run."),
    (("random", "100k"), "protocol.budget is 'smoke' in this submission and '100k' in the run."),
]


@pytest.mark.parametrize(("asked", "message"), MIXED)
def test_a_submission_is_one_algorithm_at_one_budget(random_submission, asked, message):
    agent, budget = asked
    with pytest.raises(BenchError) as told:
        train(agent, "hopper-gravity", "single", budget, 0, out=random_submission)
    assert str(told.value) == (
        f"{random_submission / 'submission.toml'}: {message} "
        "A submission is one algorithm at one budget with one set of settings; choose another --out."
    )


def test_other_lanes_are_another_setting(random_submission):
    with pytest.raises(
        BenchError, match=r"hyperparameters\.lanes is None in this submission and 3 in the run"
    ):
        train("random", "hopper-gravity", "single", "smoke", 1, out=random_submission, lanes=3)


class Tupled(Random):
    """An agent whose card has a tuple, which TOML writes as a list."""

    def card(self):
        return replace(super().card(), hyperparameters={"train_freq": (8, "step")})


def test_a_setting_that_is_a_tuple_is_the_same_setting_later(tmp_path):
    for run in (0, 1):
        train(Tupled, "hopper-gravity", "single", "smoke", run, out=tmp_path / "tupled", jobs=0)
    found = tomllib.loads((tmp_path / "tupled" / "submission.toml").read_text())
    assert found["hyperparameters"]["train_freq"] == [8, "step"]
