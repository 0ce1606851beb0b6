"""Shows and logs the progress of training, as events arrive."""

from __future__ import annotations

import csv
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager, nullcontext
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TimeElapsedColumn, TimeRemainingColumn

from gym_extensions.baselines.training import events
from gym_extensions.baselines.training.checkpoints import CONTINUES
from gym_extensions.baselines.training.jobs import Interim, listed
from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.catalog.tasks import whole_number
from gym_extensions.errors import BenchError, require_known
from gym_extensions.submissions.layout import PROGRESS

FIRST_INTERVAL, LONGEST_INTERVAL = 1.0, 60.0
"""Seconds between two lines about training; each interval is twice the one before, up to the longest."""
EPISODE_WORK = 100
"""An episode of evaluation counts as this many training steps, for the time left."""
SPEED_SECONDS = 600.0
"""The time left is estimated from the speed in this time."""
TRAIN_LOG, EVENTS_CSV = "train.log", "events.csv"
EVENT_COLUMNS = ("event", "job", "stage", "step", "job_step", "task", "mean_return", "steps_per_second")
LOGS = ("csv", "tensorboard")
"""The logs that a user can choose."""


class Bars:
    """One bar per running job and one for all, which measure training steps and evaluation episodes.

    Work that an earlier call finished, or that an agent does not need, leaves the total of all jobs, so that
    it does not count as speed.
    """

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._plans: dict[str, events.JobPlan] = {}
        self._rows: dict[str, TaskID] = {}
        self._done: dict[str, int] = {}
        self._episodes = Counter[tuple[str, int]]()
        progress.add_task("all jobs", total=0, text="")
        self._all = progress.tasks[-1]

    def show(self, event: events.Event) -> None:
        if isinstance(event, events.TrainingStarted):
            self._plans = {plan.title: plan for plan in event.jobs}
            self._done = dict.fromkeys(self._plans, 0)
            total = sum(_work(plan) for plan in event.jobs)
            self._progress.reset(self._all.id, total=total, visible=bool(event.jobs))
            return
        plan = self._plans[event.job]
        if isinstance(event, events.JobFinished | events.JobFailed):
            self._move(event.job, _work(plan), is_new=False)
            if event.job in self._rows:
                self._progress.remove_task(self._rows.pop(event.job))
            return
        if event.job not in self._rows:
            self._rows[event.job] = self._progress.add_task(event.job, total=_work(plan), text="")
        done, text = _work(plan, before=event.stage), ""
        if isinstance(event, events.TaskEvaluated):
            self._episodes[event.job, event.stage] += event.episodes
            text = f"{event.task.rpartition('/')[2]} {event.mean_return:.1f}"
        elif isinstance(event, events.BatchTrained):
            mean_return = "" if event.mean_return is None else f"return {event.mean_return:.1f}, "
            text = f"{mean_return}{event.steps_per_second:,.0f} steps/s"
        if isinstance(event, events.BatchTrained | events.TaskEvaluated):
            done += event.step + EPISODE_WORK * self._episodes[event.job, event.stage]
        self._move(event.job, done, is_new=not isinstance(event, events.StageStarted))
        row, description = self._rows[event.job], f"{event.job} stage {event.stage}"
        self._progress.update(row, completed=done, description=description, text=text)

    def time_left(self) -> str:
        """Until all jobs are finished, such as ``1:02:03``; ``unknown`` before it can be estimated."""
        return clock_time(self._all.time_remaining)

    def _move(self, job: str, done: int, *, is_new: bool) -> None:
        step, self._done[job] = done - self._done[job], done
        if is_new:
            self._progress.advance(self._all.id, step)
        else:
            self._progress.update(self._all.id, total=(self._all.total or 0) - step)


def _work(plan: events.JobPlan, before: int | None = None) -> int:
    """The work of the stages of a job, or of those before a stage."""
    stages = [stage for stage in plan.stages if before is None or stage.number < before]
    return sum(stage.steps + EPISODE_WORK * stage.episodes for stage in stages)


@dataclass
class Lines:
    """Prints lines: the end of every stage, and training at growing intervals."""

    write: Callable[[str], object]
    time_left: Callable[[], str]
    clock: Callable[[], float] = time.monotonic
    _interval: float = FIRST_INTERVAL
    _next: float = 0.0

    def show(self, event: events.Event) -> None:
        """Prints a line, unless the event is about training and the last such line is too recent."""
        if isinstance(event, events.StageStarted | events.JobFinished):
            return
        is_evaluation = isinstance(event, events.TaskEvaluated) and event.in_training
        if is_evaluation or isinstance(event, events.BatchTrained):
            now = self.clock()
            if now < self._next:
                return
            self._next = now + self._interval
            self._interval = min(2 * self._interval, LONGEST_INTERVAL)
        self.write(line(event, self.time_left()))


