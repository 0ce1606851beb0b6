"""The progress on the screen: lines at growing intervals, and bars in a terminal."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path

from rich.console import Console
from rich.progress import Progress, TextColumn

from gym_extensions.baselines.reporting.display import Bars, Lines
from gym_extensions.baselines.training.events import (
    BatchTrained,
    JobFinished,
    JobPlan,
    StagePlan,
    StageStarted,
    TaskEvaluated,
    TrainingStarted,
)

from ..conftest import Watched

STARTED = TrainingStarted((JobPlan("group run0", (StagePlan(1, 400, 20),)),))
TASK = "gym_extensions/Hopper-v0"


def batch(step: int) -> BatchTrained:
    return BatchTrained("group run0", 1, step, step, 21.25, 1234.5, 2.0)


def test_a_batch_has_a_line_with_return_speed_and_time_left() -> None:
    lines = list[str]()
    screen = Lines(lines.append, clock=lambda: 0.0)
    for event in (STARTED, StageStarted("group run0", 1, (TASK,), 400), batch(100)):
        screen.show(event)
    assert lines == [
        "1 job: 400 training steps, 20 evaluation episodes",
        "group run0 stage 1: 100 steps, mean return 21.2, 1,234 steps per second, time left 0:00:06",
    ]


def test_lines_about_training_come_at_intervals_that_double_up_to_a_minute() -> None:
    printed, now = list[float](), 0.0
    screen = Lines(lambda _: printed.append(now), clock=lambda: now)
    while now < 300:
        screen.show(batch(100))
        now += 0.5
    assert printed == [0, 1, 3, 7, 15, 31, 63, 123, 183, 243]


def test_the_evaluation_at_the_end_of_a_stage_always_has_a_line() -> None:
    lines = list[str]()
    screen = Lines(lines.append, clock=lambda: 0.0)
    screen.show(batch(100))
    where = ("group run0", 1, 400, 400, TASK, 20, 30.0, 1.0)
    screen.show(TaskEvaluated(*where, in_training=True))
    screen.show(TaskEvaluated(*where))
    assert lines[1:] == [f"group run0 stage 1: {TASK} mean return 30.0"]


def test_a_batch_without_an_ended_episode_says_so() -> None:
    lines = list[str]()
    Lines(lines.append).show(BatchTrained("group run0", 1, 100, 100, None, 50.0, 2.0))
    assert lines == [
        "group run0 stage 1: 100 steps, no episode ended, 50 steps per second, time left unknown"
    ]


def test_bars_show_every_job_and_all_together() -> None:
    progress = Progress(TextColumn("{task.fields[text]}"), console=Console(file=io.StringIO()))
    bars = Bars(progress)
    bars.show(STARTED)
    bars.show(StageStarted("group run0", 1, (TASK,), 400))
    bars.show(batch(100))
    total, job = progress.tasks
    assert (total.completed, total.total, total.fields["text"]) == (100, 400, "time left 0:00:06")
    assert (job.completed, job.total, job.description) == (100, 400, "group run0 stage 1")
    assert job.fields["text"] == "return 21.2, 1,234 steps/s"
    bars.show(TaskEvaluated("group run0", 1, 400, 400, TASK, 20, 30.0, 1.0))
    assert job.fields["text"] == "Hopper-v0 30.0"
    bars.show(JobFinished("group run0"))
    assert [(task.completed, task.total) for task in progress.tasks] == [(400, 400)]


def test_a_call_in_a_script_prints_its_progress(watched: Watched) -> None:
    lines = watched.printed.splitlines()
    assert lines[0] == "2 jobs: 4,000 training steps, 180 evaluation episodes"
    assert any("steps per second, time left" in line for line in lines)


def test_progress_can_be_switched_off(tmp_path: Path) -> None:
    code = (
        "from gym_extensions.baselines import train;"
        "train('zero', 'pusher', 'joint', 'smoke', 0, out='mine', progress=False)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout == ""
    assert "pusher joint-run0: finished\n" in (tmp_path / "mine/.progress/train.log").read_text()
