"""Recorded policies: the files of the training loop, the forms of a policy, and what is refused."""

from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest

from gym_extensions.baselines import Card, Observes, record, train
from gym_extensions.baselines.training.checkpoints import JobFolder
from gym_extensions.catalog.groups import with_custom
from gym_extensions.submissions.policies.files import read_policies
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.run import RunDocument, read_run
from gym_extensions.versions import processor

from ..conftest import refused
from .conftest import QUICK_GROUP, digests, log_rows

GROUPS = with_custom([QUICK_GROUP])
GROUP = QUICK_GROUP.name
TASKS = QUICK_GROUP.tasks
FIRST = TASKS[0].name
CARD = Card("mine", evaluation="deterministic", parameters=7)
OFFSET_AND_SCALE = np.zeros(7, np.float32), np.ones(7, np.float32)


def zero(observations: Any) -> Any:
    """The policy that most tests record."""
    return np.zeros((len(observations), 7))


def push(observations: Any) -> Any:
    """Another policy."""
    return np.full((len(observations), 7), 0.5)


def record_stage(out: Path, policy: Any = zero, protocol: str = "sequential", **changes: Any) -> Any:
    """Records one stage of run 0, by default with the policy ``zero``."""
    arguments: dict[str, Any] = {"run": 0, "out": out, "budget": "smoke", "card": CARD} | changes
    return record(policy, QUICK_GROUP, protocol, **arguments)


def logged(out: Path, protocol: str = "sequential", run: int = 0) -> list[dict[str, str]]:
    """The rows of the log of a run."""
    return log_rows(out / GROUP / protocol / f"run{run}.csv")


