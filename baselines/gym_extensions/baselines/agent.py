"""What the loop asks of an agent: two methods, and three more that it may have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
VectorEnv = gym.vector.VectorEnv[Any, Any, Any]
Setting = str | int | float | bool | list[str] | list[int] | list[float] | list[bool]


class Agent(Protocol):
    """Any learner. Its randomness for acting and for learning comes from two generators of its own.

    Optional: ``save(path)`` and ``load(path)`` (:class:`Resumable`) and ``card()`` (:class:`Described`).
    """

    def act(self, observations: Array) -> Array:
        """Actions (lanes, …) for observations (lanes, …); changes nothing that is learned."""

    def learn(self, env: VectorEnv, steps: int) -> object:
        """Goes on learning from the present policy for ``steps`` transitions of ``env``.

        ``env`` is a Gymnasium vector environment in autoreset mode NEXT_STEP: the step after an episode's
        end resets that lane, ignores its action and is no transition. ``env.batch_steps`` is the batch that
        the budget prescribes to the reference agents; another agent may choose its own.
        """


@runtime_checkable
class Resumable(Protocol):
    """An agent whose stopped run goes on at the last finished stage: all that it is, generators included."""

    def save(self, path: Path) -> object:
        """Writes the whole agent to ``path`` as npz arrays, without pickle."""

    def load(self, path: Path) -> object:
        """Becomes the agent that was saved."""


@dataclass(frozen=True)
class Card:
    """What a submission's manifest says about its agent."""

    algorithm: str
    title: str = ""
    description: str = ""
    evaluation: str = "sampled"
    hyperparameters: Mapping[str, Setting] = field(default_factory=dict)
    task_in_training: bool = False
    task_in_evaluation: bool = False
    boundaries: bool = False
    stored_steps: int = 0
    parameters: int = 0


@runtime_checkable
class Described(Protocol):
    """An agent that tells the manifest about itself."""

    def card(self) -> Card:
        """The agent as it is now."""


class Factory(Protocol):
    """Makes an untrained agent."""

    def __call__(
        self, observation_space: gym.Space[Any], action_space: gym.Space[Any], seed: int, /
    ) -> Agent: ...


def acting_and_learning(seed: int) -> tuple[np.random.Generator, np.random.Generator]:
    """Two independent generators from one seed, so that evaluation leaves training untouched."""
    acting, learning = np.random.SeedSequence(seed).spawn(2)
    return np.random.default_rng(acting), np.random.default_rng(learning)
