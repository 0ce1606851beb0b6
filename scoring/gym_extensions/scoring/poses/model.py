"""The document of an entry's poses on one group, as it is written and as pages read it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from gym_extensions.errors import BenchError
from gym_extensions.scoring.documents import JsonDocument, about
from gym_extensions.scoring.poses import vlq

RATE = 15.0
"""Frames per second."""
MAX_SECONDS = 10.0
"""Longest part of an episode that is shown."""
MAX_PATH_POINTS = 250
"""Most points of a path in 2-D navigation, which has no seconds."""
BODY_UNIT, MAP_UNIT = 0.01, 0.1
"""Resolution of coordinates: in m and rad for bodies, in units of the map for navigation."""
MAX_DIFFERENCE = 0.01
"""Returns are rounded to two digits; their mean may differ from that of a scorecard by this."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Clip:
    """The motion of an audited episode."""

    stage: Annotated[int, about("stage of the evaluation, from 1")]
    episode: Annotated[int, about("number of the episode in its cell, 0 to 19")]
    steps: Annotated[int, about("length of the whole episode in steps")]
    success: Annotated[bool | None, about("`is_success` of the last step; null where undefined")]
    returns: Annotated[tuple[float, ...], about("returns of all episodes of the cell, two digits")]
    frames: Annotated[int, about("number of frames")]
    motion: Annotated[
        str,
        about(
            "base64 VLQ of each coordinate in turn: its first value, then the steps between frames, in `unit`"
        ),
    ]

    def coordinates(self, unit: float) -> NDArray[np.float64]:
        """The coordinates, (frames, n).

        Raises:
            BenchError: the motion is not that of whole frames.
        """
        numbers = vlq.decode(self.motion)
        if self.frames < 1 or len(numbers) % self.frames:
            raise BenchError("bad-motion", f"{len(numbers)} numbers do not make {self.frames} frames.")
        rows = np.array(numbers, np.float64).reshape(-1, self.frames)
        return np.cumsum(rows, axis=1).T * unit


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskPoses:
    """The audited episodes of one task: right after its training and at the end."""

    task: Annotated[str, about("task id")]
    after: Annotated[Clip, about("right after training on the task")]
    end: Annotated[
        Clip | None, about("after the last stage; null for the last task, where both are the same")
    ]
    unit: Annotated[float, about("resolution of the coordinates, m and rad or units of the map")]
    steps_per_second: Annotated[float, about("environment steps per second; 0 in 2-D navigation")]
    steps_per_frame: Annotated[float, about("environment steps between two frames")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Poses(JsonDocument):
    """The motion of one run of an entry on one group."""

    format: Annotated[Literal[1], about("1")] = 1
    submission: Annotated[str, about("name of the submission's folder")]
    group: Annotated[str, about("group id")]
    run: Annotated[int, about("training seed of the run that is shown")]
    tasks: Annotated[tuple[TaskPoses, ...], about("tasks in training order")]

    def shows(self, runs: tuple[int, ...], matrix: tuple[tuple[tuple[float, ...], ...], ...]) -> bool:
        """Whether these episodes belong to the results with these mean returns [run][stage][task].

        False for poses of an earlier log of the entry.
        """
        if self.run not in runs:
            return False
        stages = matrix[runs.index(self.run)]
        if len(self.tasks) + 1 != len(stages):
            return False
        return all(
            abs(math.fsum(clip.returns) / len(clip.returns) - stages[clip.stage][index]) <= MAX_DIFFERENCE
            for index, task in enumerate(self.tasks)
            for clip in (task.after, task.end)
            if clip is not None
        )


def motion_of(coordinates: NDArray[np.float64], unit: float) -> str:
    """The text of coordinates (frames, n): each coordinate's first value, then its differences."""
    whole = np.rint(coordinates.T / unit).astype(np.int64)
    return vlq.encode(np.diff(whole, axis=1, prepend=0).ravel().tolist())
