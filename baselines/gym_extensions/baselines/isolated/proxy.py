"""The agent that the training loop sees when the real one is in a box."""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import msgspec
import numpy as np

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import NEEDS, Array, Card, Context, VectorEnv
from gym_extensions.baselines.isolated import confine, frames
from gym_extensions.baselines.isolated.box import Box
from gym_extensions.baselines.training.environment import SPACES
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.files import write_bytes
from gym_extensions.submissions import manifest, problem
from gym_extensions.submissions.policies import files, mlp, mlp_arrays, onnx

ATTRIBUTES = ("batch_steps", "budget_steps", "num_envs", *NEEDS)
"""Attributes of the environment that the guest is told, as far as the agent asked for them."""
DEFAULTS = confine.Limits()
Tensors = dict[str, tuple[frames.ArrayType, frames.Shape]]


class IsolatedAgent:
    """A factory whose agents live in boxes.

    Args:
        name: ``path/agent.py:factory``, ``folder:factory`` of a package, or an agent of this project. No file
            is imported here.
        limits: of each box; in a job, also those of the job.

    Raises ``BenchError`` if there is no such file or agent.
    """

    def __init__(self, name: str, limits: confine.Limits = DEFAULTS) -> None:
        self.limits = limits
        self.path, self.attribute = algorithms.place_of(name)  # a package is mounted whole
        if self.path is None and name not in algorithms.names():
            message = "It is no file and no agent of this project."
            raise BenchError("unknown-agent", message, name, algorithms.NAME_A_FILE)
        self.written = f"{self.path.name}:{self.attribute}" if self.path else name  # in the commands of runs
        self.__name__ = algorithms.name_of(name)

    def for_job(self, group: TaskGroup, steps: int) -> "IsolatedAgent":
        """The same factory with at most the processor time of a job with this group and training steps."""
        found, own = copy(self), confine.Limits.of([(group, steps)])
        found.limits = replace(self.limits, cpu_seconds=min(self.limits.cpu_seconds, own.cpu_seconds))
        return found

    def __call__(self, observation_space: gym.Space[Any], action_space: gym.Space[Any], seed: int) -> "Proxy":
        box = Box(self.__name__, self.path, self.limits)
        box.ask("at its import", "load_agent", self.path.name if self.path else "", self.attribute)
        spaces, blob = _described({"observations": observation_space, "actions": action_space})
        reply, _ = box.ask("make()", "create", box.name, spaces, seed, blob=blob)
        with box.at("make()"):
            observes, saves = msgspec.convert(reply, tuple[manifest.Observes, bool])
        return (ResumableProxy if saves else Proxy)(box, observes, action_space.shape or ())


