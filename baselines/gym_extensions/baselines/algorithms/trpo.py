"""TRPO with the settings that are usual today: the reference agent, evaluated by its mean action."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array, Card, VectorEnv, acting_and_learning
from gym_extensions.baselines.checkpoint import load_arrays, restore_generator, save_arrays, saved_generator
from gym_extensions.baselines.trpo import settings as table
from gym_extensions.baselines.trpo.batch import Collector, Transitions
from gym_extensions.baselines.trpo.export import exported
from gym_extensions.baselines.trpo.gae import advantages
from gym_extensions.baselines.trpo.gaussian_policy import (
    Architecture,
    Batch,
    initial_policy,
    mean_and_log_sigma,
    sampled,
)
from gym_extensions.baselines.trpo.normalization import Moments, merge, network_inputs, no_moments
from gym_extensions.baselines.trpo.penalty import Penalty
from gym_extensions.baselines.trpo.update import updated
from gym_extensions.baselines.trpo.value_function import ValueFunction
from gym_extensions.rollouts.policies import Policy


class Trpo:
    """The agent; its policy is one flat vector of parameters and the moments of the observations."""

    name, title = "trpo", "TRPO"
    tuning_steps = table.TUNING_STEPS
    tuning_tasks: tuple[str, ...] = table.TUNING_TASKS
    description = "TRPO with today's usual settings: 64-64 tanh, normalized observations, GAE λ .95."

    def __init__(
        self,
        observation_space: gym.spaces.Box,
        action_space: gym.spaces.Box,
        seed: int,
        settings: table.TrpoSettings = table.REFERENCE,
    ) -> None:
        self._settings = settings
        self._acting, self._learning = acting_and_learning(seed)
        low, high = action_space.low.astype(np.float32), action_space.high.astype(np.float32)
        self._middle, self._half = (high + low) / 2, (high - low) / 2
        inputs, outputs = int(np.prod(observation_space.shape)), int(np.prod(action_space.shape))
        sizes = (inputs, *settings.hidden, outputs)
        self._architecture = Architecture(sizes, settings.activation, settings.tanh_mean)
        self._batch_steps = 0
        self._initialize()

    def _initialize(self) -> None:
        """Fresh networks and no moments."""
        inputs = self._architecture.sizes[0]
        self._theta = self._initial_policy()
        self._moments = no_moments(inputs)
        self._value = ValueFunction(inputs, self._learning, self._settings.value)

    def _initial_policy(self) -> Array:
        start = (self._settings.last_layer_scale, self._settings.initial_log_sigma)
        return initial_policy(self._architecture, self._learning, *start)

    def act(self, observations: Array) -> Array:
        """Mean or sampled actions (num_envs, a), depending on the settings. The moments do not change."""
        return self._act(observations, self._theta, self._moments)

    def _act(self, observations: Array, theta: Array, moments: Moments) -> Array:
        observations = np.asarray(observations, np.float32)
        mean, log_sigma = self._mean_and_log_sigma(observations, theta, moments)
        if self._settings.deterministic_evaluation:
            return self._to_env(mean)
        return self._to_env(sampled(mean, log_sigma, self._acting))

    def learn(self, env: VectorEnv, steps: int) -> None:
        """One update per batch until ``steps`` transitions are taken; episodes continue across batches."""
        self._batch_steps = int(getattr(env, "batch_steps", self._settings.default_batch))
        self._train(Collector(env), steps)

    def _train(self, collector: Collector, steps: int) -> int:
        """Returns the transitions taken. A batch is skipped if those of the batches before suffice for it."""
        taken, target = 0, 0
        while target < steps:
            target = min(target + self._batch_steps, steps)
            if target <= taken:
                continue
            transitions = collector.collect(
                lambda seen: self._sample(seen, self._learning), self._to_env, target - taken
            )
            taken += int(transitions.valid.sum())
            self._update(transitions)
        return taken

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
        observations = self._observations_of(transitions)
        batch = Batch(self._policy_inputs(observations), transitions.actions[valid], scaled)
        self._theta = updated(
            self._architecture,
            self._theta,
            batch,
            settings.trust_region,
            penalty=self._penalty(),
            trainable=self._trainable(),
        )
        # After the update, so that the actions and the update of a batch use the same moments.
        if settings.normalize_observations:
            self._moments = merge(self._moments, observations)
        self._value.fit(observations, targets, self._learning)

    def _penalty(self) -> Penalty | None:
        """A penalty on the parameters in the next update; a continual-learning method has one."""
        return None

    def _trainable(self) -> Array | None:
        """1 for the parameters that the next update may change, 0 for the others (p,); by default all may."""
        return None

    def _observations_of(self, transitions: Transitions) -> Array:
        """The observations of the transitions, (n, o)."""
        valid = transitions.observations[:-1][transitions.valid]
        return valid.reshape(-1, self._architecture.sizes[0])

    def _policy_inputs(self, observations: Array) -> Array:
        """The inputs of the policy network (n, o); raw observations until the first batch is complete."""
        return network_inputs(self._moments, observations)

    def _mean_and_log_sigma(self, observations: Array, theta: Array, moments: Moments) -> tuple[Array, Array]:
        inputs = network_inputs(moments, observations.reshape(len(observations), -1))
        return mean_and_log_sigma(self._architecture, theta, inputs)

    def _sample(self, observations: Array, generator: np.random.Generator) -> Array:
        return sampled(*self._mean_and_log_sigma(observations, self._theta, self._moments), generator)

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
            table.manifest_settings(self._settings),
            tuning_steps=self.tuning_steps,
            tuning_tasks=self.tuning_tasks,
            stored_steps=self._batch_steps,
            parameters=len(self._theta) + self._value.parameters,
        )

    def save(self, path: Path) -> None:
        """Writes the policy, the moments, the value function and both random generators."""
        save_arrays(path, **self._state())

    def load(self, path: Path) -> None:
        """Restores a saved agent."""
        self._restore(load_arrays(path))

    def _state(self) -> dict[str, Array]:
        moments = self._moments
        return {
            "policy": self._theta,
            "count": np.array(moments.count),
            "mean": moments.mean,
            "squares": moments.squares,
            "batch_steps": np.array(self._batch_steps),
            "acting": saved_generator(self._acting),
            "learning": saved_generator(self._learning),
            **{f"value_{name}": values for name, values in self._value.state.items()},
        }

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        self._theta, self._batch_steps = arrays["policy"], int(arrays["batch_steps"])
        self._moments = Moments(float(arrays["count"]), arrays["mean"], arrays["squares"])
        self._value.state = {name: arrays[f"value_{name}"] for name in self._value.state}
        restore_generator(self._acting, arrays["acting"])
        restore_generator(self._learning, arrays["learning"])


make = Trpo
