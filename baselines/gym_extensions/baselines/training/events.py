"""Events of training, which jobs in any process send to one listener."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class StagePlan:
    """The work of a stage: training steps, and episodes of evaluation during and after training."""

    number: int
    steps: int
    episodes: int


@dataclass(frozen=True)
class JobPlan:
    """The work of a job.

    A job trains one agent in one run of a protocol; its title is unique, for example
    ``hopper-gravity sequential-run0``.
    """

    title: str
    stages: tuple[StagePlan, ...]


@dataclass(frozen=True)
class TrainingStarted:
    """The first event.

    Args:
        jobs: the work; stages that an earlier call finished are included.
        processes: number of jobs that run at the same time.
    """

    jobs: tuple[JobPlan, ...]
    processes: int = 1


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
    """

    job: str
    cause: str
    traceback: str = ""


Event = TrainingStarted | StageStarted | BatchTrained | TaskEvaluated | JobFinished | JobFailed
Listener = Callable[[Event], object]
"""Called with every event in the process that called ``train``."""
