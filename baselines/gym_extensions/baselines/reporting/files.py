"""Writes events to files in the folder of the submission's progress: a readable log, and a CSV file."""

from __future__ import annotations

import csv
import time
from collections.abc import Callable
from pathlib import Path

from gym_extensions.atomic import write_text
from gym_extensions.baselines.reporting.lines import line
from gym_extensions.baselines.reporting.time_left import TimeLeft
from gym_extensions.baselines.training.events import (
    BatchTrained,
    Event,
    JobFailed,
    Listener,
    TaskEvaluated,
    TrainingStarted,
)

TRAIN_LOG, EVENTS_CSV = "train.log", "events.csv"
EVENT_COLUMNS = ("event", "job", "stage", "step", "job_step", "task", "mean_return", "steps_per_second")


def log_file(folder: Path, now: Callable[[], float] = time.time) -> Listener:
    """Appends a line per event with date and local time, and tracebacks of failed jobs, to ``train.log``."""
    path, time_left = folder / TRAIN_LOG, TimeLeft()

    def listen(event: Event) -> None:
        time_left.update(event)
        if isinstance(event, TrainingStarted):
            if not event.jobs:
                return
            folder.mkdir(parents=True, exist_ok=True)
        stamp = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(now()))
        with path.open("a", encoding="utf-8", newline="\n") as file:
            file.write(f"{stamp} {line(event, time_left.seconds())}\n")
            if isinstance(event, JobFailed):
                file.write(event.traceback)

    return listen


def csv_file(folder: Path) -> Listener:
    """Appends a row per batch (event ``batch``) and evaluated task (``evaluation``) to ``events.csv``.

    Steps are counted since the stage began (``step``) and since the job began (``job_step``). ``mean_return``
    is empty if no training episode ended.
    """
    path = folder / EVENTS_CSV

    def listen(event: Event) -> None:
        if not isinstance(event, BatchTrained | TaskEvaluated):
            return
        where = (event.job, event.stage, event.step, event.job_step)
        row: tuple[object, ...]
        if isinstance(event, BatchTrained):
            mean_return = "" if event.mean_return is None else event.mean_return
            row = ("batch", *where, "", mean_return, round(event.steps_per_second, 1))
        else:
            row = ("evaluation", *where, event.task, event.mean_return, "")
        if not path.exists():
            write_text(path, ",".join(EVENT_COLUMNS) + "\n")
        with path.open("a", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerow(row)

    return listen
