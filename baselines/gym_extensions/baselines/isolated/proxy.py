"""The agent that the training loop sees when the real one is in a box."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Array, Card, Context, VectorEnv
from gym_extensions.baselines.isolated import frames
from gym_extensions.baselines.isolated.box import Box
from gym_extensions.baselines.isolated.confine import Limits
from gym_extensions.errors import BenchError
from gym_extensions.files import write_bytes
from gym_extensions.submissions.manifest import Observes
from gym_extensions.submissions.policies.files import AnyPolicy
from gym_extensions.submissions.policies.mlp import HINT, Policy
from gym_extensions.submissions.policies.mlp_arrays import array_errors
from gym_extensions.submissions.policies.onnx import ONNX, Network, OnnxPolicy, Tensor
from gym_extensions.submissions.problem import cut, escape

ATTRIBUTES = (
    "batch_steps",
    "budget_steps",
    "num_envs",
    "task_ids",
    "env_task_ids",
    "env_tasks",
    "stage",
    "num_tasks",
)
"""Attributes of the environment that the guest is told, as far as the agent asked for them."""
SPACES = ("single_observation_space", "single_action_space", "observation_space", "action_space")
BAD_CARD = "See gym_extensions.baselines.Card."


DEFAULTS = Limits()


@dataclass(frozen=True)
class IsolatedAgent:
    """A factory whose agents live in boxes.

    Args:
        name: ``path/agent.py:factory``, ``module:factory`` of a module in this folder, or an agent of this
            project. No file is imported here.
        limits: of each box.

    Raises ``BenchError`` if there is no such file or agent.
    """

    name: str
    limits: Limits = DEFAULTS

    def __post_init__(self) -> None:
        # Its name in manifests and errors, as that of other factories.
        path, attribute = self.located()
        name = algorithms.name_of(f"{path.stem}:{attribute}" if path else attribute)
        object.__setattr__(self, "__name__", name)
        if path is None and attribute not in algorithms.names():
            algorithms.factory(attribute)  # says which names there are

    def located(self) -> tuple[Path | None, str]:
        """The agent's file, or its folder, and the factory; None and its name if it is this project's."""
        place, colon, attribute = self.name.rpartition(":")
        if not colon:
            return None, self.name
        path = Path(place)
        if path.suffix != ".py" and not path.is_dir():
            path = Path(*place.split("."))
            path = path if path.is_dir() else path.with_suffix(".py")
        if not path.exists() or (path.is_dir() and not (path / "__init__.py").is_file()):
            hint = "Name it as path/to/agent.py:make."
            raise BenchError("unknown-agent", f"There is no file {path}.", self.name, hint)
        return path, attribute

    @property
    def written(self) -> str:
        """The agent's name without its folder, as the command of a run states it."""
        path, attribute = self.located()
        return f"{path.name}:{attribute}" if path else attribute

    def __call__(self, observation_space: gym.Space[Any], action_space: gym.Space[Any], seed: int) -> Proxy:
        path, attribute = self.located()
        box = Box(algorithms.name_of(self), path, self.limits)
        box.ask("at its import", "load_agent", path.name if path else "", attribute)
        spaces, blob = _described({"observations": observation_space, "actions": action_space})
        (*observes, saves), _ = box.ask("make()", "create", box.name, spaces, seed, blob=blob)
        make = ResumableProxy if saves is True else Proxy
        return make(box, Observes(*(asked is True for asked in observes[:3])), action_space.shape or ())


