"""What runs in the box: creates the agent from the stranger's file and does what the world commands.

Nothing here is trusted: once the agent's file is imported, its code can change all of it. That changes
nothing but its own training, because steps, returns, evaluations and files are the world's. This module is
imported after :func:`confine`, since libraries start threads.
"""

import io
import os
import sys
import tarfile
import traceback
from contextlib import ExitStack, suppress
from dataclasses import asdict
from importlib import util
from pathlib import Path
from typing import Any

import gymnasium as gym
import msgspec
import numpy as np

from gym_extensions import baselines
from gym_extensions.baselines import agent as agents, algorithms, generators
from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.isolated import frames
from gym_extensions.errors import BenchError
from gym_extensions.files import remove
from gym_extensions.submissions.policies.onnx import OnnxPolicy

AGENT, CHECKPOINT, TEXT = Path("/agent"), Path("/tmp/agent.npz"), 2000
Reply = tuple[Any] | tuple[Any, bytes]


class Guest:
    """Answers the commands of the world: each is a method with the arguments and bytes that it sent."""

    def __init__(self, reader: int, writer: int, limit: int) -> None:
        self.pipe, self.limit = frames.Pipe(reader, writer), limit
        self._make: Any
        self._agent: Any
        self._network: Any
        self._scopes: list[ExitStack] = []
        self.pipe.write(frames.STARTED)

    def serve(self, until: bytes) -> None:
        """Answers commands until a frame of the kind ``until``."""
        while True:
            try:
                if self.pipe.read_kind() == until:
                    return
                (name, arguments), blob = self.pipe.read_message(self.limit)
                reply: Reply | None = getattr(self, name)(*arguments, *([blob] if blob else []))
                sys.stdout.flush()
                if reply is not None:
                    self.pipe.write_message(frames.REPLY, *reply)
            except EOFError:  # the world has closed the pipe
                os._exit(0)
            except BaseException as error:  # noqa: BLE001 - also SystemExit: the world has to know
                text = _described(error)[:TEXT]
                with suppress(Exception):  # the agent may have closed it
                    sys.stdout.flush()
                self.pipe.write_message(frames.ERROR, text)
                os._exit(1)

    def scopes(self, closed: int, opened: list[int | None]) -> Reply:
        """Leaves and enters what keeps or seeds the global random generators in the world at the moment."""
        for _ in range(closed):
            self._scopes.pop().close()
        for seed in opened:
            self._scopes.append(ExitStack())
            self._scopes[-1].enter_context(generators.preserved_global_generators(seed))
        return (None,)

    def load_agent(self, file: str, attribute: str) -> Reply:
        """Imports the agent's file and finds the factory; without a file it is an agent of this project."""

        def train(*_: Any, **__: Any) -> None:
            raise RuntimeError("Call it under `if __name__ == '__main__':`, because the world trains.")

        vars(baselines).update(train=train, record=train)
        if file:
            path = AGENT / file
            name = path.stem if path.stem not in sys.modules else f"agent_{path.stem}"
            spec = util.spec_from_file_location(name, path / "__init__.py" if path.is_dir() else path)
            assert spec is not None
            assert spec.loader is not None
            module = sys.modules[name] = util.module_from_spec(spec)
            spec.loader.exec_module(module)
            self._make = algorithms.factory_in(module, attribute)
        else:
            self._make = algorithms.factory(attribute)
        generators.seed_global_generators()  # the file may have loaded torch
        return (None,)

    def create(self, name: str, spaces: Any, seed: int, blob: bytearray) -> Reply:
        """Creates the agent. Replies what it asks to observe, and whether it can be saved."""
        observations, self._actions = _spaces(spaces, blob).values()
        self._agent = agents.create(self._make, (observations, self._actions), seed, name)
        if agents.autoreset_mode_of(self._agent, name) is not gym.vector.AutoresetMode.NEXT_STEP:
            hint = "Remove its autoreset_mode, or train without --isolated."
            raise BenchError("bad-agent", "In a box, the autoreset mode is NEXT_STEP.", name, hint)
        observes = msgspec.to_builtins(agents.observes_of(self._agent, name))
        return ((observes, isinstance(self._agent, agents.Resumable)),)

    def card(self) -> Reply:
        """Its card; None if it has none."""
        return (asdict(self._agent.card()) if isinstance(self._agent, agents.Described) else None,)

    def policy(self) -> Reply:
        """The arrays of its policy; None if it has none."""
        policy = agents.policy_of(self._agent)
        return (None,) if policy is None else frames.packed(policy.arrays())

    def save(self) -> Reply:
        """What it saves."""
        agents.save(self._agent, CHECKPOINT)
        packed = io.BytesIO()
        with tarfile.open(fileobj=packed, mode="w") as archive:  # it may be a folder
            archive.add(CHECKPOINT, CHECKPOINT.name)
        remove(CHECKPOINT)
        return None, packed.getvalue()

    def load(self, blob: bytearray) -> Reply:
        with tarfile.open(fileobj=io.BytesIO(blob)) as archive:
            archive.extraction_filter = getattr(tarfile, "data_filter", None)  # from Python 3.11.4 on
            archive.extractall(CHECKPOINT.parent)
        self._agent = agents.load(self._agent, CHECKPOINT)
        remove(CHECKPOINT)
        return (None,)

    def act(self, label: tuple[str, int] | None, shapes: Any, blob: bytearray) -> None:
        """Sends its actions."""
        observations, starts = frames.unpacked(shapes, blob).values()
        context = agents.Context(starts, label and agents.TaskLabel(*label))
        self.send_actions(agents.action_function(self._agent)(observations, context), len(observations))

    def send_actions(self, actions: Any, num_envs: int) -> None:
        """Sends actions as float32 or float64. Raises ``ValueError`` if they are none of their shape."""
        array, shape = np.asarray(actions), (num_envs, *self._actions.shape)
        if array.dtype.kind not in "biuf" or array.shape != shape:
            shown = f"they have the shape {array.shape} and the dtype {array.dtype}"
            raise ValueError(f"Actions are numbers of shape {shape}, one row per environment; {shown}")
        kind = frames.FLOAT32 if array.dtype == np.float32 else frames.FLOAT64
        self.pipe.write(kind, array.astype(frames.ACTION_TYPES[kind], copy=False).tobytes())

    def learn(self, steps: int, attributes: dict[str, Any], spaces: Any, blob: bytearray) -> Reply:
        """Trains it in an environment that is the world's."""
        self._agent.learn(GuestEnv(self, attributes, _spaces(spaces, blob)), steps)
        return (None,)

    def network(self, blob: bytearray) -> Reply:
        """In a box of its own, without an agent: reads a network and replies its inputs and outputs."""
        self._network = OnnxPolicy(bytes(blob))
        tables = (part.items() for part in self._network.network)
        return ([{name: (np.dtype(kind).str, shape) for name, (kind, shape) in part} for part in tables],)

    def run(self, shapes: Any, blob: bytearray) -> Reply:
        """Runs the network."""
        outputs = self._network.run(frames.unpacked(shapes, blob))
        return frames.packed({str(index): output for index, output in enumerate(outputs)})


