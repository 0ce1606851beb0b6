"""Events of training, which jobs in any process send to one listener, and how they are shown and logged."""

import math
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TimeElapsedColumn

from gym_extensions.baselines.training.checkpoints import CONTINUES
from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.errors import BenchError, whole_number
from gym_extensions.submissions.layout import PROGRESS

LINE_SECONDS = 10.0
"""At least this long between two lines about training."""
FIRST_SECONDS = 30.0
"""The time left is estimated after training for this long: an agent may be faster before it learns."""
TRAIN_LOG = "train.log"


@dataclass(frozen=True)
class TrainingStarted:
    """The first event.

    A job trains one agent in one run of a protocol; its title is unique, for example
    ``hopper-gravity sequential-run0``.

    Args:
        jobs: the training steps of each job by its title; stages that an earlier call finished are included.
    """

    jobs: Mapping[str, int]


@dataclass(frozen=True)
class StageStarted:
    """A job starts a stage. Stage 0 trains nothing.

    Args:
        job: the job's title.
        stage: the number of the stage.
        tasks: the ids of the tasks in training.
        steps: training steps of the stage.
    """

    job: str
    stage: int
    tasks: tuple[str, ...]
    steps: int


@dataclass(frozen=True)
class StageEvent:
    """Something that happened in a stage.

    Args:
        job: the job's title.
        stage: the number of the stage.
        step: training steps since the stage began.
        job_step: training steps since the job began.
    """

    job: str
    stage: int
    step: int
    job_step: int


@dataclass(frozen=True)
class BatchTrained(StageEvent):
    """A job trained for a batch of the budget.

    Args:
        mean_return: of the training episodes that ended since the previous event; None if none ended.
        steps_per_second: training steps per second since the previous event.
        seconds: since the previous event, without evaluation.
    """

    mean_return: float | None
    steps_per_second: float
    seconds: float


@dataclass(frozen=True)
class StepsTrained(StageEvent):
    """A job trains, and a batch of the budget takes it longer than ten seconds.

    Args:
        steps_per_second: training steps per second since the previous ``BatchTrained``.
    """

    steps_per_second: float


@dataclass(frozen=True)
class TaskEvaluated(StageEvent):
    """A job evaluated its agent on a task, at the end of a stage or during training.

    Args:
        task: the id of the task.
        episodes: number of episodes.
        mean_return: over the episodes.
        seconds: that the evaluation took.
        in_training: whether the stage goes on; False at its end.
    """

    task: str
    episodes: int
    mean_return: float
    seconds: float
    in_training: bool = False


@dataclass(frozen=True)
class JobFinished:
    """A job finished all its stages; they are stored."""

    job: str


@dataclass(frozen=True)
class JobFailed:
    """A job ended with an error; its finished stages are stored. The other jobs go on.

    Args:
        job: the job's title.
        cause: the error in one sentence.
        traceback: the text of the traceback; empty if there is none.
        code: of the ``BenchError``; empty for another error.
    """

    job: str
    cause: str
    traceback: str = ""
    code: str = ""


Event = TrainingStarted | StageStarted | BatchTrained | StepsTrained | TaskEvaluated | JobFinished | JobFailed
Listener = Callable[[Event], object]
"""Called with every event in the process that called ``train``."""


