"""Progress on the screen: bars in a terminal, lines elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from gym_extensions.baselines.reporting.lines import line
from gym_extensions.baselines.reporting.time_left import TimeLeft, clock_time
from gym_extensions.baselines.training.events import (
    BatchTrained,
    Event,
    JobFailed,
    JobFinished,
    StageStarted,
    TaskEvaluated,
    TrainingStarted,
)

FIRST_INTERVAL, LONGEST_INTERVAL = 1.0, 60.0
"""Seconds between two lines about training; each interval is twice the one before, up to the longest."""


class Lines:
    """Prints lines: the end of every stage, and training at growing intervals."""

    def __init__(self, write: Callable[[str], object], clock: Callable[[], float] = time.monotonic) -> None:
        self._write, self._clock, self._time_left = write, clock, TimeLeft()
        self._interval, self._next = FIRST_INTERVAL, 0.0

    def show(self, event: Event) -> None:
        """Prints a line, unless the event is about training and the last such line is too recent."""
        self._time_left.update(event)
        if isinstance(event, StageStarted | JobFinished):
            return
        if isinstance(event, BatchTrained) or (isinstance(event, TaskEvaluated) and event.in_training):
            now = self._clock()
            if now < self._next:
                return
            self._next = now + self._interval
            self._interval = min(2 * self._interval, LONGEST_INTERVAL)
        self._write(line(event, self._time_left.seconds()))


class Bars:
    """One bar per running job and one for all, measured in training steps."""

    def __init__(self, progress: Progress) -> None:
        self._progress, self._time_left = progress, TimeLeft()
        self._rows: dict[str, TaskID] = {}
        self._total: TaskID | None = None

    def show(self, event: Event) -> None:
        """Moves the bars."""
        self._time_left.update(event)
        if isinstance(event, TrainingStarted):
            steps = self._time_left.steps_left()
            self._total = self._progress.add_task("all jobs", total=steps, text="") if event.jobs else None
        elif isinstance(event, JobFinished | JobFailed):
            if event.job in self._rows:
                self._progress.remove_task(self._rows.pop(event.job))
            if isinstance(event, JobFailed):
                self._progress.console.print(line(event, None), highlight=False, markup=False)
        else:
            self._show_job(event)
        if self._total is not None:
            total = self._progress.tasks[self._progress.task_ids.index(self._total)].total or 0
            text = f"time left {clock_time(self._time_left.seconds())}"
            self._progress.update(self._total, completed=total - self._time_left.steps_left(), text=text)

    def _show_job(self, event: StageStarted | BatchTrained | TaskEvaluated) -> None:
        job = self._time_left.jobs.get(event.job)
        if job is None:
            return
        if event.job not in self._rows:
            self._rows[event.job] = self._progress.add_task(event.job, total=job.total_steps, text="")
        text = "" if isinstance(event, StageStarted) else None
        if isinstance(event, BatchTrained):
            mean_return = "" if event.mean_return is None else f"return {event.mean_return:.1f}, "
            text = f"{mean_return}{event.steps_per_second:,.0f} steps/s"
        elif isinstance(event, TaskEvaluated):
            text = f"{event.task.rpartition('/')[2]} {event.mean_return:.1f}"
        self._progress.update(
            self._rows[event.job],
            description=f"{event.job} stage {event.stage}",
            completed=job.total_steps - job.left().steps,
            text=text,
        )


Screen = Lines | Bars


@contextmanager
def open_screen() -> Iterator[Screen]:
    """The screen of one call: bars in a terminal, lines elsewhere (a file, a pipe, a notebook)."""
    console = Console()
    if not console.is_terminal:
        yield Lines(lambda text: console.print(text, highlight=False, soft_wrap=True, markup=False))
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=10),
        TextColumn("{task.percentage:>3.0f}%"),
        TextColumn("{task.fields[text]}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console) as progress:
        yield Bars(progress)