class Proxy:
    """An agent in a box: what the training loop asks of it is done by the guest."""

    def __init__(self, box: Box, observes: manifest.Observes, action_shape: tuple[int, ...]) -> None:
        self.box, self.observes, self._action_shape = box, observes, action_shape

    @property
    def box_used(self) -> tuple[float, float]:
        """The processor time in seconds and the peak memory in MB of the guest so far."""
        return self.box.used()

    def card(self) -> Card:
        """The agent's card, as far as its values have the right types; the checks of cards come after."""
        tables, _ = self.box.ask("card()", "card")
        try:
            return Card(self.box.name) if tables is None else msgspec.convert(tables, Card)
        except ValueError as error:
            hint = "See gym_extensions.baselines.Card."
            raise BenchError("bad-card", f"The card cannot be read: {error}.", "card()", hint) from error

    def policy(self) -> files.AnyPolicy | None:
        """The agent's policy: plain arrays, which need no parser, or a network in a box of its own."""
        shapes, blob = self.box.ask("policy()", "policy", limit=self.box.limits.policy)
        if shapes is None:
            return None
        with self.box.at("policy()"):
            arrays = frames.unpacked(shapes, blob)
        if list(arrays) == [onnx.ONNX]:
            return BoxedNetwork(arrays[onnx.ONNX].tobytes(), self.box.limits)
        if error := next(mlp_arrays.array_errors(arrays), None):
            raise BenchError("bad-policy", problem.cut(error), "policy()", mlp.HINT)
        return mlp.Policy.from_arrays(arrays)

    def act(self, observations: Array, context: Context) -> Array:
        """The agent's actions, of any values."""
        label = context.label and (context.label.id, context.label.index)
        shapes, blob = frames.packed({"observations": observations, "starts": context.episode_starts})
        with self.box.at("act()"):
            self.box.send("act", label, shapes, blob=blob)
            return self._actions(self.box.pipe.read_kind(), len(observations))

    def _actions(self, kind: bytes, num_envs: int) -> Array:
        """The actions in a frame whose kind was read."""
        if kind in frames.ACTION_TYPES:
            return self.box.pipe.read_array((num_envs, *self._action_shape), frames.ACTION_TYPES[kind])
        self.box.reply(kind, 0)
        raise frames.ProtocolError("a reply in place of actions")

    def learn(self, env: VectorEnv, steps: int) -> None:
        """Trains the agent: does in the environment what the guest asks for, until it is done.

        Raises ``BenchError`` also if it resets more environments than an agent can have episodes.
        """
        known: Any = env
        told = {name: value for name in ATTRIBUTES if (value := getattr(known, name, None)) is not None}
        told["np_random"] = known.np_random.bit_generator.state
        spaces, blob = _described({name: getattr(env, name) for name in SPACES})
        pipe, dtype, resets = self.box.pipe, env.single_observation_space.dtype, 0
        with self.box.at(lambda: f"learn(), {known.place}"):
            self.box.send("learn", steps, told, spaces, blob=blob)
            while (kind := pipe.read_kind()) != frames.REPLY:
                if kind == frames.RESET:
                    mask = pipe.read_array((env.num_envs,), np.uint8) != 0
                    resets += int(mask.sum()) or env.num_envs
                    if resets > steps + 100 * env.num_envs:
                        message = f"The agent reset {resets:,} environments."
                        raise self.box.error("too-many-resets", message, "Take steps between resets.")
                    first, _ = env.reset(options={"reset_mask": mask} if mask.any() else None)
                    self.box.synchronize()
                    pipe.write(frames.RESET_DONE, np.asarray(first, dtype).tobytes())
                else:
                    seen, rewards, *ends, _ = env.step(self._actions(kind, env.num_envs))
                    self.box.synchronize()
                    results = np.asarray(rewards, np.float64), *(np.asarray(end, np.bool_) for end in ends)
                    parts = (each.tobytes() for each in (np.asarray(seen, dtype), *results))
                    pipe.write(frames.STEPPED, *parts)
            self.box.reply(kind, 0)


class ResumableProxy(Proxy):
    """An agent in a box that can be saved. The world stores what it saves and never reads it."""

    def save(self, path: Path) -> None:
        write_bytes(path, bytes(self.box.ask("save()", "save", limit=self.box.limits.files)[1]))

    def load(self, path: Path) -> None:
        self.box.ask("load()", "load", blob=path.read_bytes())


class BoxedNetwork(onnx.OnnxPolicy):
    """A network that is read and run in a box of its own, because its reader is code that files can break."""

    def __init__(self, data: bytes, limits: confine.Limits) -> None:
        self._data, self._states, self._limit = data, {}, limits.policy
        self._box = Box("the policy", None, limits)
        parts, _ = self._box.ask("policy()", "network", blob=data)
        try:
            tables = msgspec.convert(parts, tuple[Tensors, Tensors])
        except ValueError as error:
            message = "The network has inputs or outputs that are not allowed."
            raise BenchError("bad-policy", message, "policy()", "See docs/policies.md.") from error
        self.network = onnx.Network(
            *(
                {name: onnx.Tensor(np.dtype(kind).type, shape) for name, (kind, shape) in part.items()}
                for part in tables
            )
        )

    def run(self, feeds: Mapping[str, Array]) -> Sequence[Array]:
        shapes, blob = frames.packed(feeds)
        reply, results = self._box.ask("act()", "run", shapes, blob=blob, limit=self._limit)
        with self._box.at("act()"):
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