class Bars:
    """One bar per running job and one for all, which measure training steps, and the time left.

    The time left is that of the steps that are left, at the pace of all jobs since the first event. So it has
    their evaluations. What an earlier call did does not count.
    """

    def __init__(self, progress: Progress, clock: Callable[[], float] = time.monotonic) -> None:
        self._progress, self._clock = progress, clock
        self._steps: Mapping[str, int] = {}  # of each job
        self._done: dict[str, int] = {}  # steps of each job that has begun
        self._trained, self._started = 0, clock()  # steps since the first event, and its time
        self._rows: dict[str, TaskID] = {}
        self._all = progress.add_task("all jobs", total=0, text="", left="")

    def show(self, event: Event) -> None:
        bars = self._progress
        if isinstance(event, TrainingStarted):
            self._steps, self._started = event.jobs, self._clock()
            bars.reset(self._all, total=sum(event.jobs.values()), visible=bool(event.jobs))
            return
        if isinstance(event, JobFinished | JobFailed):
            self._done[event.job] = self._steps[event.job]
            if event.job in self._rows:
                bars.remove_task(self._rows.pop(event.job))
        else:
            text = ""
            if isinstance(event, StageEvent):
                # The first event may follow stages that an earlier call finished. Evaluations count: they end
                # the stage of an agent that takes no steps, because it learns from stored ones.
                self._trained += event.job_step - self._done.get(event.job, event.job_step - event.step)
                self._done[event.job] = event.job_step
            if isinstance(event, TaskEvaluated):
                text = f"{event.task.rpartition('/')[2]} {event.mean_return:.1f}"
            elif isinstance(event, BatchTrained | StepsTrained):
                if isinstance(event, BatchTrained) and event.mean_return is not None:
                    text = f"return {event.mean_return:.1f}, "
                text += f"{_speed(event.steps_per_second)} steps/s"
            if event.job not in self._rows:
                self._rows[event.job] = bars.add_task(event.job, total=self._steps[event.job])
            done, description = self._done.get(event.job, 0), f"{event.job} stage {event.stage}"
            bars.update(self._rows[event.job], completed=done, description=description, text=text, left="")
        bars.update(self._all, completed=sum(self._done.values()), left=self.time_left())

    def time_left(self) -> str:
        """Until all jobs are trained, such as ``1:02:03``; ``unknown`` before it can be estimated."""
        seconds = self._clock() - self._started
        if not self._trained or seconds < FIRST_SECONDS:
            return "unknown"
        left = sum(self._steps.values()) - sum(self._done.values())
        return str(timedelta(seconds=round(seconds / self._trained * left)))


def printer(
    write: Callable[[str], object], time_left: Callable[[], str], clock: Callable[[], float] = time.monotonic
) -> Listener:
    """Writes the end of every stage, and training at most every ``LINE_SECONDS``."""
    last = -math.inf

    def show(event: Event) -> None:
        nonlocal last
        if isinstance(event, StageStarted | JobFinished):
            return
        is_interim = isinstance(event, TaskEvaluated) and event.in_training
        if isinstance(event, BatchTrained | StepsTrained) or is_interim:
            if clock() < last + LINE_SECONDS:
                return
            last = clock()
        ending = f", time left {time_left()}" if isinstance(event, BatchTrained | StepsTrained) else ""
        write(line(event) + ending)

    return show


def line(event: Event) -> str:
    """One line about an event."""
    if isinstance(event, TrainingStarted):
        jobs = "1 job" if len(event.jobs) == 1 else f"{len(event.jobs)} jobs"
        plan = f"{jobs}: {sum(event.jobs.values()):,} training steps"
        return plan if event.jobs else "Nothing to train: all runs are finished."
    if isinstance(event, JobFinished | JobFailed):
        ending = f"failed: {event.cause}" if isinstance(event, JobFailed) else "finished"
        return f"{event.job}: {ending}"
    where = f"{event.job} stage {event.stage}"
    if isinstance(event, StageStarted):
        tasks = ", ".join(event.tasks) if event.tasks else "no task"
        return f"{where}: trains {event.steps:,} steps on {tasks}"
    if isinstance(event, BatchTrained | StepsTrained):
        result = ""
        if isinstance(event, BatchTrained):
            ended = event.mean_return is not None
            result = f"mean return {event.mean_return:.1f}, " if ended else "no episode ended, "
        return f"{where}: {event.step:,} steps, {result}{_speed(event.steps_per_second)} steps per second"
    during = f" after {event.step:,} steps" if event.in_training else ""
    return f"{where}{during}: {event.task} mean return {event.mean_return:.1f}"


