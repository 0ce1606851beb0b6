"""Recorded policies: the files of the training loop, unfinished runs, and policies that are refused."""

from __future__ import annotations

import csv
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import Card, record, train
from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.reader import read
from gym_extensions.scoring.pipeline.score import make_scorer
from gym_extensions.scoring.replay.verify import verify

from ..conftest import QUICK_GROUP, digests

GROUP = QUICK_GROUP.name
TASKS = QUICK_GROUP.tasks
FIRST, SECOND = (task.name for task in TASKS)
GROUPS = with_custom([QUICK_GROUP])
CARD = Card("mine", evaluation="deterministic", parameters=7)


def zero(observations: Any) -> Any:
    return np.zeros((len(observations), 7))


def push(observations: Any) -> Any:
    return np.full((len(observations), 7), 0.5)


def record_stage(
    out: Path, policy: Any = zero, protocol: str = "sequential", **changes: Any
) -> dict[str, float]:
    arguments: dict[str, Any] = {"run": 0, "out": out, "budget": "smoke", "card": CARD} | changes
    return record(policy, QUICK_GROUP, protocol, **arguments)


def message(*arguments: Any, **changes: Any) -> str:
    with pytest.raises(BenchError) as error:
        record_stage(*arguments, **changes)
    return str(error.value)


