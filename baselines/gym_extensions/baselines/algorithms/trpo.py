"""The TRPO agents: the reference agent, the settings of 2017, and fresh networks for every task."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array, Card, Setting, VectorEnv
from gym_extensions.baselines.generators import acting_and_learning, restore_generator, saved_generator
from gym_extensions.baselines.trust_region import policy as policies, update, values
from gym_extensions.submissions.manifest import Observes
from gym_extensions.submissions.policies.mlp import Policy


@dataclass(frozen=True)
class TrpoSettings:
    """Hyperparameters of one agent; the comments of the two instances below name the source of each value."""

    hidden: tuple[int, ...]  # widths of the policy's hidden layers
    activation: str  # of these layers
    tanh_mean: bool  # whether the mean action is squashed by a tanh
    initial_log_sigma: float  # of every action component, in half-widths of the action box
    last_layer_scale: float  # factor on the policy's initial output weights
    normalize_observations: bool  # whether the policy sees standardized observations
    deterministic_evaluation: bool  # whether ``act`` returns the mean action or a sample
    discount: float  # γ
    gae_lambda: float  # λ of generalized advantage estimation
    trust_region: update.TrustRegion
    value: values.ValueFit = field(default_factory=values.ValueFit)


REFERENCE = TrpoSettings(
    hidden=(64, 64),  # Schulman et al. 2017, section 6.1; the default of Stable-Baselines3
    activation="tanh",  # the same
    tanh_mean=False,  # the same
    initial_log_sigma=-1.0,  # docs/learners.md; Andrychowicz et al. 2021 recommend σ = .5, log σ = −.7
    last_layer_scale=0.01,  # Andrychowicz et al. 2021: a last layer 100 times smaller
    normalize_observations=True,  # Andrychowicz et al. 2021; RL Zoo's and OpenAI Baselines' TRPO on MuJoCo
    deterministic_evaluation=True,  # the default of Stable-Baselines3's evaluate_policy
    discount=0.995,  # docs/learners.md; RL Zoo and OpenAI Baselines use .99
    gae_lambda=0.95,  # RL Zoo's TRPO on MuJoCo
    trust_region=update.TrustRegion(
        max_kl=0.04,  # RL Zoo's HalfCheetah; it averages over the action's components, this is their sum
        damping=0.1,  # RL Zoo's and OpenAI Baselines' TRPO on MuJoCo
        iterations=10,  # OpenAI Baselines' TRPO on MuJoCo
        least_log_sigma=-1.0,  # docs/learners.md: the exploration noise does not fall below its initial value
    ),
)
"""``trpo``: the reference agent."""

TUNING_STEPS = 40_800_000
TUNING_TASKS = (
    "HalfCheetah",
    "Hopper",
    "Walker2d",
    "Hopper at 0.9 gravity",
    "Walker2d at 0.9 gravity",
    "HalfCheetah at 0.9 gravity",
)
"""The trials that chose the settings of ``trpo``: docs/learners.md lists them."""

HENDERSON_2017 = TrpoSettings(
    hidden=(100, 50, 25),  # Henderson et al. 2017
    activation="relu",  # the same
    tanh_mean=True,  # the same
    initial_log_sigma=0.0,  # rllab's default
    last_layer_scale=0.01,  # this project: the first mean is the middle of the action box
    normalize_observations=False,  # Henderson et al. 2017
    deterministic_evaluation=False,  # the same
    discount=0.99,  # the same
    gae_lambda=1.0,  # the same
    trust_region=update.TrustRegion(max_kl=0.01, damping=1e-5, iterations=10),  # the same; rllab's default
)
"""``trpo-2017``: the settings of the paper; an MLP value function in place of rllab's linear baseline."""


def manifest_settings(settings: TrpoSettings) -> Mapping[str, Setting]:
    """The rows of a submission's manifest."""
    region, value = settings.trust_region, settings.value
    network = f"MLP {'-'.join(map(str, value.hidden))} relu"
    return {
        "hidden": list(settings.hidden),
        "activation": settings.activation,
        "tanh_mean": settings.tanh_mean,
        "initial_log_sigma": settings.initial_log_sigma,
        "least_log_sigma": "none" if math.isinf(region.least_log_sigma) else region.least_log_sigma,
        "normalize_observations": settings.normalize_observations,
        "max_kl": region.max_kl,
        "gae_lambda": settings.gae_lambda,
        "discount": settings.discount,
        "cg_damping": region.damping,
        "cg_iterations": region.iterations,
        "value_function": f"{network}, {value.epochs} epochs of Adam at {value.learning_rate:g} per batch",
    }


