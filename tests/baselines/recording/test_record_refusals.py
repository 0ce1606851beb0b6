"""Recordings that are refused: wrong arguments, and runs that do not belong to the submission."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines import Card, train
from gym_extensions.baselines.tracing.trace import trace
from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.scoring.replay.verify import verify

from ..conftest import QUICK_GROUP, digests
from .recordings import CARD, GROUP, TASKS, logged, message, push, record_stage

FIRST = TASKS[0].name

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
        f"{recorded / 'submission.toml'}: hyperparameters.rate is not stated in this submission and 0.1 in "
        "the new run."
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


def test_a_run_does_not_join_a_log_whose_traces_a_salt_drew(tmp_path: Path) -> None:
    record_tasks(tmp_path, run=0)
    trace(tmp_path, "5a" * 32, groups=[QUICK_GROUP])
    before = digests(tmp_path)
    refused = message(tmp_path, protocol="single", run=1, task=TASKS[0].name)
    assert "A salt has drawn the traces of these logs" in refused
    assert digests(tmp_path) == before


def test_a_salt_that_is_drawn_during_a_recording_fails_the_run_and_loses_nothing(tmp_path: Path) -> None:
    record_tasks(tmp_path, run=0)
    record_stage(tmp_path, push, "single", run=1, task=TASKS[0].name)

    def draws(observations: Any) -> Any:
        if not (tmp_path / GROUP / "traces" / "salt.txt").exists():
            trace(tmp_path, "5a" * 32, groups=[QUICK_GROUP])
        return push(observations)

    last: dict[str, Any] = {"protocol": "single", "run": 1, "task": TASKS[1].name}
    assert "A salt has drawn the traces of these logs" in message(tmp_path, draws, **last)
    trace(tmp_path, groups=[QUICK_GROUP])
    record_stage(tmp_path, **last, skip_recorded=True)
    assert {row["run"] for row in logged(tmp_path, "single")} == {"0", "1"}
    assert not verify(tmp_path, with_custom([QUICK_GROUP])).problems


def record_tasks(out: Path, run: int) -> None:
    """A run of single tasks."""
    for task in TASKS:
        record_stage(out, protocol="single", run=run, task=task.name)