def line(event: events.Event, time_left: str) -> str:
    """One line about an event."""
    if isinstance(event, events.TrainingStarted):
        stages = [stage for job in event.jobs for stage in job.stages]
        steps, episodes = sum(stage.steps for stage in stages), sum(stage.episodes for stage in stages)
        jobs = "1 job" if len(event.jobs) == 1 else f"{len(event.jobs)} jobs"
        plan = f"{jobs}: {steps:,} training steps, {episodes:,} evaluation episodes"
        return plan if event.jobs else "Nothing to train: all runs are finished."
    if isinstance(event, events.JobFinished | events.JobFailed):
        ending = f"failed: {event.cause}" if isinstance(event, events.JobFailed) else "finished"
        return f"{event.job}: {ending}"
    where = f"{event.job} stage {event.stage}"
    if isinstance(event, events.StageStarted):
        tasks = ", ".join(event.tasks) if event.tasks else "no task"
        return f"{where}: trains {event.steps:,} steps on {tasks}"
    if isinstance(event, events.BatchTrained):
        result = "no episode ended" if event.mean_return is None else f"mean return {event.mean_return:.1f}"
        speed = f"{event.steps_per_second:,.0f} steps per second"
        return f"{where}: {event.step:,} steps, {result}, {speed}, time left {time_left}"
    during = f" after {event.step:,} steps" if event.in_training else ""
    return f"{where}{during}: {event.task} mean return {event.mean_return:.1f}"


def clock_time(seconds: float | None) -> str:
    """Hours, minutes and seconds, such as ``1:02:03``; ``unknown`` without a number."""
    if seconds is None:
        return "unknown"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{rest:02}"


def log_file(folder: Path, time_left: Callable[[], str]) -> events.Listener:
    """Appends a line per event with date and local time, and tracebacks of failed jobs, to ``train.log``."""

    def listen(event: events.Event) -> None:
        if isinstance(event, events.TrainingStarted):
            if not event.jobs:
                return
            folder.mkdir(parents=True, exist_ok=True)
        with (folder / TRAIN_LOG).open("a", encoding="utf-8", newline="\n") as file:
            file.write(f"{time.strftime('%Y-%m-%d %H:%M:%S')} {line(event, time_left())}\n")
            if isinstance(event, events.JobFailed):
                file.write(event.traceback)

    return listen


