"""A callback receives typed events and may raise; wrong names and missing packages are reported."""

from __future__ import annotations

import errno
import sys
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines import BatchTrained, JobFinished, StageStarted, TaskEvaluated, train
from gym_extensions.baselines.training.events import Event, TrainingStarted
from gym_extensions.errors import BenchError

from ..conftest import QUICK_GROUP, SHORT_GROUP, Watched


def test_the_events_of_a_job_come_in_order(watched: Watched) -> None:
    names = [type(event).__name__ for event in watched.events]
    evaluated = [TaskEvaluated.__name__] * 2
    half = [BatchTrained.__name__] * 2
    stage = [StageStarted.__name__, *half, *evaluated, *half, *evaluated]
    expected = [TrainingStarted.__name__, StageStarted.__name__, *evaluated, *stage, *stage]
    assert names[: len(expected) + 1] == [*expected, JobFinished.__name__]


def test_a_batch_has_its_steps_return_and_speed(watched: Watched) -> None:
    batches = [event for event in watched.events if isinstance(event, BatchTrained)]
    assert [(event.stage, event.step, event.job_step) for event in batches[:8]] == [
        (stage, step, step + 1000 * (stage - 1)) for stage in (1, 2) for step in (250, 500, 750, 1000)
    ]
    for event in batches:
        assert event.mean_return is not None
        assert event.steps_per_second == pytest.approx(250 / event.seconds, rel=0.01)


def test_a_log_that_cannot_be_written_gives_one_warning_and_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    open_file = Path.open

    def fill_disk(path: Path, *arguments: Any, **options: Any) -> Any:
        if path.name == "train.log":
            raise OSError(errno.ENOSPC, "No space left on device")
        return open_file(path, *arguments, **options)

    monkeypatch.setattr(Path, "open", fill_disk)
    with pytest.warns(RuntimeWarning) as warned:
        train("zero", QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "mine", log="csv", progress=False)
    assert [str(each.message) for each in warned if each.category is RuntimeWarning] == [
        "A log of the training cannot be written: No space left on device. The training continues."
    ]
    assert (tmp_path / "mine" / QUICK_GROUP.name / "joint.csv").exists()
    assert (tmp_path / "mine/.progress/events.csv").exists()


class Impatient:
    """A callback that raises in the second stage, once."""

    def __init__(self) -> None:
        self.has_raised = False

    def __call__(self, event: Event) -> None:
        if isinstance(event, BatchTrained) and event.stage == 2 and not self.has_raised:
            self.has_raised = True
            raise ValueError("seen enough")


def test_a_callback_that_raises_stops_the_training_and_loses_no_finished_stage(tmp_path: Path) -> None:
    callback, out = Impatient(), tmp_path / "mine"
    arguments: Any = ("trpo", QUICK_GROUP, "sequential", "smoke", 0)
    with pytest.raises(BenchError) as error:
        train(*arguments, out=out, progress=False, callback=callback)
    assert error.value.code == "callback-failed"
    assert isinstance(error.value.__cause__, ValueError)
    assert str(error.value).startswith("callback: The callback raised ValueError: seen enough")
    assert (
        error.value.hint == "Correct the callback. The same command continues; it reuses 2 finished stages."
    )
    stages = list[int]()

    def note(event: Event) -> None:
        if isinstance(event, StageStarted):
            stages.append(event.stage)

    train(*arguments, out=out, progress=False, callback=note)
    assert stages == [2]
    assert (out / QUICK_GROUP.name / "sequential.csv").exists()


def test_a_callback_that_raises_stops_worker_processes(tmp_path: Path) -> None:
    def callback(event: Event) -> None:
        if isinstance(event, TaskEvaluated):
            raise KeyError("task")

    with pytest.raises(BenchError) as error:
        train("zero", QUICK_GROUP, "single", "smoke", 0, out=tmp_path / "mine", jobs=1, callback=callback)
    assert str(error.value).startswith(
        "callback: The callback raised KeyError: 'task'. Correct the callback. "
    )


def test_a_missing_tensorboard_is_named_with_the_command_that_installs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "tensorboard.summary.writer.event_file_writer", None)
    with pytest.raises(BenchError) as error:
        train("zero", SHORT_GROUP, "single", "smoke", 0, out=tmp_path / "mine", log="tensorboard")
    assert error.value.hint == "Install it with: pip install 'gym-extensions[log]'"
    assert not (tmp_path / "mine").exists()
