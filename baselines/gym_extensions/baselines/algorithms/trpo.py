"""TRPO with the settings that are usual today: the reference agent, evaluated by its mean action."""

from __future__ import annotations

from pathlib import Path

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array, Card, VectorEnv, acting_and_learning
from gym_extensions.baselines.checkpoint import load_arrays, restore_generator, save_arrays, saved_generator
from gym_extensions.baselines.trpo.batch import Collector, Transitions
from gym_extensions.baselines.trpo.export import exported
from gym_extensions.baselines.trpo.gae import advantages
from gym_extensions.baselines.trpo.gaussian_policy import (
    Architecture,
    Batch,
    initial_policy,
    mean_and_log_sigma,
)
from gym_extensions.baselines.trpo.normalization import Moments, merge, no_moments, standardize
from gym_extensions.baselines.trpo.settings import REFERENCE, TrpoSettings, manifest_settings
from gym_extensions.baselines.trpo.update import updated
from gym_extensions.baselines.trpo.value_function import ValueFunction
from gym_extensions.rollouts.policies import Policy


class Trpo:
    """The agent; its policy is one flat vector of parameters and the moments of the observations."""

    name, title = "trpo", "TRPO"
    description = "TRPO with today's usual settings: 64-64 tanh, normalized observations, GAE λ .95."

    def __init__(
        self,
        observation_space: gym.spaces.Box,
        action_space: gym.spaces.Box,
        seed: int,
        settings: TrpoSettings = REFERENCE,
    ) -> None:
        self._settings = settings
        self._acting, self._learning = acting_and_learning(seed)
        low, high = action_space.low.astype(np.float32), action_space.high.astype(np.float32)
        self._middle, self._half = (high + low) / 2, (high - low) / 2
        inputs, outputs = int(np.prod(observation_space.shape)), int(np.prod(action_space.shape))
        sizes = (inputs, *settings.hidden, outputs)
        self._architecture = Architecture(sizes, settings.activation, settings.tanh_mean)
        start = (settings.last_layer_scale, settings.initial_log_sigma)
        self._theta = initial_policy(self._architecture, self._learning, *start)
        self._moments = no_moments(inputs)
        self._value = ValueFunction(inputs, self._learning, settings.value)
        self._batch_steps = 0

    def act(self, observations: Array) -> Array:
        """Mean or sampled actions (num_envs, a), depending on the settings. The moments do not change."""
        observations = np.asarray(observations, np.float32)
        if self._settings.deterministic_evaluation:
            return self._to_env(self._mean_and_log_sigma(observations)[0])
        return self._to_env(self._sample(observations, self._acting))

    def learn(self, env: VectorEnv, steps: int) -> None:
        """One update per batch until ``steps`` transitions are taken; episodes continue across batches."""
        self._batch_steps = int(getattr(env, "batch_steps", self._settings.default_batch))
        collector, taken, target = Collector(env), 0, 0
        while target < steps:
            target = min(target + self._batch_steps, steps)
            transitions = collector.collect(
                lambda seen: self._sample(seen, self._learning), self._to_env, target - taken
            )
            taken += int(transitions.valid.sum())
            self._update(transitions)

    def _update(self, transitions: Transitions) -> None:
        settings, valid = self._settings, transitions.valid
        flat = transitions.observations.reshape(-1, self._architecture.sizes[0])
        values = self._value.predict(flat).reshape(transitions.observations.shape[:2])
        estimates = advantages(
            transitions.rewards,
            values,
            transitions.terminated,
            transitions.truncated,
            discount=settings.discount,
            gae_lambda=settings.gae_lambda,
        )
        targets, chosen = (estimates + values[:-1])[valid], estimates[valid]
        scaled = ((chosen - chosen.mean()) / (chosen.std() + 1e-8)).astype(np.float32)
        observations = transitions.observations[:-1][valid].reshape(-1, self._architecture.sizes[0])
        batch = Batch(self._policy_inputs(observations), transitions.actions[valid], scaled)
        self._theta = updated(self._architecture, self._theta, batch, settings.trust_region)
        # After the update, so that the actions and the update of a batch use the same moments.
        if settings.normalize_observations:
            self._moments = merge(self._moments, observations)
        self._value.fit(observations, targets, self._learning)

    def _policy_inputs(self, observations: Array) -> Array:
        """The inputs of the policy network (n, o); raw observations until the first batch is complete."""
        return standardize(self._moments, observations) if self._moments.count else observations

    def _mean_and_log_sigma(self, observations: Array) -> tuple[Array, Array]:
        inputs = self._policy_inputs(observations.reshape(len(observations), -1))
        return mean_and_log_sigma(self._architecture, self._theta, inputs)

    def _sample(self, observations: Array, generator: np.random.Generator) -> Array:
        mean, log_sigma = self._mean_and_log_sigma(observations)
        actions: Array = mean + np.exp(log_sigma) * generator.standard_normal(mean.shape, np.float32)
        return actions

    def _to_env(self, actions: Array) -> Array:
        scaled: Array = self._middle + self._half * actions
        return scaled

    def policy(self) -> Policy:
        """The policy as plain arrays."""
        is_deterministic = self._settings.deterministic_evaluation
        box = (self._middle, self._half)
        return exported(self._architecture, self._theta, self._moments, box, deterministic=is_deterministic)

    def card(self) -> Card:
        """The agent's description in the manifest."""
        return Card(
            self.name,
            self.title,
            self.description,
            "deterministic" if self._settings.deterministic_evaluation else "sampled",
            manifest_settings(self._settings),
            stored_steps=self._batch_steps,
            parameters=len(self._theta) + self._value.parameters,
        )

    def save(self, path: Path) -> None:
        """Writes the policy, the moments, the value function and both random generators."""
        moments = self._moments
        save_arrays(
            path,
            policy=self._theta,
            count=np.array(moments.count),
            mean=moments.mean,
            squares=moments.squares,
            batch_steps=np.array(self._batch_steps),
            acting=saved_generator(self._acting),
            learning=saved_generator(self._learning),
            **{f"value_{name}": values for name, values in self._value.state.items()},
        )

    def load(self, path: Path) -> None:
        """Restores a saved agent."""
        arrays = load_arrays(path)
        self._theta, self._batch_steps = arrays["policy"], int(arrays["batch_steps"])
        self._moments = Moments(float(arrays["count"]), arrays["mean"], arrays["squares"])
        self._value.state = {name: arrays[f"value_{name}"] for name in self._value.state}
        restore_generator(self._acting, arrays["acting"])
        restore_generator(self._learning, arrays["learning"])


make = Trpo
