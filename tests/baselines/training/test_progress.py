"""The progress: bars, lines, log files, and a callback that receives events and may raise."""

import errno
import io
import re
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console
from rich.progress import Progress, TextColumn

from gym_extensions.baselines import JobFinished, Monitor, train
from gym_extensions.baselines.training import progress as events
from gym_extensions.baselines.training.progress import Bars, Event, TrainingStarted, printer

from ...conftest import refused
from ..conftest import QUICK_GROUP, SHORT_GROUP, Watched

STARTED = TrainingStarted({"group run0": 800})
TASK = "gym_extensions/Hopper-v0"
JOBS = (f"{SHORT_GROUP} sequential-run0", f"{SHORT_GROUP} joint-run0")


def batch(step: int, stage: int = 1) -> events.BatchTrained:
    return events.BatchTrained("group run0", stage, step, (stage - 1) * 400 + step, 21.25, 1234.5, 2.0)


class Clock:
    """A clock that a test sets."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


def bars_of(started: TrainingStarted, clock: Clock) -> Bars:
    progress = Progress(TextColumn("{task.fields[text]}"), console=Console(file=io.StringIO()))
    bars = Bars(progress, clock)
    bars.show(started)
    return bars


def test_the_time_left_is_that_of_the_steps_that_are_left_without_those_of_an_earlier_call() -> None:
    bars = bars_of(STARTED, clock := Clock())
    bars.show(events.StageStarted("group run0", 2, (TASK,), 400))
    for step, clock.now, left in ((100, 20.0, "unknown"), (200, 40.0, "0:00:40")):
        bars.show(batch(step, stage=2))
        assert bars.time_left() == left  # 5 steps per second; 200 steps are left


def test_the_time_left_follows_from_all_jobs_and_their_evaluations() -> None:
    bars = bars_of(TrainingStarted({f"group run{run}": 400 for run in range(4)}), clock := Clock())
    bars.show(batch(200))
    bars.show(events.TaskEvaluated("group run0", 1, 200, 200, TASK, 20, 30.0, 60.0))
    clock.now = 100.0
    assert bars.time_left() == "0:11:40"  # 1400 steps at 2 per second
    bars.show(JobFinished("group run1"))
    assert bars.time_left() == "0:08:20"


def test_an_agent_that_takes_no_steps_advances_with_its_stages() -> None:
    bars = bars_of(STARTED, clock := Clock())
    bars.show(events.TaskEvaluated("group run0", 0, 0, 0, TASK, 20, 30.0, 1.0))
    clock.now = 40.0
    assert bars.time_left() == "unknown"
    bars.show(events.TaskEvaluated("group run0", 1, 400, 400, TASK, 20, 30.0, 1.0))
    assert bars.time_left() == "0:00:40"


def test_a_slow_agent_shows_its_steps_within_a_batch() -> None:
    bars = bars_of(STARTED, Clock())
    bars.show(events.StepsTrained("group run0", 1, 7, 7, 0.35))
    lines = list[str]()
    printer(lines.append, bars.time_left)(events.StepsTrained("group run0", 1, 7, 7, 0.35))
    assert lines == ["group run0 stage 1: 7 steps, 0.35 steps per second, time left unknown"]


def test_lines_about_training_come_at_most_every_ten_seconds() -> None:
    printed, now = list[float](), 0.0
    show = printer(lambda _: printed.append(now), str, clock=lambda: now)
    while now < 25:
        show(batch(100))
        now += 0.5
    assert printed == [0, 10, 20]


def test_the_evaluation_at_the_end_of_a_stage_always_has_a_line() -> None:
    lines = list[str]()
    show = printer(lines.append, str, clock=lambda: 0.0)
    show(batch(100))
    where = ("group run0", 1, 400, 400, TASK, 20, 30.0, 1.0)
    show(events.TaskEvaluated(*where, in_training=True))
    show(events.TaskEvaluated(*where))
    assert lines[1:] == [f"group run0 stage 1: {TASK} mean return 30.0"]


def test_progress_can_be_switched_off(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    train("zero", QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "mine", progress=False)
    assert capsys.readouterr().out == ""
    assert "joint-run0: finished\n" in (tmp_path / "mine/.progress/train.log").read_text()


def test_the_log_file_has_a_line_per_event_with_its_time(watched: Watched) -> None:
    lines = (watched.folder / ".progress/train.log").read_text().splitlines()
    assert len(lines) == len(watched.events)
    assert [line for line in lines if not re.match(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d \w", line)] == []
    assert lines[-1].endswith(f"{JOBS[1]}: finished")
    assert sum("steps per second" in line for line in lines) == 4 + 4 + 8


def test_the_events_of_a_job_come_in_order(watched: Watched) -> None:
    names = [type(event).__name__ for event in watched.events]
    evaluated = [events.TaskEvaluated.__name__] * 2
    half = [events.BatchTrained.__name__] * 2
    stage = [events.StageStarted.__name__, *half, *evaluated, *half, *evaluated]
    expected = [TrainingStarted.__name__, events.StageStarted.__name__, *evaluated, *stage, *stage]
    assert names[: len(expected) + 1] == [*expected, JobFinished.__name__]


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
        train("zero", QUICK_GROUP, "joint", "smoke", 0, out=tmp_path / "mine")
    assert [str(each.message) for each in warned if each.category is RuntimeWarning] == [
        "train.log cannot be written: No space left on device. The training continues."
    ]
    assert (tmp_path / "mine" / QUICK_GROUP.name / "joint/run0.csv").exists()


def test_a_callback_that_raises_stops_the_training_and_loses_no_finished_stage(tmp_path: Path) -> None:
    arguments: Any = ("trpo", QUICK_GROUP, "sequential", "smoke", 0)
    stages = list[int]()

    def listen(event: Event) -> None:
        if isinstance(event, events.StageStarted):
            stages.append(event.stage)
        if isinstance(event, events.BatchTrained) and stages == [0, 1, 2]:
            raise ValueError("seen enough")

    monitor = Monitor(callback=listen)
    with refused("callback-failed", "The callback raised ValueError: seen enough", where="callback"):
        train(*arguments, out=tmp_path / "mine", progress=monitor)
    (log,) = train(*arguments, out=tmp_path / "mine", progress=monitor)
    assert (stages, log.exists()) == ([0, 1, 2, 2], True)
