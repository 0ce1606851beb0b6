"""TRPO as in the paper: maximum KL .01, GAE λ 1.0, discount .99, CG regularisation 1e-5, 100-50-25 ReLU.

It differs from the paper's in the value function: a small MLP in place of rllab's linear baseline.
"""

from __future__ import annotations

from pathlib import Path

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array, Card, Setting, VectorEnv, acting_and_learning
from gym_extensions.baselines.checkpoint import load_arrays, restore_generator, save_arrays, saved_generator
from gym_extensions.baselines.trpo.batch import Gathered, Lanes, gather
from gym_extensions.baselines.trpo.gae import advantages
from gym_extensions.baselines.trpo.gaussian_policy import Batch, initial_policy, mean_and_log_sigma
from gym_extensions.baselines.trpo.update import TrustRegion, updated
from gym_extensions.baselines.trpo.value_function import ValueFunction

HIDDEN = (100, 50, 25)
LAST_SCALE = 0.01
"""The output layer starts near zero, so that the first mean is the middle of the action box."""
DISCOUNT, TRACE_DECAY = 0.99, 1.0
REGION = TrustRegion()
DEFAULT_BATCH = 5000


class Trpo:
    """The agent; its policy is one flat vector of parameters."""

    def __init__(self, observation_space: gym.spaces.Box, action_space: gym.spaces.Box, seed: int) -> None:
        self._acting, self._learning = acting_and_learning(seed)
        low, high = action_space.low.astype(np.float32), action_space.high.astype(np.float32)
        self._middle, self._half = (high + low) / 2, (high - low) / 2
        inputs = int(np.prod(observation_space.shape))
        self._sizes = (inputs, *HIDDEN, int(np.prod(action_space.shape)))
        self._theta = initial_policy(self._sizes, self._learning, LAST_SCALE)
        self._value = ValueFunction(inputs, self._learning)
        self._batch_steps = 0

    def act(self, observations: Array) -> Array:
        """Actions drawn from the policy, as in the paper's evaluation."""
        return self._to_env(self._sample(np.asarray(observations, np.float32), self._acting))

    def learn(self, env: VectorEnv, steps: int) -> None:
        """One update a batch until ``steps`` transitions are taken; episodes go on across batches."""
        self._batch_steps = int(getattr(env, "batch_steps", DEFAULT_BATCH))
        lanes, taken, target = Lanes.started(env), 0, 0
        while target < steps:
            target = min(target + self._batch_steps, steps)
            batch = gather(
                lanes, lambda seen: self._sample(seen, self._learning), self._to_env, target - taken
            )
            taken += int(batch.real.sum())
            self._update(batch)

    def _update(self, batch: Gathered) -> None:
        flat = batch.observations.reshape(-1, self._sizes[0])
        values = self._value.predict(flat).reshape(batch.observations.shape[:2])
        ends = (batch.terminated, batch.truncated)
        gained = advantages(batch.rewards, values, *ends, discount=DISCOUNT, trace_decay=TRACE_DECAY)
        real = batch.real
        targets = (gained + values[:-1])[real]
        chosen = gained[real]
        centred = ((chosen - chosen.mean()) / (chosen.std() + 1e-8)).astype(np.float32)
        observations = batch.observations[:-1][real].reshape(-1, self._sizes[0])
        self._theta = updated(
            self._sizes, self._theta, Batch(observations, batch.actions[real], centred), REGION
        )
        self._value.fit(observations, targets, self._learning)

    def _sample(self, observations: Array, generator: np.random.Generator) -> Array:
        mean, log_sigma = mean_and_log_sigma(
            self._sizes, self._theta, observations.reshape(len(observations), -1)
        )
        noise = generator.standard_normal(mean.shape, np.float32)
        drawn: Array = mean + np.exp(log_sigma) * noise
        return drawn

    def _to_env(self, actions: Array) -> Array:
        scaled: Array = self._middle + self._half * actions
        return scaled

    def card(self) -> Card:
        """The manifest's words."""
        settings: dict[str, Setting] = {
            "hidden": list(HIDDEN),
            "max_kl": REGION.max_kl,
            "gae_lambda": TRACE_DECAY,
            "discount": DISCOUNT,
            "cg_damping": REGION.damping,
            "cg_iterations": REGION.iterations,
            "value_function": "MLP 64-64 ReLU, 10 epochs of Adam at 1e-3 a batch",
        }
        text = "TRPO with the paper's settings; an MLP value function in place of rllab's linear baseline."
        count = len(self._theta) + self._value.parameters
        return Card(
            "trpo", "TRPO", text, "sampled", settings, stored_steps=self._batch_steps, parameters=count
        )

    def save(self, path: Path) -> None:
        """Writes policy, value function and both generators."""
        kept = {f"value_{name}": values for name, values in self._value.state.items()}
        generators = {"acting": saved_generator(self._acting), "learning": saved_generator(self._learning)}
        save_arrays(path, policy=self._theta, batch_steps=np.array(self._batch_steps), **kept, **generators)

    def load(self, path: Path) -> None:
        """Becomes the agent that was saved."""
        arrays = load_arrays(path)
        self._theta, self._batch_steps = arrays["policy"], int(arrays["batch_steps"])
        self._value.state = {name: arrays[f"value_{name}"] for name in self._value.state}
        restore_generator(self._acting, arrays["acting"])
        restore_generator(self._learning, arrays["learning"])


make = Trpo