class GuestEnv(gym.vector.VectorEnv[Any, Any, Any]):
    """The vector environment of ``learn``: every step and reset is the world's. Infos are empty."""

    def __init__(self, guest: Guest, attributes: dict[str, Any], spaces: dict[str, gym.spaces.Box]) -> None:
        self.autoreset_mode = gym.vector.AutoresetMode.NEXT_STEP
        self.metadata = {"autoreset_mode": self.autoreset_mode}
        self._guest, self._np_random = guest, np.random.default_rng()
        self._np_random.bit_generator.state = attributes.pop("np_random")
        for name, value in (attributes | spaces).items():
            setattr(self, name, tuple(value) if isinstance(value, list) else value)
        if "env_tasks" in attributes:
            self.env_tasks = np.array(attributes["env_tasks"], np.int64)
        seen = spaces["single_observation_space"]
        self._observations, self._dtype = (self.num_envs, *seen.shape), seen.dtype

    def __getattr__(self, name: str) -> Any:
        if name in agents.NEEDS:
            raise agents.not_requested(f"env.{name}", agents.NEEDS[name])
        raise AttributeError(f"The environment has no attribute {name!r} in the box.")

    @property
    def unwrapped(self) -> Any:
        return self

    def reset(
        self, *, seed: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Resets all environments, or those in ``options["reset_mask"]``, with the run's own seeds."""
        mask = np.zeros(self.num_envs, np.bool_)
        if (chosen := (options or {}).get("reset_mask")) is not None:
            mask = np.asarray(chosen)
            if mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or not mask.any():
                hint = f"Give {self.num_envs} booleans, at least one of them true."
                raise BenchError("bad-reset-mask", f"reset_mask is {chosen!r}.", "env.reset()", hint)
        self._guest.pipe.write(frames.RESET, mask.tobytes())
        self._guest.serve(frames.RESET_DONE)
        return self._guest.pipe.read_array(self._observations, self._dtype), {}

    def step(self, actions: Any) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        """Observations, rewards, terminations, truncations, and no infos."""
        self._guest.send_actions(actions, self.num_envs)
        self._guest.serve(frames.STEPPED)
        read, size = self._guest.pipe.read_array, (self.num_envs,)
        observations, rewards = read(self._observations, self._dtype), read(size, np.float64)
        terminated, truncated = read(size, np.bool_), read(size, np.bool_)
        return observations, rewards, terminated, truncated, {}


def _spaces(spaces: dict[str, Any], blob: bytearray) -> dict[str, gym.spaces.Box]:
    """The spaces that the world described, which sample as the world's do."""
    bounds, made = frames.unpacked(spaces["bounds"], blob), dict[str, Any]()
    for name, state in spaces["generators"].items():
        low, high = bounds[f"{name}.low"], bounds[f"{name}.high"]
        made[name] = gym.spaces.Box(low, high, low.shape, low.dtype.type)
        made[name].np_random.bit_generator.state = state
    return made


def _described(error: BaseException) -> str:
    """An exception with the line of the agent's file that raised it."""
    text = f"{type(error).__name__}: {error}".rstrip(": ")
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if frame.filename.startswith(f"{AGENT}/"):
            return f"{text} ({Path(frame.filename).name}, line {frame.lineno}, in {frame.name})"
    return text
