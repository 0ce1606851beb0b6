"""TRPO with a regularizer; without a penalty it is ``trpo``, bit by bit."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import replace

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array, Card, Observes, VectorEnv
from gym_extensions.baselines.algorithms.continual.regularizer import Regularizer
from gym_extensions.baselines.algorithms.continual.state_sample import StateSample
from gym_extensions.baselines.algorithms.trpo import Trpo
from gym_extensions.baselines.trpo.batch import Transitions
from gym_extensions.baselines.trpo.penalty import Penalty
from gym_extensions.baselines.trpo.settings import REFERENCE, TUNING_STEPS, TUNING_TASKS, TrpoSettings


class RegularizedTrpo(Trpo):
    """The reference agent with a penalty on its policy's parameters. The value function has no penalty."""

    observes = Observes(boundaries=True)
    tuning_steps = TUNING_STEPS + 2_000_000  # docs/learners.md
    tuning_tasks = (*TUNING_TASKS, "HalfCheetah at 0.6, 0.9 and 1.4 gravity")
    published_coefficient: float
    """The coefficient of the penalty for all groups."""

    def __init__(
        self,
        observation_space: gym.spaces.Box,
        action_space: gym.spaces.Box,
        seed: int,
        settings: TrpoSettings = REFERENCE,
        coefficient: float | None = None,
    ) -> None:
        super().__init__(observation_space, action_space, seed, settings)
        strength = self.published_coefficient if coefficient is None else coefficient
        self._regularizer = self._new_regularizer(strength)
        self._regularizer.start(self._theta)
        self._sample_of_task = StateSample(0, 0)
        self._most_stored = 0

    @abstractmethod
    def _new_regularizer(self, coefficient: float) -> Regularizer:
        """The method's regularizer."""

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Learns one stage, and then stores what the penalty of later stages needs."""
        regularizer = self._regularizer
        self._sample_of_task = StateSample(regularizer.states_per_task, steps)
        super().learn(env, steps)
        observations = self._sample_of_task.observations
        held = len(observations) + regularizer.stored_states
        regularizer.end_of_task(self._architecture, self._theta, observations, self._policy_inputs)
        self._most_stored = max(self._most_stored, held)
        self._sample_of_task = StateSample(0, 0)

    def _update(self, transitions: Transitions) -> None:
        super()._update(transitions)
        self._sample_of_task.add(self._observations_of(transitions))

    def _penalty(self) -> Penalty | None:
        return self._regularizer.penalty(self._architecture, self._policy_inputs)

    def card(self) -> Card:
        """The card of ``trpo`` with the hyperparameters and the stored states of the method."""
        card = super().card()
        settings = {**card.hyperparameters, **self._regularizer.settings}
        return replace(card, hyperparameters=settings, stored_steps=card.stored_steps + self._most_stored)

    def _state(self) -> dict[str, Array]:
        stored = {f"regularizer_{name}": values for name, values in self._regularizer.state.items()}
        return super()._state() | stored | {"most_stored": np.array(self._most_stored)}

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        super()._restore(arrays)
        regularizer = self._regularizer
        regularizer.state = {name: arrays[f"regularizer_{name}"] for name in regularizer.state}
        self._most_stored = int(arrays["most_stored"])