def document(out: Path, protocol: str = "sequential", run: int = 0) -> RunDocument:
    """The document of a run."""
    return read_run(out / GROUP / protocol / f"run{run}.json")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The policy zero, sequential and single, with stages and tasks in another order than in the log."""
    out = tmp_path_factory.mktemp("recorded") / "mine"
    for stage in (2, 0, 1):
        record_stage(out, stage=stage)
    for task in reversed(TASKS):
        record_stage(out, protocol="single", task=task.name, curves={task.name: [(500, -10.0), (1000, -9.0)]})
    return out


def test_the_logs_are_those_of_the_training_loop(recorded: Path, tmp_path: Path) -> None:
    train("zero", QUICK_GROUP, ["sequential", "single"], "smoke", 0, out=tmp_path / "trained")
    expected, actual = digests(tmp_path / "trained"), digests(recorded)
    logs = [path for path in expected if path.endswith(".csv")]
    assert len(logs) == 2
    assert {path: actual[path] for path in logs} == {path: expected[path] for path in logs}
    assert not read(recorded, GROUPS).problems


def test_the_document_states_what_was_claimed_and_not_counted_or_measured(recorded: Path) -> None:
    claimed = document(recorded, "single")
    assert (claimed.steps, claimed.steps_counted) == (2000, False)
    assert claimed.cpu_seconds is None
    assert [(each.task, each.steps, each.returns) for each in claimed.curves] == [
        (task.id, [500, 1000], [-10.0, -9.0]) for task in TASKS
    ]
    assert claimed.machine is not None
    assert claimed.machine.processor == processor(), "which evaluated"


def test_the_mean_returns_of_the_evaluated_tasks_are_returned(tmp_path: Path) -> None:
    means = record_stage(tmp_path / "mine", protocol="joint")
    rows = [float(row["return"]) for row in logged(tmp_path / "mine", "joint") if row["task"] == TASKS[1].id]
    assert list(means) == list(QUICK_GROUP.task_ids)
    assert means[TASKS[1].id] == pytest.approx(sum(rows) / 20)


def test_parameters_are_counted_before_and_after_training(tmp_path: Path) -> None:
    for stage in (2, 1, 0):
        record_stage(tmp_path / "mine", stage=stage, card=replace(CARD, parameters=10 + stage))
    memory = document(tmp_path / "mine").memory
    assert (memory.stored_steps, memory.parameters_first, memory.parameters_last) == (0, 10, 12)


def test_a_run_is_written_when_all_of_its_stages_are_recorded(tmp_path: Path) -> None:
    out = tmp_path / "mine"
    record_stage(out, stage=0)
    record_stage(out, stage=2)
    assert not (out / GROUP).exists()
    assert not (out / "submission.toml").exists()
    record_stage(out, push, stage=0)  # replaces the first
    record_stage(out, stage=1)
    returns = {stage: [row["return"] for row in logged(out) if row["stage"] == stage] for stage in "012"}
    assert returns["1"] == returns["2"]
    assert returns["0"] != returns["1"]


def test_a_finished_run_is_not_recorded_again(recorded: Path) -> None:
    before = digests(recorded)
    with refused("run-recorded"):
        record_stage(recorded, push, stage=0)
    assert digests(recorded) == before


BAD_ARGUMENTS: list[tuple[dict[str, Any], str, str]] = [
    ({"stage": 3}, "bad-stage", "3"),
    ({"stage": 1.0}, "bad-stage", "1.0"),
    ({}, "bad-stage", "needs a stage"),
    ({"stage": 0, "task": FIRST}, "bad-task", FIRST),
    ({"protocol": "joint", "task": FIRST}, "bad-task", FIRST),
    ({"protocol": "single"}, "bad-task", "needs a task"),
    ({"protocol": "single", "task": "Pushr.steps-10"}, "unknown-task", "'Pusher.steps-10'"),
    ({"stage": 0, "card": replace(CARD, evaluation="both")}, "bad-card", "'both'"),
    ({"protocol": "joint", "curves": {FIRST: [(10, 0.0), (10, 0.0)]}}, "bad-curve", "do not increase"),
    ({"protocol": "joint", "curves": {FIRST: [(9000, 0.0)]}}, "bad-curve", "9000"),
    ({"protocol": "joint", "curves": {FIRST: [(10, float("nan"))]}}, "bad-curve", "not finite"),
    ({"protocol": "joint", "curves": {FIRST: [(float("nan"), 0.0)]}}, "bad-curve", "not pairs"),
    ({"protocol": "joint", "curves": {FIRST: [18.3, 20.0]}}, "bad-curve", "not pairs"),
]


@pytest.mark.parametrize(("changes", "code", "named"), BAD_ARGUMENTS)
def test_a_wrong_argument_is_refused_before_anything_is_written(
    changes: dict[str, Any], code: str, named: str, tmp_path: Path
) -> None:
    with refused(code, named):
        record_stage(tmp_path / "mine", **changes)
    assert not (tmp_path / "mine").exists()


def test_a_policy_of_another_algorithm_is_refused(recorded: Path) -> None:
    with refused("mixed-submission", "hyperparameters.rate"):
        record_stage(recorded, stage=0, run=1, card=replace(CARD, hyperparameters={"rate": 0.1}))


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
    first, second = (record_stage(tmp_path / name, uniform, "joint", card=card) for name in ("first", "next"))
    assert first == second
    stored = read_policies(tmp_path / "first", QUICK_GROUP, "joint", 0)[1, None]
    assert {name: value.tobytes() for name, value in stored.arrays().items()} == {
        name: value.tobytes() for name, value in uniform.arrays().items()
    }
    assert first != record_stage(tmp_path / "first", uniform, "joint", card=card, run=1)


def test_a_run_of_which_some_stages_have_a_policy_is_not_written_and_nothing_is_lost(tmp_path: Path) -> None:
    out, zero = tmp_path / "mine", Policy(np.zeros(7), np.ones(7))
    for stage in (0, 1):
        record_stage(out, zero, stage=stage)
    with refused("bad-policies", "policy2.npz"):
        record_stage(out, zero.act, stage=2)
    record_stage(out, zero, stage=2)
    assert list(read_policies(out, QUICK_GROUP, "sequential", 0)) == [(0, None), (1, None), (2, None)]


BAD_POLICIES: dict[str, tuple[Any, str, str]] = {
    "wrong actions": (lambda observations: np.zeros((len(observations), 2)), *("bad-actions", "(20, 2)")),
    "wrong observations": (lambda observations: observations @ np.zeros((11, 7)), "bad-policy", "(20, 23)"),
    "not a policy": ("policy.pt", "bad-policy", "str"),
}


@pytest.mark.parametrize("name", BAD_POLICIES)
def test_a_policy_of_the_wrong_shapes_is_refused_and_nothing_is_lost(name: str, tmp_path: Path) -> None:
    out = tmp_path / "mine"
    policy, code, named = BAD_POLICIES[name]
    with refused(code, named):
        record_stage(out, policy, "joint")
    record_stage(out, protocol="joint")
    assert len(logged(out, "joint")) == 40


def test_policies_that_get_a_head_per_task_while_they_are_trained(tmp_path: Path) -> None:
    observes = Observes(True, True)
    for stage in range(len(TASKS) + 1):
        tasks = (stage,) if stage else ()
        weights, biases = np.zeros((*tasks, 23, 7), np.float32), np.zeros((*tasks, 7), np.float32)
        policy = Policy(*OFFSET_AND_SCALE, weights=(weights,), biases=(biases,))
        record_stage(tmp_path, policy, stage=stage, observes=observes)
    assert not read(tmp_path, GROUPS, policies=True).problems


def test_the_policy_of_an_earlier_attempt_is_not_published(tmp_path: Path) -> None:
    record_stage(tmp_path, Policy(*OFFSET_AND_SCALE), "single", task=TASKS[0].name)
    for task in TASKS:
        record_stage(tmp_path, zero, "single", task=task.name)
    assert document(tmp_path, "single").policies is None


def test_a_stage_whose_second_recording_was_interrupted_is_recorded_again_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    record_stage(tmp_path, Policy(*OFFSET_AND_SCALE), stage=1)
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(JobFolder, "finish", Mock(side_effect=KeyboardInterrupt))
        record_stage(tmp_path, Policy(OFFSET_AND_SCALE[0] + 0.5, OFFSET_AND_SCALE[1]), stage=1)
    for stage in (0, 2):
        record_stage(tmp_path, Policy(*OFFSET_AND_SCALE), stage=stage)
    assert not (tmp_path / GROUP).exists()
    record_stage(tmp_path, Policy(*OFFSET_AND_SCALE), stage=1)
    assert len(logged(tmp_path)) == 120
