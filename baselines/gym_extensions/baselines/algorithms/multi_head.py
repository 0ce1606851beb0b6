"""TRPO with shared hidden layers, and an output layer and log σ per task (Wolczyk et al. 2021)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array, Card, Context, Observes, VectorEnv
from gym_extensions.baselines.algorithms.continual.export import exported_heads, head_rows
from gym_extensions.baselines.algorithms.continual.heads import (
    Head,
    Heads,
    from_arrays,
    hidden_count,
    to_arrays,
    trained_task,
)
from gym_extensions.baselines.algorithms.trpo import Trpo
from gym_extensions.baselines.trpo.settings import REFERENCE, TrpoSettings
from gym_extensions.rollouts.policies import Policy


class MultiHead(Trpo):
    """The agent ``multi-head``.

    A task starts with a new output layer, the initial log σ, and the hidden layers and moments of the task
    before. At its end its output layer, log σ and moments are stored. A task that was not learned yet is
    evaluated with those of the present task.
    """

    name, title = "multi-head", "TRPO + multi-head"
    description = "The reference agent with an output layer and log σ per task; it observes the task."
    observes = Observes(task_in_training=True, task_in_evaluation=True, boundaries=True)

    def __init__(
        self,
        observation_space: gym.spaces.Box,
        action_space: gym.spaces.Box,
        seed: int,
        settings: TrpoSettings = REFERENCE,
    ) -> None:
        super().__init__(observation_space, action_space, seed, settings)
        self._hidden = hidden_count(self._architecture.sizes)
        self._heads: Heads = {}
        self._task = self._number = 0

    def act(self, observations: Array, context: Context | None = None) -> Array:
        """Acts as in the context's task; without a context, as in the present one."""
        head = self._heads.get(context.task) if context else None
        if head is None:
            return super().act(observations)
        return self._act(observations, self._parameters_of(head), head.moments)

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Learns one task. Raises ``BenchError`` if the environments run several tasks."""
        self._task = trained_task(env, self.name)
        self._begin(self._task)
        super().learn(env, steps)
        self._heads[self._task] = Head(self._theta[self._hidden :].copy(), self._moments, self._number)

    def _begin(self, task: int) -> None:
        self._number += 1
        if task in self._heads:
            head = self._heads[task]
            parameters, self._moments = head.parameters, head.moments
        elif self._heads:
            parameters = self._initial_policy()[self._hidden :]
        else:
            return
        self._theta = np.concatenate([self._theta[: self._hidden], parameters])

    def _parameters_of(self, head: Head) -> Array:
        """The policy's parameters in a finished task (p,)."""
        return np.concatenate([self._theta[: self._hidden], head.parameters])

    def policy(self) -> Policy:
        """The policy as plain arrays, with a row per task."""
        if not self._heads:
            return super().policy()
        rows = head_rows(self._heads, self._task)
        return exported_heads(
            self._architecture,
            self._theta[: self._hidden],
            rows,
            (self._middle, self._half),
            deterministic=self._settings.deterministic_evaluation,
            masks=self._masks(rows),
        )

    def _masks(self, rows: Sequence[Head]) -> list[Array] | None:
        """True for the hidden parameters that each row uses; None if it uses all."""
        return None

    def card(self) -> Card:
        """The card of ``trpo`` with the parameters of all heads."""
        card = super().card()
        more = max(len(self._heads) - 1, 0) * (len(self._theta) - self._hidden)
        return replace(card, parameters=card.parameters + more)

    def _state(self) -> dict[str, Array]:
        return super()._state() | to_arrays(self._heads) | {"progress": np.array([self._task, self._number])}

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        super()._restore(arrays)
        self._heads = from_arrays(arrays)
        self._task, self._number = map(int, arrays["progress"])


make = MultiHead
