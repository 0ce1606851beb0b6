"""Makes agents of Stable-Baselines3 models, for example ``sb3(PPO, n_steps=250)``."""

import copy
import random
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import cloudpickle
import gymnasium as gym
import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback, ConvertCallback
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecNormalize

from gym_extensions.baselines import agent, generators
from gym_extensions.baselines.adapters import sb3_policy, sb3_vec_env
from gym_extensions.errors import BenchError
from gym_extensions.submissions.manifest import LONG, Observes
from gym_extensions.submissions.policies.files import AnyPolicy
from gym_extensions.submissions.rules.manifest import hyperparameter_error

Callback = BaseCallback | list[BaseCallback] | Callable[[dict[str, Any], dict[str, Any]], bool] | None
"""What SB3's ``learn(callback=…)`` accepts."""
NORMALIZATIONS = ("normalize_observations", "normalize_rewards")
"""Arguments of :func:`sb3` that are hyperparameters."""
NOT_HYPERPARAMETERS = ("device", "verbose", "tensorboard_log")
"""Keyword arguments of a model that are not stored in the manifest, because they do not change a result."""
LIBRARIES: dict[str, tuple[str, tuple[str, ...]]] = {
    "stable_baselines3": ("Stable-Baselines3", ()),
    "sb3_contrib": ("SB3-Contrib", ("sb3-contrib",)),
    "sbx": ("SBX", ("sbx-rl", "jax", "jaxlib", "flax", "optax")),
}
"""By the name of a library's module, its name and its packages besides those of Stable-Baselines3."""
PLACEHOLDER = (1, 2_000)
"""Environments and batch size, of the budget ``100k``, of a model before its first training."""
KEYS = ("key", "noise_key")
"""Attributes of SBX's policies with the JAX keys that they sample with."""
ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")


def sb3(
    algorithm: type[BaseAlgorithm],
    policy: str | type[BasePolicy] = "",
    *,
    deterministic: bool = True,
    normalize_observations: bool = False,
    normalize_rewards: bool = False,
    callback: Callback = None,
    **settings: Any,
) -> "Sb3Factory":
    """A factory of agents that train a Stable-Baselines3 or SBX model. It needs the extra ``sb3`` or ``sbx``.

    An interrupted run resumes after its last finished stage and writes the same files. Each stage is one
    call of the model's ``learn``, which starts its schedules and warm-up steps again, so the manifest states
    that the agent observes task boundaries. A rollout of the model, ``n_steps`` times the number of
    environments, should divide the budget: at most 2 % more steps are allowed.

    Args:
        algorithm: ``PPO``, ``SAC``, or any other class built on SB3's ``BaseAlgorithm``.
        policy: as SB3 takes it; by default ``"MlpPolicy"``, and ``"MlpLstmPolicy"`` for algorithms with
            recurrent policies.
        deterministic: whether evaluation uses the policy's best action instead of a sample.
        normalize_observations: whether observations are standardized by their running mean and standard
            deviation (SB3's ``VecNormalize``). The statistics persist across stages and do not change in
            evaluation.
        normalize_rewards: whether the model's rewards are divided by the running standard deviation of the
            discounted return. The log has the rewards of the task.
        callback: SB3 callbacks, as in ``learn(callback=…)``: one, a list, or a function. They are shared by
            all runs in this process and must pickle for worker processes.
        settings: keyword arguments of ``algorithm``.

    Returns:
        A factory for :func:`gym_extensions.baselines.train`.

    Raises:
        ModuleNotFoundError: torch or Stable-Baselines3 is not installed.
        BenchError: ``seed`` or ``env`` is set.

    Example:
        >>> from stable_baselines3 import PPO
        >>> make = sb3(PPO, n_steps=250, normalize_observations=True)
    """
    if policy:
        settings["policy"] = policy
    for name in ("env", "seed"):
        if name in settings:
            message = f"{name!r} cannot be set, because every run sets its own."
            hint = f"Remove {name!r}; runs=range(5) trains five seeds."
            raise BenchError("bad-setting", message, "sb3()", hint)
    name = f"sb3-{algorithm.__name__.lower()}"  # not the name of a reference agent
    card = agent.Card(name, algorithm.__name__, f"{library(algorithm)[0]}'s {algorithm.__name__}.")
    return Sb3Factory(
        algorithm, settings, card, deterministic, normalize_observations, normalize_rewards, callback
    )