def _speed(steps_per_second: float) -> str:
    return f"{steps_per_second:,.0f}" if steps_per_second >= 10 else f"{steps_per_second:.2g}"


@contextmanager
def open_bars(*, is_shown: bool = True) -> Iterator[Listener]:
    """A listener that moves bars, which are shown in a terminal; it prints lines elsewhere."""
    console = Console()
    texts = ("{task.percentage:>3.0f}%", "{task.fields[text]}")
    columns = ("{task.description}", BarColumn(10), *texts, TimeElapsedColumn(), "{task.fields[left]}")
    is_live = is_shown and console.is_terminal and not console.is_jupyter
    progress = Progress(*columns, console=console, disable=not is_live)
    with progress if is_live else nullcontext():
        bars = Bars(progress)
        show_line = printer(print, bars.time_left)

        def show(event: Event) -> None:
            bars.show(event)
            if is_live and isinstance(event, JobFailed):
                console.out(line(event), highlight=False)
            elif is_shown and not is_live:
                show_line(event)

        yield show


@dataclass(frozen=True)
class Monitor:
    """What is shown, logged and evaluated while training goes on.

    Args:
        progress: whether to show training return, steps per second and time left: bars in a terminal, lines
            elsewhere. The file ``.progress/train.log`` of the submission has them in any case.
        callback: called in the process that called ``train`` with every event:
            :class:`~gym_extensions.baselines.TrainingStarted`, ``StageStarted``, ``BatchTrained``,
            ``StepsTrained``, ``TaskEvaluated``, ``JobFinished``, ``JobFailed``. An exception stops it.
        evaluate_every: training steps of a stage between evaluations during training, which are made at the
            end of a batch, on the tasks that are evaluated after the stage. None evaluates after each stage
            only. Neither what is learned nor the logs depend on it if the agent can be saved; docs/agents.md
            says what is guaranteed for other agents.
        evaluate_episodes: episodes per task of these evaluations, from 1 to 20.

    Raises ``BenchError`` for a number out of range.

    Example:
        >>> Monitor(evaluate_every=10_000).evaluate_episodes
        5
    """

    progress: bool = True
    callback: Listener | None = None
    evaluate_every: int | None = None
    evaluate_episodes: int = 5

    def __post_init__(self) -> None:
        for name in ("evaluate_every", "evaluate_episodes"):
            dashed, value = name.replace("_", "-"), getattr(self, name)
            if name == "evaluate_episodes" or value is not None:
                object.__setattr__(self, name, whole_number(name, value, f"bad-{dashed}", f"--{dashed}"))
        if self.evaluate_episodes > EVALUATION_EPISODES:
            message = f"{self.evaluate_episodes} is too large."
            hint = f"Use at most {EVALUATION_EPISODES}, the episodes that have a prescribed seed."
            raise BenchError("bad-evaluate-episodes", message, "--evaluate-episodes", hint)

    @contextmanager
    def listening(self, out: Path) -> Iterator[Listener]:
        """The listener of one call of ``train``, which also writes ``train.log`` in ``out/.progress``."""
        path, is_writable = out / PROGRESS / TRAIN_LOG, True
        with open_bars(is_shown=self.progress) as show:

            def listen(event: Event) -> None:
                nonlocal is_writable
                show(event)
                row = f"{time.strftime('%Y-%m-%d %H:%M:%S')} {line(event)}\n"
                row += event.traceback if isinstance(event, JobFailed) else ""
                try:
                    if is_writable and not (isinstance(event, TrainingStarted) and not event.jobs):
                        path.parent.mkdir(parents=True, exist_ok=True)
                        with path.open("a", encoding="utf-8", newline="\n") as file:
                            file.write(row)
                except OSError as error:  # one warning, and the training goes on
                    is_writable = False
                    message = f"{TRAIN_LOG} cannot be written: {error.strerror or type(error).__name__}."
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
