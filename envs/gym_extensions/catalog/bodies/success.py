"""The conditions under which a task counts as solved at a step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

IS_SUCCESS = "is_success"
"""The key of a step's info. In vector infos, ``_is_success`` marks the environments that report it."""


@dataclass(frozen=True)
class Arrival:
    """The step terminates the episode."""

    text: str


@dataclass(frozen=True)
class Distance:
    """The centers of two bodies of the model are at most ``limit`` m apart in the x–y plane."""

    bodies: tuple[str, str]
    limit: float
    text: str


@dataclass(frozen=True)
class Height:
    """The height of the free root is between ``low`` and ``high`` m, exclusive."""

    low: float
    high: float
    text: str


Success: TypeAlias = Arrival | Distance | Height
"""When ``info["is_success"]`` is true after a step. An episode is a success if its last step is.

``text`` is the sentence in the documentation. A body's success is part of its tasks: a change needs a new
version of each of them, although fingerprints do not contain it.
"""