def library(algorithm: type[BaseAlgorithm]) -> tuple[str, tuple[str, ...]]:
    """The row of ``LIBRARIES`` of a class; that of Stable-Baselines3 for a class of the user."""
    return LIBRARIES.get(algorithm.__module__.partition(".")[0], LIBRARIES["stable_baselines3"])


@dataclass(frozen=True)
class Sb3Factory:
    """Creates agents of one SB3 class. It pickles, so worker processes can use it.

    ``continue_counting`` continues the model's count of steps in every stage, so that warm-up steps and
    schedules do not start again, as for an agent that does not use task boundaries. The agents complete the
    card with their settings and what they store. The other fields are arguments of :func:`sb3`.

    Calling it creates an agent. Keyword arguments change settings of the model or of ``method``, or a
    normalization: ``make(observation_space, action_space, 0, learning_rate=1e-3, normalize_rewards=True)``.
    """

    algorithm: type[BaseAlgorithm]
    settings: Mapping[str, Any]
    card: agent.Card
    deterministic: bool = True
    normalize_observations: bool = False
    normalize_rewards: bool = False
    callback: Callback = None
    continue_counting: bool = False
    fresh_buffer: bool = False  # whether the replay buffer is emptied at the start of a stage
    batch_settings: Callable[[int, int], Mapping[str, Any]] | None = None
    """Further settings, from the number of environments and the budget's batch size."""
    kind: "type[Sb3Agent] | None" = None  # the class of its agents; ``Sb3Agent`` if None
    method: Mapping[str, agent.Setting] = field(default_factory=dict)
    """Settings of that class; the manifest has them beside those of the model."""

    def __call__(
        self, observation_space: gym.Space[Any], action_space: gym.Space[Any], seed: int, /, **changes: Any
    ) -> "Sb3Agent":
        own = {name: changes.pop(name) for name in NORMALIZATIONS if name in changes}
        method = {name: changes.pop(name, value) for name, value in self.method.items()}
        options = replace(self, settings={**self.settings, **changes}, method=method, **own)
        return (self.kind or Sb3Agent)((observation_space, action_space), seed, options)

    @property
    def __name__(self) -> str:
        return self.card.algorithm

    def model(self, env: VecEnv, seed: int, batch_steps: int) -> BaseAlgorithm:
        of_batch = self.batch_settings(env.num_envs, batch_steps) if self.batch_settings else {}
        settings = {**self.settings, **of_batch}
        # SAC and A2C write into the policy_kwargs that they receive, so dicts are copied.
        copies = {name: dict(value) if isinstance(value, dict) else value for name, value in settings.items()}
        policy = "MlpPolicy" if "MlpPolicy" in self.algorithm.policy_aliases else "MlpLstmPolicy"
        arguments: dict[str, Any] = {"policy": policy, "device": "cpu", "seed": seed} | copies
        with warnings.catch_warnings():
            # The number of environments is not final, and a smaller last minibatch is allowed.
            warnings.filterwarnings("ignore", "You have specified a mini-batch size")
            return self.algorithm(env=env, **arguments)

    def manifest_settings(self) -> dict[str, agent.Setting]:
        """The hyperparameters as the manifest stores them; the normalizations only if they are used."""
        shown = {name: value for name, value in self.settings.items() if name not in NOT_HYPERPARAMETERS}
        rows = {name: to_manifest_value(value) for name, value in shown.items()}
        rows |= {**self.card.hyperparameters, **self.method}
        return rows | {name: True for name in NORMALIZATIONS if getattr(self, name)}


def to_manifest_value(value: Any) -> agent.Setting:
    """A plain value unchanged, any other value as text, cut at the manifest's limit.

    The text of a class or function is its qualified name, so two lambdas of one scope have the same text. The
    text contains no module name and no memory address: it is the same in every process.
    """
    return _text(value)[:LONG] if hyperparameter_error(value) else value


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray | np.generic):
        return _text(value.tolist())
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_text(key)}: {_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_text, value)) + "]"
    if isinstance(value, set | frozenset):
        return "{" + ", ".join(sorted(map(_text, value))) + "}"
    kind: Any = type(value)
    if hasattr(value, "__qualname__"):
        return str(value.__qualname__)
    return str(kind.__qualname__) if kind.__repr__ is object.__repr__ else ADDRESS.sub("", repr(value))