def logged(out: Path, protocol: str = "sequential") -> list[dict[str, str]]:
    with (out / GROUP / f"{protocol}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The policy zero, sequential and single, with stages and tasks in another order than in the log."""
    out = tmp_path_factory.mktemp("recorded") / "mine"
    for stage in (2, 0, 1):
        record_stage(out, stage=stage)
    for task in reversed(TASKS):
        record_stage(out, protocol="single", task=task.name, curves={task.name: [(500, -10.0), (1000, -9.0)]})
    return out


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


class Model:
    """A recurrent model with the method of Stable-Baselines3: its action grows by 0.01 per step."""

    def __init__(self) -> None:
        self.calls: list[tuple[bool, bool]] = []

    def predict(self, observation: Any, state: Any, episode_start: Any, deterministic: bool) -> Any:
        self.calls.append((bool(episode_start.all()), deterministic))
        assert (state is None) == bool(episode_start.all())
        steps = 0 if state is None else state + 1
        return np.full((len(observation), 7), steps / 100), steps


def test_a_model_of_stable_baselines3_keeps_its_state_within_a_task(tmp_path: Path) -> None:
    model = Model()
    record_stage(tmp_path / "mine", model, protocol="joint")
    starts = [start for start, _ in model.calls]
    assert starts == ([True] + [False] * 9) * 2
    assert {deterministic for _, deterministic in model.calls} == {True}


def test_a_policy_of_plain_arrays_samples_the_same_each_time_and_is_stored(tmp_path: Path) -> None:
    uniform = Policy(np.zeros(7), np.ones(7), head="uniform")
    card = replace(CARD, evaluation="sampled")
    first, second = (
        record_stage(tmp_path / name, uniform, "joint", card=card) for name in ("first", "second")
    )
    assert first == second
    stored = tmp_path / "first" / GROUP / "policies" / "joint-run0-stage1.npz"
    assert stored.read_bytes() == uniform.to_bytes()
    assert first != record_stage(tmp_path / "first", uniform, "joint", card=card, run=1)


SHAPES = "observations of shape (20, 23) and dtype float64"
BAD_POLICIES: dict[str, tuple[Any, str]] = {
    "wrong actions": (
        lambda observations: np.zeros((len(observations), 2)),
        "act(): The agent returned an array of shape (20, 2) and dtype float64 as actions. Return an array "
        "of numbers of shape (20, 7), one row per environment.",
    ),
    "wrong observations": (
        lambda observations: observations @ np.zeros((11, 7)),
        f"policy: The policy failed on {SHAPES}: ValueError: matmul: ",
    ),
    "not a policy": (
        "policy.pt",
        "policy: A value of type str is not a policy. Use a function from observations (n, …) to actions (n, "
        "…), or an object with a method act or predict.",
    ),
}


@pytest.mark.parametrize("name", BAD_POLICIES)
def test_a_policy_of_the_wrong_shapes_is_refused_and_nothing_is_lost(name: str, tmp_path: Path) -> None:
    out = tmp_path / "mine"
    policy, text = BAD_POLICIES[name]
    assert message(out, policy, "joint").startswith(text)
    record_stage(out, protocol="joint")
    assert len(logged(out, "joint")) == 40


BAD_ARGUMENTS: list[tuple[dict[str, Any], str]] = [
    (
        {"stage": 3},
        "stage: Stage 3 is out of range. Use the number of tasks of quick-pusher that the policy was trained "
        "on, 0 to 2.",
    ),
    (
        {"stage": True},
        "stage: Stage True is out of range. Use the number of tasks of quick-pusher that the policy was "
        "trained on, 0 to 2.",
    ),
    (
        {},
        "stage: The protocol sequential needs a stage. Use the number of tasks of quick-pusher that the "
        "policy was trained on, 0 to 2.",
    ),
    (
        {"stage": 0, "task": FIRST},
        "task: Unexpected task 'Pusher.steps-10'. Each stage is evaluated on every task; leave task out.",
    ),
    (
        {"protocol": "joint", "stage": 2},
        "stage: Stage 2 is out of range: the protocol joint has stage 1 only. Leave stage out.",
    ),
    (
        {"protocol": "joint", "task": FIRST},
        "task: Unexpected task 'Pusher.steps-10'. A joint policy is trained on every task; leave task out.",
    ),
    (
        {"protocol": "single"},
        "task: The protocol single needs a task. Name the task that the policy was trained on.",
    ),
    (
        {"protocol": "single", "task": "Pushr.steps-10"},
        "task: 'Pushr.steps-10' is not a task of this group or stage. Did you mean 'Pusher.steps-10'?",
    ),
    (
        {"stage": 0, "run": [0, 1]},
        "runs: Expected an integer or several, got [[0, 1]]. For example 0, [0, 1] or ",
    ),
    (
        {"stage": 0, "card": replace(CARD, evaluation="both")},
        "card().evaluation: The value is 'both'. Choose one of: deterministic, sampled.",
    ),
    (
        {"protocol": "joint", "curves": {FIRST: [(10, 0.0), (10, 0.0)]}},
        f"curves['{FIRST}']: The training steps do not increase. Start above 0.",
    ),
    (
        {"protocol": "joint", "curves": {FIRST: [(9000, 0.0)]}},
        f"curves['{FIRST}']: It ends at step 9000; the budget is 2000. Choose the budget that the policy ",
    ),
    (
        {"protocol": "joint", "curves": {FIRST: [(10, float("nan"))]}},
        f"curves['{FIRST}']: A return is not finite. Leave such points out.",
    ),
]


@pytest.mark.parametrize(("changes", "text"), BAD_ARGUMENTS)
def test_a_wrong_argument_is_refused_before_anything_is_written(
    changes: dict[str, Any], text: str, tmp_path: Path
) -> None:
    assert message(tmp_path / "mine", **changes).startswith(text)
    assert not (tmp_path / "mine").exists()


def test_a_policy_of_another_algorithm_is_refused(recorded: Path) -> None:
    text = message(recorded, stage=0, run=1, card=replace(CARD, hyperparameters={"rate": 0.1}))
    assert text.startswith(
        f"{recorded / 'submission.toml'}: hyperparameters.rate is None in this submission and 0.1 in the new "
        "run."
    )


def test_an_unfinished_run_has_one_set_of_hyperparameters(tmp_path: Path) -> None:
    record_stage(tmp_path / "mine", stage=0)
    text = message(tmp_path / "mine", stage=1, card=replace(CARD, hyperparameters={"rate": 0.1}))
    assert (
        "The unfinished run has other settings: hyperparameters.rate is None, and 0.1 in this command."
        in text
    )


def test_recorded_policies_do_not_join_trained_runs(tmp_path: Path) -> None:
    train("zero", QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "trained")
    card = Card("zero", evaluation="deterministic")
    text = message(tmp_path / "trained", protocol="joint", run=1, card=card)
    assert "protocol.steps is 'recorded' in this submission and 'claimed' in the new run." in text


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
