"""Progress events, which jobs in any process send to one listener."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Event:
    """The progress of a job: steps trained in a stage, or one evaluated task.

    Args:
        job: the job's title.
        stage: the number of the stage.
        steps: transitions taken in the stage.
        task: the id of the task that was evaluated; empty while the agent trains.
        mean_return: over the evaluation episodes of the task.
    """

    job: str
    stage: int
    steps: int
    task: str = ""
    mean_return: float = 0.0


Listener = Callable[[Event], object]
