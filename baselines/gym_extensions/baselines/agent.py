"""The interface between an agent and the training loop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from gym_extensions.baselines.context import Context as Context  # noqa: PLC0414  (exported)
from gym_extensions.baselines.context import Observes as Observes  # noqa: PLC0414  (exported)
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies import Policy

Array = NDArray[Any]
VectorEnv = gym.vector.VectorEnv[Any, Any, Any]
Setting = str | int | float | bool | list[str] | list[int] | list[float] | list[bool]
"""A hyperparameter as ``submission.toml`` stores it."""


class Agent(Protocol):
    """A learning algorithm. :class:`Resumable`, :class:`Described` and :class:`HasPolicy` are optional.

    An agent that observes more than observations and rewards has an attribute ``observes``, an
    :class:`Observes`. What it does not ask for there is refused.

    An agent that samples should use separate random generators for acting and learning, so that evaluation
    does not change what is learned.

    Example:
        >>> class Constant:
        ...     def __init__(self, observation_space, action_space, seed):
        ...         self.action = action_space.high
        ...
        ...     def act(self, observations):
        ...         return np.tile(self.action, (len(observations), 1))
        ...
        ...     def learn(self, env, steps):
        ...         pass
    """

    def act(self, observations: Array, *args: Any, **kwargs: Any) -> Array:
        """Chooses one action per environment. It must not change what the agent has learned.

        An agent defines ``act(observations)`` or ``act(observations, context)``. The second form receives a
        :class:`Context` in each call.

        Args:
            observations: (num_envs, …).
            args: the context, if the agent's ``act`` has a second parameter.
            kwargs: the context, if that parameter is keyword-only.

        Returns:
            Actions (num_envs, …). Actions outside the action space are clipped.
        """

    def learn(self, env: VectorEnv, steps: int) -> object:
        """Continues training from the current policy.

        Args:
            env: a Gymnasium vector environment in autoreset mode NEXT_STEP: the step after the end of an
                episode resets that environment, ignores its action and is not a transition.
                ``env.batch_steps`` is the batch size of the reference agents; other agents may ignore it.
                ``env.budget_steps`` equals ``steps``. Agents that ask for ``task_in_training`` can read
                ``env.task_ids`` (the tasks that are trained, in order), ``env.env_task_ids`` (one per
                environment) and ``env.env_tasks``, their indices in the training order of the group. Agents
                that ask for ``boundaries`` can read ``env.stage``, from 1, and ``env.num_tasks``.
            steps: transitions to take, summed over all environments; at most 2 % more are allowed.
        """


@runtime_checkable
class Resumable(Protocol):
    """An agent that can be checkpointed, so an interrupted run resumes after its last finished stage.

    A checkpoint holds the whole agent, random generators included.
    """

    def save(self, path: Path) -> object:
        """Writes the agent to ``path`` as arrays without pickle."""

    def load(self, path: Path) -> object:
        """Restores the agent that was saved to ``path``."""


@runtime_checkable
class HasPolicy(Protocol):
    """An agent whose policy is stored after every stage, and published in the submission.

    Example:
        >>> from gym_extensions.rollouts.policies import Policy
        >>> class Constant:
        ...     def policy(self):
        ...         return Policy(action_offset=np.ones(3), action_scale=np.ones(3))
        >>> isinstance(Constant(), HasPolicy)
        True
    """

    def policy(self) -> Policy | None:
        """The policy as plain arrays, which acts as ``act`` does; None if it cannot be expressed so."""


@dataclass(frozen=True)
class Card:
    """What a submission's manifest says about its agent.

    Args:
        algorithm: a short name of at most 100 characters.
        title: the heading of the entry; ``algorithm`` if empty.
        description: at most 4000 characters.
        evaluation: how the agent acts in evaluation, ``"sampled"`` or ``"deterministic"``.
        hyperparameters: strings, finite numbers, booleans, or lists of them, by name.
        tuning_steps: training steps spent on choosing the hyperparameters, over all trials.
        tuning_tasks: names of the tasks of these trials.
        stored_steps: the largest number of transitions that the agent stores.
        parameters: the number of the agent's trained parameters.
        packages: names of the packages, besides Gymnasium, MuJoCo and NumPy, on which the results depend,
            such as ``"torch"``. The manifest states their versions.

    Example:
        >>> Card("hill climbing", evaluation="deterministic", parameters=33).algorithm
        'hill climbing'
    """

    algorithm: str
    title: str = ""
    description: str = ""
    evaluation: str = "sampled"
    hyperparameters: Mapping[str, Setting] = field(default_factory=dict)
    tuning_steps: int = 0
    tuning_tasks: tuple[str, ...] = ()
    stored_steps: int = 0
    parameters: int = 0
    packages: tuple[str, ...] = ()

    def __new__(cls, *_: object, **values: object) -> Card:
        """Raises ``BenchError`` for fields that are now in the agent's attribute ``observes``."""
        for name in (item.name for item in fields(Observes) if item.name in values):
            hint = f"If the agent observes it, give its class the attribute observes = Observes({name}=True)."
            raise BenchError("bad-card", f"A card does not have the field {name!r}.", "Card()", hint)
        return super().__new__(cls)


@runtime_checkable
class Described(Protocol):
    """An agent that describes itself in the manifest."""

    def card(self) -> Card:
        """The description of the agent in its current state."""


class Factory(Protocol):
    """Creates untrained agents.

    An agent's class is a factory, and so is any function with these three arguments.
    """

    def __call__(self, observation_space: Any, action_space: Any, seed: int, /) -> Agent:
        """Creates an untrained agent.

        Args:
            observation_space: the Gymnasium space of one environment's observations.
            action_space: the Gymnasium space of one environment's actions.
            seed: the source of all the agent's randomness.

        Returns:
            The agent.
        """


def acting_and_learning(seed: int) -> tuple[np.random.Generator, np.random.Generator]:
    """Two independent generators from one seed, so that evaluation leaves training untouched."""
    acting, learning = np.random.SeedSequence(seed).spawn(2)
    return np.random.default_rng(acting), np.random.default_rng(learning)
