"""Recorded policies: the files of the training loop, unfinished and finished runs, and claimed values."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.baselines import train
from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.rollouts.reader import read
from gym_extensions.scoring.pipeline.score import make_scorer
from gym_extensions.scoring.replay.verify import verify

from ..conftest import QUICK_GROUP, digests
from .recordings import CARD, GROUP, TASKS, logged, message, push, record_stage

GROUPS = with_custom([QUICK_GROUP])


def test_the_logs_and_traces_are_those_of_the_training_loop(recorded: Path, tmp_path: Path) -> None:
    train("zero", QUICK_GROUP, ["sequential", "single"], "smoke", 0, out=tmp_path / "trained")
    expected = {
        path: digest for path, digest in digests(tmp_path / "trained").items() if "policies" not in path
    }
    actual = {path: digest for path, digest in digests(recorded).items() if "curves" not in path}
    assert actual.keys() == expected.keys()
    assert {path for path in actual if actual[path] != expected[path]} == {"submission.toml"}


def test_the_submission_can_be_replayed(recorded: Path) -> None:
    verification = verify(recorded, GROUPS)
    assert (verification.problems, verification.replayed) == ((), 15)


def test_the_manifest_scorecard_and_board_say_that_steps_are_claimed(recorded: Path) -> None:
    manifest = tomllib.loads((recorded / "submission.toml").read_text(encoding="utf-8"))
    assert manifest["protocol"] == {
        "budget": "smoke",
        "algorithm": "mine",
        "evaluation": "deterministic",
        "steps": "claimed",
    }
    card = make_scorer([QUICK_GROUP], None)(recorded)
    assert card.manifest is not None
    assert card.manifest.protocol.steps == "claimed"


def test_claimed_curves_are_written(recorded: Path) -> None:
    curves = read(recorded, GROUPS).groups[f"{GROUP}-v0"].curves
    assert curves is not None
    text = (recorded / GROUP / "curves.csv").read_text(encoding="utf-8").splitlines()
    assert text[1] == f"single,0,{TASKS[0].id},500,-10.0"
    assert len(text) == 1 + 4


def test_the_mean_returns_of_the_evaluated_tasks_are_returned(tmp_path: Path) -> None:
    means = record_stage(tmp_path / "mine", protocol="joint")
    rows = [float(row["return"]) for row in logged(tmp_path / "mine", "joint") if row["task"] == TASKS[1].id]
    assert list(means) == list(QUICK_GROUP.task_ids)
    assert means[TASKS[1].id] == pytest.approx(sum(rows) / 20)


def test_parameters_are_counted_before_and_after_training(tmp_path: Path) -> None:
    for stage in (2, 1, 0):
        record_stage(tmp_path / "mine", stage=stage, card=replace(CARD, parameters=10 + stage))
    manifest = tomllib.loads((tmp_path / "mine/submission.toml").read_text(encoding="utf-8"))
    assert manifest["memory"] == {"stored_steps": 0, "parameters_first": 10, "parameters_last": 12}


def test_a_run_is_in_the_log_when_all_of_its_stages_are(tmp_path: Path) -> None:
    out = tmp_path / "mine"
    record_stage(out, stage=0)
    record_stage(out, stage=2)
    assert not (out / GROUP).exists()
    assert not (out / "submission.toml").exists()
    record_stage(out, push, stage=0)  # replaces the first
    record_stage(out, stage=1)
    assert {row["stage"] for row in logged(out)} == {"0", "1", "2"}
    returns = {stage: [row["return"] for row in logged(out) if row["stage"] == stage] for stage in "012"}
    assert returns["1"] == returns["2"]
    assert returns["0"] != returns["1"]


def test_a_finished_run_is_not_recorded_again(recorded: Path) -> None:
    before = digests(recorded)
    assert message(recorded, push, stage=0) == (
        f"{recorded}: Run 0 is already in {GROUP}/sequential.csv. Pass skip_recorded=True to skip it, choose "
        "another run, or choose another out."
    )
    means = record_stage(recorded, push, stage=0, skip_recorded=True)
    assert list(means) == list(QUICK_GROUP.task_ids)
    assert digests(recorded) == before


RECORD_A_RUN = """
import sys, numpy as np
from gym_extensions.baselines import Card, record
from gym_extensions.envs import MovingGoal, TaskGroup, customize
tasks = customize("Pusher", max_steps=10), customize("Pusher", [MovingGoal()], max_steps=10)
run = int(sys.argv[2])
def act(observations):
    return np.full((len(observations), 7), run / 10)
card = Card("mine", evaluation="deterministic", parameters=7)
group = TaskGroup("quick-pusher", tasks)
for task in tasks:
    record(act, group, "single", run=run, task=task.name, out=sys.argv[1], budget="smoke", card=card)
"""


def test_two_processes_write_one_log(tmp_path: Path) -> None:
    out = tmp_path / "mine"
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", RECORD_A_RUN, str(out), run], stderr=subprocess.PIPE, text=True
        )
        for run in ("0", "1")
    ]
    errors = [process.communicate(timeout=300)[1] for process in processes]
    assert [process.returncode for process in processes] == [0, 0], errors
    assert [row["run"] for row in logged(out, "single")] == ["0"] * 40 + ["1"] * 40
    verification = verify(out, GROUPS)
    assert (verification.problems, verification.replayed) == ((), 8)