def csv_file(folder: Path) -> events.Listener:
    """Appends a row per batch (event ``batch``) and evaluated task (``evaluation``) to ``events.csv``.

    Steps are counted since the stage began (``step``) and since the job began (``job_step``). ``mean_return``
    is empty if no training episode ended.
    """
    path = folder / EVENTS_CSV

    def listen(event: events.Event) -> None:
        if isinstance(event, events.BatchTrained):
            kind, task, speed = "batch", "", str(round(event.steps_per_second, 1))
        elif isinstance(event, events.TaskEvaluated):
            kind, task, speed = "evaluation", event.task, ""
        else:
            return
        where, is_new = (event.job, event.stage, event.step, event.job_step), not path.exists()
        with path.open("a", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            if is_new:
                writer.writerow(EVENT_COLUMNS)
            writer.writerow((kind, *where, task, event.mean_return, speed))  # None is an empty cell

    return listen


class TensorBoard:
    """One folder of scalars per job, ``tensorboard/<group>/<job>``, over the training steps of the job.

    The scalars are ``train/mean_return``, ``train/steps_per_second`` and, per task,
    ``evaluation/<task name>``.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder / "tensorboard"
        self._writers: dict[str, Any] = {}

    def __call__(self, event: events.Event) -> None:
        """Adds the scalars of a batch or an evaluated task."""
        if isinstance(event, events.BatchTrained):
            self._add(event, "train/steps_per_second", event.steps_per_second)
            if event.mean_return is not None:
                self._add(event, "train/mean_return", event.mean_return)
        elif isinstance(event, events.TaskEvaluated):
            self._add(event, f"evaluation/{event.task.rpartition('/')[2]}", event.mean_return)
        elif isinstance(event, events.JobFinished | events.JobFailed) and event.job in self._writers:
            self._writers.pop(event.job).close()

    def close(self) -> None:
        for writer in self._writers.values():
            writer.close()

    def _add(self, event: events.BatchTrained | events.TaskEvaluated, tag: str, scalar: float) -> None:
        from tensorboard.compat.proto import event_pb2, summary_pb2
        from tensorboard.summary.writer.event_file_writer import EventFileWriter

        if event.job not in self._writers:
            folder = self._folder.joinpath(*event.job.split())
            self._writers[event.job] = EventFileWriter(str(folder), flush_secs=10)
        summary = summary_pb2.Summary(value=[summary_pb2.Summary.Value(tag=tag, simple_value=scalar)])
        row = event_pb2.Event(wall_time=time.time(), step=event.job_step, summary=summary)
        self._writers[event.job].add_event(row)


@contextmanager
def open_bars(*, is_shown: bool = True) -> Iterator[tuple[Bars, events.Listener]]:
    """Bars, which are shown in a terminal, and a listener that moves them; it prints lines elsewhere."""
    console = Console()
    texts = ("{task.percentage:>3.0f}%", "{task.fields[text]}")
    columns = ("{task.description}", BarColumn(10), *texts, TimeElapsedColumn(), TimeRemainingColumn())
    is_live = is_shown and console.is_terminal and not console.is_jupyter
    progress = Progress(*columns, console=console, disable=not is_live, speed_estimate_period=SPEED_SECONDS)
    with progress if is_live else nullcontext():
        bars = Bars(progress)
        lines = Lines(print, bars.time_left)

        def show(event: events.Event) -> None:
            bars.show(event)
            if is_live and isinstance(event, events.JobFailed):
                console.out(line(event, ""), highlight=False)
            elif is_shown and not is_live:
                lines.show(event)

        yield bars, show


@dataclass(frozen=True)
class Monitor:
    """What is shown, logged and evaluated while training goes on.

    Args:
        progress: whether to show training return, steps per second and time left: bars in a terminal, lines
            elsewhere. The file ``.progress/train.log`` of the submission has them in any case.
        log: ``"csv"`` (``.progress/events.csv``), ``"tensorboard"`` (``.progress/tensorboard``; needs the
            extra ``log``), or both.
        callback: called in the process that called ``train`` with every event:
            :class:`~gym_extensions.baselines.TrainingStarted`, ``StageStarted``, ``BatchTrained``,
            ``TaskEvaluated``, ``JobFinished``, ``JobFailed``. An exception stops the training.
        evaluate_every: training steps of a stage between evaluations during training, which are made at the
            end of a batch, on the tasks that are evaluated after the stage. None evaluates after each stage
            only. Neither what is learned nor the logs depend on it if the agent can be saved; docs/submit.md
            says what is guaranteed for other agents.
        evaluate_episodes: episodes per task of these evaluations, from 1 to 20.

    Raises ``BenchError`` for an unknown log, a missing extra, or a number out of range.

    Example:
        >>> Monitor(log="csv", evaluate_every=10_000).interim
        Interim(every=10000, episodes=5)
    """

    progress: bool = True
    log: str | Iterable[str] | None = None
    callback: events.Listener | None = None
    evaluate_every: int | None = None
    evaluate_episodes: int = 5

    def __post_init__(self) -> None:
        log = () if self.log is None else tuple(dict.fromkeys(listed(self.log, str, "log", "a name")))
        object.__setattr__(self, "log", log)
        for name in log:
            require_known("log", name, LOGS, "log")
        if "tensorboard" in log and find_spec("tensorboard") is None:
            hint = "Install it with: pip install 'gym-extensions[log]'"
            raise BenchError("missing-extra", "The log 'tensorboard' needs tensorboard.", "log", hint)
        for name in ("evaluate_every", "evaluate_episodes"):
            dashed, value = name.replace("_", "-"), getattr(self, name)
            if name == "evaluate_episodes" or value is not None:
                object.__setattr__(self, name, whole_number(name, value, f"bad-{dashed}", f"--{dashed}"))
        if self.evaluate_episodes > EVALUATION_EPISODES:
            message = f"{self.evaluate_episodes} is too large."
            hint = f"Use at most {EVALUATION_EPISODES}, the episodes that have a prescribed seed."
            raise BenchError("bad-evaluate-episodes", message, "--evaluate-episodes", hint)

    @property
    def interim(self) -> Interim | None:
        """The evaluation during training; None without one."""
        return None if self.evaluate_every is None else Interim(self.evaluate_every, self.evaluate_episodes)

    @contextmanager
    def listening(self, out: Path) -> Iterator[events.Listener]:
        """The listener of one call of ``train``, which also writes the log files in ``out/.progress``."""
        folder, board = out / PROGRESS, TensorBoard(out / PROGRESS)
        with open_bars(is_shown=self.progress) as (bars, show), closing(board):
            files: dict[str, events.Listener] = {"csv": csv_file(folder), "tensorboard": board}
            writers = [log_file(folder, bars.time_left), *(files[name] for name in self.log or ())]
            failing: list[events.Listener] = []

            def listen(event: events.Event) -> None:
                show(event)
                for write in writers:
                    try:
                        write(event)
                    except OSError as error:  # one warning, and the training goes on
                        if write not in failing:
                            failing.append(write)
                            reason = error.strerror or type(error).__name__
                            message = f"A log of the training cannot be written: {reason}."
                            warnings.warn(f"{message} The training continues.", RuntimeWarning, stacklevel=2)
                if self.callback is None:
                    return
                try:
                    self.callback(event)
                except Exception as error:
                    message = f"The callback raised {type(error).__name__}: {error}".rstrip(".") + "."
                    hint = f"Correct the callback. {CONTINUES}"
                    raise BenchError("callback-failed", message, "callback", hint) from error

            yield listen