class Trpo:
    """The agent; its policy is one flat vector of parameters and the moments of the observations."""

    name, title = "trpo", "TRPO"
    settings = REFERENCE
    tuning_steps = TUNING_STEPS
    tuning_tasks: tuple[str, ...] = TUNING_TASKS
    parent: str = ""
    description = "TRPO: 64-64 tanh, normalized observations, GAE λ .95; tuned on three planar bodies."

    def __init__(
        self,
        observation_space: gym.spaces.Box,
        action_space: gym.spaces.Box,
        seed: int,
        settings: TrpoSettings | None = None,
    ) -> None:
        self._settings = settings = settings or self.settings
        self._acting, self._learning = acting_and_learning(seed)
        low, high = action_space.low.astype(np.float32), action_space.high.astype(np.float32)
        self._middle, self._half = (high + low) / 2, (high - low) / 2
        inputs, outputs = int(np.prod(observation_space.shape)), int(np.prod(action_space.shape))
        sizes = (inputs, *settings.hidden, outputs)
        self._architecture = policies.Architecture(sizes, settings.activation, settings.tanh_mean)
        self._batch_steps = 0
        self._initialize()

    def _initialize(self) -> None:
        """Fresh networks and no moments."""
        inputs = self._architecture.sizes[0]
        self._theta = self._initial_policy()
        self._moments = policies.no_moments(inputs)
        self._value = values.ValueFunction(inputs, self._learning, self._settings.value)

    def _initial_policy(self) -> Array:
        sizes, settings = self._architecture.sizes, self._settings
        network = policies.initial(sizes, self._learning, settings.last_layer_scale)
        return np.concatenate([network, np.full(sizes[-1], settings.initial_log_sigma, np.float32)])

    def act(self, observations: Array) -> Array:
        """Mean or sampled actions (num_envs, a), depending on the settings. The moments do not change."""
        return self._act(observations, self._theta, self._moments)

    def _act(self, observations: Array, theta: Array, moments: policies.Moments) -> Array:
        seen = np.asarray(observations, np.float32)
        mean, log_sigma = self._mean_and_log_sigma(seen, theta, moments)
        is_best = self._settings.deterministic_evaluation
        return self._to_env(mean if is_best else policies.sampled(mean, log_sigma, self._acting))

    def learn(self, env: VectorEnv, steps: int) -> None:
        """One update per batch until ``steps`` transitions are taken; episodes continue across batches."""
        self._batch_steps = int(env.batch_steps)  # type: ignore[attr-defined]
        self._train(values.Collector(env), steps)

    def _train(self, collector: values.Collector, steps: int) -> int:
        """Returns the transitions taken. A batch is skipped if those of the batches before suffice for it."""
        taken, target = 0, 0
        while target < steps:
            target = min(target + self._batch_steps, steps)
            if target <= taken:
                continue
            transitions = collector.collect(self._explore, self._to_env, target - taken)
            taken += int(transitions.valid.sum())
            self._update(transitions)
        return taken

    def _explore(self, observations: Array) -> Array:
        policy = self._mean_and_log_sigma(observations, self._theta, self._moments)
        return policies.sampled(*policy, self._learning)

    def _update(self, transitions: values.Transitions) -> None:
        settings, valid = self._settings, transitions.valid
        flat = transitions.observations.reshape(-1, self._architecture.sizes[0])
        predicted = self._value.predict(flat).reshape(transitions.observations.shape[:2])
        estimates = values.advantages(
            transitions.rewards,
            predicted,
            transitions.terminated,
            transitions.truncated,
            discount=settings.discount,
            gae_lambda=settings.gae_lambda,
        )
        targets, advantages = (estimates + predicted[:-1])[valid], estimates[valid]
        normalized = ((advantages - advantages.mean()) / (advantages.std() + 1e-8)).astype(np.float32)
        observations = self._observations_of(transitions)
        batch = policies.Batch(self._policy_inputs(observations), transitions.actions[valid], normalized)
        self._theta = update.updated(
            self._architecture,
            self._theta,
            batch,
            settings.trust_region,
            penalty=self._penalty(),
            trainable=self._trainable(),
        )
        # After the update, so that the actions and the update of a batch use the same moments.
        if settings.normalize_observations:
            self._moments = policies.merge(self._moments, observations)
        self._value.fit(observations, targets, self._learning)

    def _penalty(self) -> update.Penalty | None:
        """A penalty on the parameters in the next update; a continual-learning method has one."""
        return None

    def _trainable(self) -> Array | None:
        """1 for the parameters that the next update may change, 0 for the others (p,); by default all may."""
        return None

    def _observations_of(self, transitions: values.Transitions) -> Array:
        """The observations of the transitions, (n, o)."""
        valid = transitions.observations[:-1][transitions.valid]
        return valid.reshape(-1, self._architecture.sizes[0])

    def _policy_inputs(self, observations: Array) -> Array:
        """The inputs of the policy network (n, o); raw observations until the first batch is complete."""
        return policies.network_inputs(self._moments, observations)

    def _mean_and_log_sigma(
        self, observations: Array, theta: Array, moments: policies.Moments
    ) -> tuple[Array, Array]:
        inputs = policies.network_inputs(moments, observations.reshape(len(observations), -1))
        return policies.mean_and_log_sigma(self._architecture, theta, inputs)

    def _to_env(self, actions: Array) -> Array:
        return self._middle + self._half * actions

    def policy(self) -> Policy:
        return self._exported(self._theta, self._moments)

    def _exported(self, theta: Array, moments: policies.Moments) -> Policy:
        """The policy of these parameters. It computes in float64, so it acts as the agent up to rounding."""
        architecture, normalization = self._architecture, dict[str, Any]()
        if moments.count:
            normalization["observation_mean"] = moments.mean
            normalization["observation_scale"] = policies.scale(moments)
            normalization["observation_clip"] = policies.CLIP
        network = policies.layers(architecture.sizes, theta)
        return Policy(
            action_offset=self._middle.ravel(),
            action_scale=self._half.ravel(),
            weights=tuple(weights for weights, _ in network),
            biases=tuple(bias for _, bias in network),
            activation=architecture.activation,
            output_activation="tanh" if architecture.tanh_mean else "linear",
            head="deterministic" if self._settings.deterministic_evaluation else "gaussian",
            log_sigma=theta[architecture.log_sigmas],
            **normalization,
        )

    def card(self) -> Card:
        return Card(
            self.name,
            self.title,
            self.description,
            "deterministic" if self._settings.deterministic_evaluation else "sampled",
            manifest_settings(self._settings),
            tuning_steps=self.tuning_steps,
            tuning_tasks=self.tuning_tasks,
            stored_steps=self._batch_steps,
            parameters=len(self._theta) + self._value.parameters,
            parent=self.parent,
        )

    def save(self, path: Path) -> None:
        with path.open("wb") as file:
            np.savez(file, allow_pickle=False, **self._state())

    def load(self, path: Path) -> None:
        with np.load(path) as arrays:
            self._restore(dict(arrays))

    def _state(self) -> dict[str, Array]:
        moments = self._moments
        return {
            "policy": self._theta,
            "count": np.array(moments.count),
            "mean": moments.mean,
            "squares": moments.squares,
            "batch_steps": np.array(self._batch_steps),
            "acting": np.array(saved_generator(self._acting)),
            "learning": np.array(saved_generator(self._learning)),
            **{f"value_{name}": array for name, array in self._value.state.items()},
        }

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        self._theta, self._batch_steps = arrays["policy"], int(arrays["batch_steps"])
        self._moments = policies.Moments(float(arrays["count"]), arrays["mean"], arrays["squares"])
        self._value.state = {name: arrays[f"value_{name}"] for name in self._value.state}
        restore_generator(self._acting, str(arrays["acting"]))
        restore_generator(self._learning, str(arrays["learning"]))


class Trpo2017(Trpo):
    """The agent with the paper's settings."""

    name, title = "trpo-2017", "TRPO (2017 settings)"
    description = "TRPO with the paper's settings; an MLP value function in place of rllab's linear baseline."
    settings = HENDERSON_2017
    tuning_steps = 0
    tuning_tasks = ()


class Reset(Trpo):
    """The agent ``reset``. Policy, value function and moments start anew with every task after the first."""

    name, title = "reset", "TRPO + reset"
    description = "The reference agent with fresh networks for every task: no transfer and no memory."
    parent = Trpo.name
    observes = Observes(boundaries=True)
    _used = False

    def learn(self, env: VectorEnv, steps: int) -> None:
        if self._used:
            self._initialize()
        self._used = True
        super().learn(env, steps)

    def _state(self) -> dict[str, Array]:
        return super()._state() | {"used": np.array(self._used)}

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        super()._restore(arrays)
        self._used = bool(arrays["used"])


make = Trpo