class Generators:
    """The states of the global generators of Python, numpy and torch for one purpose, such as acting."""

    def __init__(self, seed: int) -> None:
        legacy = np.random.RandomState(seed).get_state()  # SB3 draws from it
        self.state = (random.Random(seed).getstate(), legacy, torch.Generator().manual_seed(seed).get_state())

    @contextmanager
    def active(self) -> Iterator[None]:
        """The global generators continue from this state inside the context and are restored after it."""
        with generators.preserved_global_generators():
            generators.set_global_generators(self.state)
            yield
            self.state = generators.global_generators()


class Sb3Agent:
    """An SB3 model as an agent. Acting and learning use separate states of the global random generators.

    The model is created again if the number of environments or the batch size changes before training starts.
    """

    def __init__(self, spaces: tuple[gym.Space[Any], gym.Space[Any]], seed: int, options: Sb3Factory) -> None:
        # A model seeds its action space, so it has a copy.
        self._spaces, self._options = copy.deepcopy(spaces), options
        self._seed, self._trained = seed % 2**31, False
        torch.set_num_threads(1)
        self._acting = Generators(self._seed + 1)
        self._normalizer: VecNormalize | None = None
        self._state: tuple[agent.Array, ...] | None = None
        self.observes = Observes(boundaries=options.fresh_buffer or not options.continue_counting)
        self._create_model(*PLACEHOLDER)
        self._keys: dict[str, Any] = {}
        if all(hasattr(self._model.policy, name) for name in KEYS):
            from jax.random import PRNGKey

            self._keys = {name: PRNGKey(self._seed + 1) for name in KEYS}

    def _create_model(self, num_envs: int, batch_steps: int) -> None:
        env = DummyVecEnv([partial(sb3_vec_env.SpacesEnv, *self._spaces)] * num_envs)
        self._size, self._learning = (num_envs, batch_steps), Generators(self._seed)
        with self._learning.active():
            self._model = self._options.model(env, self._seed, batch_steps)
        self._normalized(env)

    def _normalized(self, env: VecEnv) -> VecEnv:
        """The environment with normalized observations and rewards, which continues the statistics so far."""
        observations, rewards = self._options.normalize_observations, self._options.normalize_rewards
        if not (observations or rewards):
            return env
        if self._normalizer is None:
            discount = getattr(self._model, "gamma", 1.0)
            self._normalizer = VecNormalize(env, norm_obs=observations, norm_reward=rewards, gamma=discount)
        else:
            self._normalizer.venv = None  # type: ignore[assignment]  # set_venv replaces no other
            self._normalizer.set_venv(env)
        return self._normalizer

    @contextmanager
    def _acts(self) -> Iterator[None]:
        """The generators and JAX keys of acting, which leave those of training untouched."""
        policy = vars(self._model.policy)
        outside = {name: policy[name] for name in self._keys}
        policy.update(self._keys)
        try:
            with self._acting.active():
                yield
        finally:
            self._keys = {name: policy[name] for name in self._keys}
            policy.update(outside)

    def act(self, observations: agent.Array, context: agent.Context | None = None) -> agent.Array:
        """Actions of the model's policy, sampled or deterministic.

        A recurrent policy keeps its state from call to call; it starts again where ``context.episode_starts``
        is True.

        Raises:
            BenchError: the policy is recurrent and ``context`` is None.
        """
        starts = None if context is None else context.episode_starts
        if starts is None or starts.all():
            self._state = None
        seen = np.asarray(observations, self._model.observation_space.dtype)
        if self._normalizer is not None:
            seen = np.asarray(self._normalizer.normalize_obs(seen))
        with self._acts():
            actions, self._state = self._model.predict(
                seen, state=self._state, episode_start=starts, deterministic=self._options.deterministic
            )
        if self._state is not None and context is None:
            hint = "Pass a gym_extensions.baselines.Context with the starts of the episodes."
            raise BenchError("needs-context", "The policy is recurrent.", "act()", hint)
        return np.asarray(actions)

    def policy(self) -> AnyPolicy | None:
        """The policy as plain arrays or as a network; None, with a warning, if it is neither."""
        shape, is_deterministic = self._spaces[0].shape, self._options.deterministic
        try:
            return sb3_policy.exported(self._model, is_deterministic, self._normalizer, shape)
        except BenchError as error:
            message = f"The policy is not stored, so the submission stays claimed. {error}"
            warnings.warn(message, stacklevel=2)
            return None

    def learn(self, env: agent.VectorEnv, steps: int) -> None:
        """Calls the model's ``learn``, which continues from the current state."""
        size = (env.num_envs, int(getattr(env, "batch_steps", PLACEHOLDER[1])))
        if self._size != size and not self._trained:
            self._create_model(*size)
        length = getattr(self._model, "n_steps", 0) if hasattr(self._model, "rollout_buffer") else 0
        if (rollout := length * env.num_envs) and -(-steps // rollout) * rollout > (1 + agent.EXCESS) * steps:
            message = f"The model trains whole rollouts of n_steps = {length} × {env.num_envs} environments, "
            message += f"of which none ends within {agent.EXCESS:.0%} of {steps:,} steps."
            hint = "Set n_steps=250, which divides the steps of every budget."
            raise BenchError("budget-exceeded", message, "learn()", hint)
        if self._options.fresh_buffer:
            buffer: Any = self._model.replay_buffer  # type: ignore[attr-defined]
            buffer.reset()
        wrapped = self._normalized(sb3_vec_env.BatchVecEnv(env))
        self._trained = True
        with self._learning.active():
            self._model.set_env(wrapped)
            self._train(steps)

    def _train(self, steps: int, *callbacks: Callable[..., bool]) -> None:
        """Trains the model in its environment. Functions are called before the callback of the options."""
        own = self._options.callback
        if not isinstance(own, list):
            own = [own if isinstance(own, BaseCallback) else ConvertCallback(own)]
        callback = [*map(ConvertCallback, callbacks), *own]
        restarts = not self._options.continue_counting
        self._model.learn(steps, callback=callback, reset_num_timesteps=restarts)

    def card(self) -> agent.Card:
        """The agent's description in the manifest, with the name of its class and its settings."""
        options = self._options
        return replace(
            options.card,
            evaluation="deterministic" if options.deterministic else "sampled",
            hyperparameters=options.manifest_settings(),
            stored_steps=stored_steps(self._model),
            parameters=num_parameters(self._model),
            packages=("stable-baselines3", "torch", *library(options.algorithm)[1]),
        )

    def save(self, path: Path) -> None:
        """Writes everything but the environments and the loggers, pickled, with the filled part of a buffer.

        SB3's own ``model.save`` leaves out the replay buffer, the keys of SBX and the global generators.
        """
        model: Any = copy.copy(self._model)
        model.env = model._vec_normalize_env = model._logger = None
        if (buffer := getattr(model, "replay_buffer", None)) is not None:
            model.replay_buffer = _with_rows(buffer, buffer.size())
        state = {name: value for name, value in vars(self).items() if name != "_options"}
        path.write_bytes(cloudpickle.dumps(state | {"_model": model}))

    def load(self, path: Path) -> None:
        vars(self).update(cloudpickle.loads(path.read_bytes()))
        model: Any = self._model
        if (buffer := getattr(model, "replay_buffer", None)) is not None:
            model.replay_buffer = _with_rows(buffer, buffer.buffer_size)


def _with_rows(buffer: Any, rows: int) -> Any:
    """A replay buffer with the filled rows, in arrays of ``rows`` rows."""
    resized, filled, allocated = copy.copy(buffer), buffer.size(), len(buffer.rewards)
    for name, values in vars(buffer).items():
        if isinstance(values, np.ndarray) and values.shape[:1] == (allocated,):
            new = np.zeros((rows, *values.shape[1:]), values.dtype)
            new[:filled] = values[:filled]
            setattr(resized, name, new)
    return resized


def num_parameters(model: BaseAlgorithm) -> int:
    """The number of a model's network parameters, target networks included."""
    total = sum(values.numel() for values in model.policy.parameters())
    states = [value for owner in (model, model.policy) for value in vars(owner).values()]
    for state in (each for each in states if hasattr(each, "apply_gradients")):  # flax's TrainState
        from jax.tree_util import tree_leaves

        trees = (state.params, getattr(state, "target_params", ()))
        total += sum(leaf.size for tree in trees for leaf in tree_leaves(tree))
    return int(total)


def stored_steps(model: BaseAlgorithm) -> int:
    """The transitions in a model's replay buffer, or in its rollouts if it has none."""
    buffer = getattr(model, "replay_buffer", None)
    steps = getattr(model, "n_steps", 0) if buffer is None else buffer.size()
    return int(steps) * model.n_envs
