"""A policy of the user behind the interface of an agent."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NoReturn, Protocol, runtime_checkable

import numpy as np

from gym_extensions.baselines.agent import Array, Card, Context, Observes, VectorEnv
from gym_extensions.baselines.context_checks import action_function
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies import Policy as PlainPolicy

POLICY_ERRORS = (ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError)
"""What a policy raises for observations of another shape or type."""
SIGNATURE = "Use a function from observations (n, …) to actions (n, …)"


@runtime_checkable
class Acts(Protocol):
    """An agent."""

    def act(self, observations: Array, /) -> Array:
        """Actions (n, …) for observations (n, …)."""


@runtime_checkable
class Predicts(Protocol):
    """An algorithm or policy of Stable-Baselines3."""

    def predict(
        self, observation: Array, state: Any, episode_start: Array, deterministic: bool
    ) -> tuple[Array, Any]:
        """Actions (n, …) and the state of a recurrent policy."""


Policy = PlainPolicy | Acts | Predicts | Callable[[Array], Array]
"""A policy as :func:`gym_extensions.baselines.record` takes it."""


class PolicyAgent:
    """Acts with a policy.

    Args:
        policy: an object with ``act`` or ``predict``, or a function.
        card: the description for the manifest.
        observes: what the policy observes besides observations. None: its attribute ``observes``, or else
            the task if it has arrays per task.

    Raises:
        BenchError: ``policy`` is none of these.
    """

    def __init__(self, policy: Policy, card: Card, observes: Observes | None = None) -> None:
        self._policy, self._card = policy, card
        per_task = isinstance(policy, PlainPolicy) and policy.num_tasks > 0
        by_default: Observes = getattr(policy, "observes", Observes(per_task, per_task))
        self.observes = by_default if observes is None else observes
        self.begin(0)

    def begin(self, seed: int) -> None:
        """Begins the evaluation of a task: forgets the state of a recurrent policy.

        Args:
            seed: of the generator that a policy of :mod:`gym_extensions.rollouts` samples with.
        """
        self._act = _action_function(self._policy, self._card.evaluation == "deterministic", seed)

    def act(self, observations: Array, context: Context) -> Array:
        """The policy's actions. Raises ``BenchError`` if the policy fails."""
        try:
            return self._act(observations, context)
        except POLICY_ERRORS as error:
            reason = f"{type(error).__name__}: {error}".rstrip(".")
            shape = f"shape {observations.shape} and dtype {observations.dtype}"
            message = f"The policy failed on observations of {shape}: {reason}."
            raise BenchError("bad-policy", message, "policy", f"{SIGNATURE}.") from error

    def learn(self, env: VectorEnv, steps: int) -> NoReturn:
        """Recorded policies are already trained."""
        raise NotImplementedError

    def card(self) -> Card:
        """The description for the manifest."""
        return self._card

    def policy(self) -> PlainPolicy | None:
        """The policy as plain arrays; None for any other policy."""
        return self._policy if isinstance(self._policy, PlainPolicy) else None


def _action_function(policy: object, deterministic: bool, seed: int) -> Callable[[Array, Context], Array]:
    if isinstance(policy, PlainPolicy):
        plain, rng = policy, np.random.default_rng(seed)
        return lambda observations, context: plain.act(
            observations, rng, context.task if plain.num_tasks > 1 else 0
        )
    if isinstance(policy, Acts):
        return action_function(policy)  # type: ignore[arg-type]
    if isinstance(policy, Predicts):
        return _Prediction(policy, deterministic)
    if callable(policy):
        function = policy
        return lambda observations, _: function(observations)
    hint = f"{SIGNATURE}, or an object with a method act or predict."
    raise BenchError(
        "bad-policy", f"A value of type {type(policy).__name__} is not a policy.", "policy", hint
    )


class _Prediction:
    """The predictions of a Stable-Baselines3 model, with the state of a recurrent policy between steps."""

    def __init__(self, model: Predicts, deterministic: bool) -> None:
        self._model, self._deterministic = model, deterministic
        self._state: Any = None

    def __call__(self, observations: Array, context: Context) -> Array:
        actions, self._state = self._model.predict(
            observations,
            state=self._state,
            episode_start=context.episode_starts,
            deterministic=self._deterministic,
        )
        return actions
