"""The motion of episodes as small documents in a submission's folder, which pages show. Loads no simulator.

Coordinates are text: whole numbers in base64 digits of variable length, as in source maps. A number is
shifted left by one, with its sign in the lowest bit, and cut into groups of five bits, lowest first; a digit
of 32 or more says that another follows. Small numbers take one character.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from gym_extensions.documents import JsonDocument, about
from gym_extensions.errors import BenchError
from gym_extensions.submissions.layout import POSES

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
    """The motion of an episode."""

    stage: Annotated[int, about("stage of the evaluation, from 1")]
    episode: Annotated[int, about("number of the episode in its cell, 0 to 19")]
    steps: Annotated[int, about("length of the whole episode in steps")]
    success: Annotated[bool | None, about("`is_success` of the last step; null where undefined")]
    returns: Annotated[tuple[float, ...], about("returns of all episodes of the cell, two digits")]
    frames: Annotated[int, about("number of frames")]
    motion: Annotated[str, about("base64 VLQ of each coordinate: its first value, then steps, in `unit`")]

    def coordinates(self, unit: float) -> NDArray[np.float64]:
        """The coordinates, (frames, n). Raises ``BenchError`` if the motion is not that of whole frames."""
        numbers = decode(self.motion)
        if self.frames < 1 or len(numbers) % self.frames:
            raise BenchError("bad-motion", f"{len(numbers)} numbers do not make {self.frames} frames.")
        rows = np.array(numbers, np.float64).reshape(-1, self.frames)
        return np.cumsum(rows, axis=1).T * unit


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskPoses:
    """Episodes of one task: right after its training and at the end."""

    task: Annotated[str, about("task id")]
    after: Annotated[Clip, about("right after training on the task")]
    end: Annotated[Clip | None, about("after the last stage; null for the last task: they are the same")]
    unit: Annotated[float, about("resolution of the coordinates, m and rad or units of the map")]
    steps_per_second: Annotated[float, about("environment steps per second; 0 in 2-D navigation")]
    steps_per_frame: Annotated[float, about("environment steps between two frames")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Poses(JsonDocument):
    """The motion of one run of a submission on one group."""

    format: Annotated[Literal[1], about("1")] = 1
    submission: Annotated[str, about("name of the submission's folder")]
    group: Annotated[str, about("group id")]
    run: Annotated[int, about("training seed of the run that is shown")]
    tasks: Annotated[tuple[TaskPoses, ...], about("tasks in training order")]

    def shows(self, runs: tuple[int, ...], matrix: tuple[tuple[tuple[float, ...], ...], ...]) -> bool:
        """Whether these episodes, and not an earlier log's, have these mean returns [run][stage][task]."""
        stages = matrix[runs.index(self.run)] if self.run in runs else ()
        return len(self.tasks) + 1 == len(stages) and all(
            abs(math.fsum(clip.returns) / len(clip.returns) - stages[clip.stage][index]) <= MAX_DIFFERENCE
            for index, task in enumerate(self.tasks)
            for clip in (task.after, task.end)
            if clip is not None
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PolicyPoses(JsonDocument):
    """The motion of an expert."""

    format: Annotated[Literal[1], about("1")] = 1
    policy: Annotated[str, about("digest of the policy")]
    poses: Annotated[TaskPoses, about("an episode, without `end`")]


def motion_of(coordinates: NDArray[np.float64], unit: float) -> str:
    """The text of coordinates (frames, n): each coordinate's first value, then its differences."""
    whole = np.rint(coordinates.T / unit).astype(np.int64)
    return encode(np.diff(whole, axis=1, prepend=0).ravel().tolist())


def load_submission(submission: Path) -> dict[str, Poses]:
    """The poses in a submission's folder by group id, sorted. Raises ``BenchError`` if one is unreadable."""
    paths = sorted((submission / POSES).glob("*.json"))
    documents = [Poses.load(path, "bad-poses", "gym-extensions maintain poses") for path in paths]
    return {document.group: document for document in documents if document is not None}


DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"
VALUES = {digit: value for value, digit in enumerate(DIGITS)}
MORE, BITS = 32, 5


def encode(numbers: Iterable[int]) -> str:
    """The text of these whole numbers.

    Example:
        >>> encode([0, 1, -1, 16])
        'ACDgB'
    """
    digits = []
    for number in numbers:
        rest = abs(number) << 1 | (number < 0)
        while rest >= MORE:
            digits.append(DIGITS[rest & (MORE - 1) | MORE])
            rest >>= BITS
        digits.append(DIGITS[rest])
    return "".join(digits)


def decode(text: str) -> list[int]:
    """The whole numbers of a text. Raises ``BenchError`` for another character or an incomplete number."""
    numbers, rest, shift = [], 0, 0
    for character in text:
        value = VALUES.get(character)
        if value is None:
            raise BenchError("bad-motion", f"Unexpected character {character!r} in a motion.")
        rest |= (value & (MORE - 1)) << shift
        shift += BITS
        if value < MORE:
            numbers.append(-(rest >> 1) if rest & 1 else rest >> 1)
            rest, shift = 0, 0
    if shift:
        raise BenchError("bad-motion", "The last number of a motion is incomplete.")
    return numbers