class Proxy:
    """An agent in a box: what the training loop asks of it is done by the guest."""

    def __init__(self, box: Box, observes: Observes, action_shape: tuple[int, ...]) -> None:
        self.box, self.observes, self._action_shape = box, observes, action_shape

    @property
    def box_seconds(self) -> float:
        """The processor time of the guest so far, as the world's kernel counts it."""
        return self.box.cpu_seconds()

    def card(self) -> Card:
        """The agent's card, as far as its values have the right names; the checks of cards come after."""
        tables, _ = self.box.ask("card()", "card")
        if tables is None:
            return Card(self.box.name)
        try:
            lists = {name: tuple(tables[name]) for name in ("tuning_tasks", "packages")}
            return Card(**(tables | lists))
        except (TypeError, KeyError) as error:
            raise BenchError("bad-card", f"The card cannot be read: {error}.", "card()", BAD_CARD) from error

    def policy(self) -> AnyPolicy | None:
        """The agent's policy: plain arrays, which need no parser, or a network in a box of its own."""
        shapes, blob = self.box.ask("policy()", "policy", limit=self.box.limits.policy)
        if shapes is None:
            return None
        with self.box.at(lambda: "policy()"):
            arrays = frames.unpacked(shapes, blob)
        if list(arrays) == [ONNX]:
            return BoxedNetwork(arrays[ONNX].tobytes(), self.box.limits)
        if error := next(array_errors(arrays), None):
            raise BenchError("bad-policy", cut(error), "policy()", HINT)
        return Policy.from_arrays(arrays)

    def act(self, observations: Array, context: Context) -> Array:
        """The agent's actions, of any values."""
        label = context.label and (context.label.id, context.label.index)
        shapes, blob = frames.packed({"observations": observations, "starts": context.episode_starts})
        with self.box.at(lambda: "act()"):
            self.box.send("act", label, shapes, blob=blob)
            return self._actions(self.box.pipe.read_kind(), len(observations), "act()")

    def _actions(self, kind: bytes, num_envs: int, where: str) -> Array:
        """The actions in a frame whose kind was read."""
        shape = (num_envs, *self._action_shape)
        if kind in frames.ACTION_TYPES:
            dtype = frames.ACTION_TYPES[kind]
            return np.frombuffer(self.box.pipe.read(math.prod(shape) * dtype.itemsize), dtype).reshape(shape)
        if kind == frames.NO_ACTIONS:
            message = f"The agent returned {cut(escape(self.box.pipe.read_text()))} as actions."
            hint = f"Return an array of numbers of shape {shape}, one row per environment."
            raise BenchError("bad-actions", message, where, hint)
        self.box.reply(kind, 0)
        raise frames.ProtocolError("a reply in place of actions")

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Trains the agent: does in the environment what the guest asks for, until it is done.

        Raises ``BenchError`` also if it resets more environments than an agent can have episodes.
        """
        known: Any = env
        told = {name: value for name in ATTRIBUTES if (value := getattr(known, name, None)) is not None}
        if "env_tasks" in told:
            told["env_tasks"] = told["env_tasks"].tolist()
        told["np_random"] = known.np_random.bit_generator.state
        spaces, blob = _described({name: getattr(env, name) for name in SPACES})
        pipe, dtype, resets = self.box.pipe, env.single_observation_space.dtype, 0
        with self.box.at(lambda: f"learn(), after {known.taken:,} of {steps:,} steps"):
            self.box.send("learn", steps, told, spaces, blob=blob)
            while (kind := pipe.read_kind()) != frames.REPLY:
                if kind in (frames.RESET, frames.MASKED_RESET):
                    size = env.num_envs
                    mask = (
                        np.frombuffer(pipe.read(size), np.uint8) != 0 if kind == frames.MASKED_RESET else None
                    )
                    resets += size if mask is None else int(mask.sum())
                    if resets > steps + 100 * size:
                        message = f"The agent reset {resets:,} environments."
                        raise self.box.error("too-many-resets", message, "Take steps between resets.")
                    first, _ = env.reset(options=None if mask is None else {"reset_mask": mask})
                    self.box.synchronize()
                    pipe.write(frames.RESET_DONE, np.asarray(first, dtype).tobytes())
                else:
                    actions = self._actions(kind, env.num_envs, "env.step() in learn()")
                    seen, rewards, *ends, _ = env.step(actions)
                    self.box.synchronize()
                    results = np.asarray(rewards, np.float64), *(np.asarray(end, np.bool_) for end in ends)
                    parts = (each.tobytes() for each in (np.asarray(seen, dtype), *results))
                    pipe.write(frames.STEPPED, *parts)
            self.box.reply(kind, 0)


class ResumableProxy(Proxy):
    """An agent in a box that can be saved. The world stores what it saves and never reads it."""

    def save(self, path: Path) -> None:
        is_written, saved = self.box.ask("save()", "save", limit=self.box.limits.files)
        if is_written is not None:
            write_bytes(path, bytes(saved))

    def load(self, path: Path) -> None:
        self.box.ask("load()", "load", blob=path.read_bytes())


class BoxedNetwork(OnnxPolicy):
    """A network that is read and run in a box of its own, because its reader is code that files can break."""

    def __init__(self, data: bytes, limits: Limits) -> None:
        self._data, self._states = data, {}
        self._box, self._limit = Box("the policy", None, limits), limits.policy
        reply, _ = self._box.ask("policy()", "network", blob=data)
        try:
            inputs, outputs = (
                {
                    name: Tensor(frames.ARRAY_TYPES[dtype].type, tuple(shape))
                    for name, (dtype, shape) in part.items()
                }
                for part in reply
            )
            self.network = Network(inputs, outputs)
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            message = "The network has inputs or outputs that are not allowed."
            raise BenchError("bad-policy", message, "policy()", "See docs/policies.md.") from error

    def run(self, feeds: Mapping[str, Array]) -> Sequence[Array]:
        shapes, blob = frames.packed(feeds)
        reply, results = self._box.ask("act()", "run", shapes, blob=blob, limit=self._limit)
        return list(frames.unpacked(reply, results).values())


def _described(spaces: dict[str, gym.Space[Any]]) -> tuple[dict[str, Any], bytes]:
    """Spaces with their generators for the guest: JSON and the bytes of the bounds."""
    bounds, states = dict[str, Array](), dict[str, Any]()
    for name, space in spaces.items():
        if not isinstance(space, gym.spaces.Box):
            message = f"In a box, spaces are boxes of numbers; this one is {space}."
            raise BenchError("no-box", message, name, "Train without --isolated.")
        bounds |= {f"{name}.low": space.low, f"{name}.high": space.high}
        states[name] = space.np_random.bit_generator.state
    shapes, blob = frames.packed(bounds)
    return {"bounds": shapes, "generators": states}, blob
