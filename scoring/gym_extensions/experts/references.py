"""The files of references: of every task the floor, and the expert whose mean return is the score 1."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import msgspec

REFERENCES = Path(__file__).parents[1] / "scoring" / "references_data"
"""Holds a file per benchmark version."""
CURRENT = "2"
"""The benchmark version whose references normalize every score."""


class FloorAgent(msgspec.Struct, omit_defaults=True):
    """Returns of an agent that ignores observations: mean, population standard deviation, and its seed."""

    mean: float
    std: float = 0.0
    standard_error: float = 0.0
    seed: int = 0


class Floor(msgspec.Struct, omit_defaults=True):
    """The better one of two agents that ignore observations, over ``episodes`` prescribed episodes each."""

    mean: float
    agent: str = ""
    episodes: int = 0
    standard_error: float = 0.0
    agents: dict[str, FloorAgent] = {}
    fingerprint: str = ""


class Run(msgspec.Struct, omit_defaults=True):
    """The mean return of one training run; in version 1 with more."""

    run: int
    mean: float
    std: float = 0.0
    beats_floor: bool = True


class Expert(msgspec.Struct, omit_defaults=True):
    """What the score 1 stands for; in version 1 it was called the ceiling.

    Args:
        standard_error: of the mean, over the runs if there are several, else over the episodes.
        episodes: number of episodes (of each run).
        agent: who acts: ``expert``, a published policy with its SHA-256; ``planner``; or the agent of runs.
        provisional: why it does not do what the task is for.
    """

    mean: float
    standard_error: float = 0.0
    episodes: int = 0
    agent: str = ""
    policy: str = ""
    provisional: str = ""
    budget: str = ""
    runs: list[Run] = []

    @property
    def df(self) -> float:
        """Degrees of freedom of the standard error."""
        return float(max((len(self.runs) if len(self.runs) > 1 else self.episodes) - 1, 0))


class Task(msgspec.Struct):
    """A task's floor and expert. An open task has no expert; its attempts did not beat the floor clearly."""

    floor: Floor
    expert: Expert | None
    attempts: Expert | msgspec.UnsetType | None = msgspec.UNSET


class File(msgspec.Struct):
    """A references file."""

    format: Literal[2]
    version: str
    tasks: dict[str, Task]


def parse_file(data: bytes) -> File:
    """The content of a references file. Raises ``ValueError`` for another format.

    In format 1, that of version 1, experts are called ceilings.
    """
    content = msgspec.json.decode(data, type=dict[str, Any])
    if content.get("format") == 1:
        tasks = msgspec.convert(content.get("tasks"), dict[str, dict[str, Any]])
        experts = {name: {**task, "expert": task.get("ceiling")} for name, task in tasks.items()}
        content |= {"format": 2, "tasks": experts}
    return msgspec.convert(content, File)
