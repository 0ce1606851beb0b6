"""The single and the vector environment of MuJoCo tasks, and the table of bodies that have them."""

import copy
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
from gymnasium.envs.mujoco import (
    MujocoEnv,
    half_cheetah_v5,
    hopper_v5,
    humanoid_v5,
    humanoidstandup_v5,
    pusher_v5,
    walker2d_v5,
)
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from gym_extensions.catalog import bodies, tasks
from gym_extensions.envs import effects, interfaces, vector_env
from gym_extensions.envs.mujoco import arms, base, humanoid, planar, simulation
from gym_extensions.envs.mujoco.model import asset, compile_model
from gym_extensions.errors import BenchError


class Implementation(NamedTuple):
    """What makes the environments of a body: its rules and its camera."""

    rules: type[base.Rules]
    camera: Mapping[str, Any]


_LYING = humanoidstandup_v5.DEFAULT_CAMERA_CONFIG
_ARM = pusher_v5.DEFAULT_CAMERA_CONFIG
IMPLEMENTATIONS: dict[str, Implementation] = {
    "Hopper": Implementation(planar.PlanarRules, hopper_v5.DEFAULT_CAMERA_CONFIG),
    "Walker2d": Implementation(planar.PlanarRules, walker2d_v5.DEFAULT_CAMERA_CONFIG),
    "HalfCheetah": Implementation(planar.HalfCheetahRules, half_cheetah_v5.DEFAULT_CAMERA_CONFIG),
    "Humanoid": Implementation(humanoid.HumanoidRules, humanoid_v5.DEFAULT_CAMERA_CONFIG),
    "HumanoidStandup": Implementation(humanoid.HumanoidStandupRules, _LYING),
    "HumanoidStandupAndRun": Implementation(humanoid.HumanoidStandupAndRunRules, _LYING),
    "Pusher": Implementation(arms.PusherRules, _ARM),
    "Striker": Implementation(arms.StrikerRules, _ARM),
}
"""One row per body of the catalog that has a MuJoCo model."""

ONLY = np.zeros(1, np.intp)
"""The index of the one environment, for rules and effects, which act on many."""
SKIPPED = ("model", "data", "mujoco_renderer", "template", "_shard")
"""Attributes that a copy makes again."""


class _Simulation(interfaces.Physics):
    """The simulation of a single environment."""

    def __init__(self, env: MujocoEnv) -> None:
        self._env = env

    def field(self, name: str) -> interfaces.Array:
        return getattr(self._env.data, name)[None]

    def reset(self, indices: interfaces.Indices, starts: interfaces.Starts) -> None:
        for name, rows in starts.items():
            getattr(self._env.data, name)[...] = rows[0]
        mujoco.mj_forward(self._env.model, self._env.data)

    def step(self, ctrl: NDArray[Any], indices: interfaces.Indices | None) -> None:
        self._env.do_simulation(ctrl[0], self._env.frame_skip)


class TaskEnv(MujocoEnv):
    """The environment of a MuJoCo task: Gymnasium's simulation and rendering with the rules of its body.

    Tasks without variations equal Gymnasium's v5 environments bit for bit, but for lengths in rewards of
    Pusher and infos of Humanoid, which have the same last bit on all processors here. Deep copies and pickles
    continue exactly where the original is, with the model of the task. ``rendering`` is ``render_mode``, and
    Gymnasium's sizes and camera arguments. Raises ``BenchError`` if a variation does not fit the body.
    """

    metadata = {"render_modes": ["human", "rgb_array", "depth_array", "rgbd_tuple"]}  # noqa: RUF012
    observation_space: Box
    action_space: Box

    def __init__(self, task: tasks.Task, **rendering: Any) -> None:
        self.task, self._rendering, self._is_set = task, rendering, False
        effects.check_variations(task)
        body = IMPLEMENTATIONS[task.base]
        camera = {"default_camera_config": body.camera}
        super().__init__(str(asset(task.body)), task.body.frame_skip, None, **(camera | rendering))
        self.metadata = self.metadata | {"render_fps": round(1 / self.dt)}
        rest = self.init_qpos.copy(), self.init_qvel.copy()
        self.template = interfaces.Template(task, self.model, self.frame_skip, *rest)
        self._shard = base.Shard(body.rules, _Simulation(self), [self.template], ONLY)
        size, total = self._shard.rules.observe().shape[1], self._shard.observe().shape[1]
        low, high = np.full(total, -np.inf), np.full(total, np.inf)
        low[size:], high[size:] = 0.0, 1.0
        self.observation_space = Box(low, high, dtype=np.float64)

    def _initialize_simulation(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        model = compile_model(self.task)
        size = model.vis.global_
        size.offwidth, size.offheight = max(size.offwidth, self.width), max(size.offheight, self.height)
        return model, mujoco.MjData(model)

    def __getstate__(self) -> dict[str, Any]:
        others = {name: value for name, value in self.__dict__.items() if name not in SKIPPED}
        parts: list[Any] = [self._shard.rules, *self._shard.effects]
        kept = [{name: getattr(part, name) for name in part.kept} for part in parts]
        return {"attributes": others, "data": copy.copy(self.data), "steps": self._shard.steps, "kept": kept}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Makes the environment again and continues where the copied one was."""
        attributes = state["attributes"]
        new = type(self)(attributes["task"], **attributes["_rendering"])
        self.__dict__.update(new.__dict__ | attributes)
        mujoco.mj_copyData(self.data, self.model, state["data"])
        self._shard.steps[:] = state["steps"]
        for part, kept in zip((self._shard.rules, *self._shard.effects), state["kept"], strict=True):
            part.__dict__.update(kept)

    def reset_model(self) -> interfaces.Array:
        """Returns the first observation, after the draws of the body and of the effects."""
        self._shard.reset(ONLY, [self.np_random])
        self._is_set = True
        return self._get_obs()

    def _get_reset_info(self) -> dict[str, Any]:
        return {name: rows[0] for name, rows in self._shard.rules.reset_infos().items()}

    def set_state(self, qpos: interfaces.Array, qvel: interfaces.Array) -> None:
        super().set_state(qpos, qvel)  # type: ignore[no-untyped-call]
        self._is_set = True

    def step(self, action: Any) -> tuple[interfaces.Array, Any, bool, bool, dict[str, Any]]:
        """Returns observation, reward, whether the body ended the episode, False, and infos.

        The info has ``is_success``, a bool, if the task defines success.

        Raises:
            BenchError: the action's shape differs, or a value is not a finite number.
            ResetNeededError: the environment was never reset.
        """
        interfaces.require_reset(self._is_set, self.task.id)
        actions: NDArray[Any] = interfaces.check_actions(action, (self.model.nu,), self.task.id)[None]
        rewards, ended = self._shard.step(actions, None)
        infos = {name: rows[0] for name, rows in self._shard.step_infos().items()}
        if bodies.IS_SUCCESS in infos:
            infos[bodies.IS_SUCCESS] = bool(infos[bodies.IS_SUCCESS])
        if self.render_mode == "human":
            self.render()  # type: ignore[no-untyped-call]
        return self._get_obs(), rewards[0], bool(ended[0]), False, infos

    def _get_obs(self) -> interfaces.Array:
        return self._shard.observe()[0]


LAYOUT = (
    *("nq", "nv", "nu", "na", "nbody", "njnt", "ngeom", "nsite", "ncam", "nlight", "nmesh", "nmocap"),
    *("neq", "ntendon", "nsensor", "nsensordata", "nuserdata", "nplugin"),
)
"""Sizes of MjModel that the simulations of one batch have in common."""


def layout(template: interfaces.Template) -> tuple[object, ...]:
    """Returns the rules, effects and model sizes that the environments of a shard share."""
    task, model = template.task, template.model
    sizes = tuple(int(getattr(model, name)) for name in LAYOUT)
    return task.base, task.max_steps, template.frame_skip, model.opt.timestep, sizes, effects.shard_keys(task)


class MujocoVectorEnv(vector_env.TaskVectorEnv):
    """MuJoCo environments stepped together, in shards in the order of each one's first environment.

    ``envs[i]`` is a single environment of the task of environment i, from which the model and spaces are.
    Results of the shards are put together in the order of the environments; a single shard's are passed on.
    They are not copied, because rules and effects hold views of the engine's memory.
    """

    def __init__(self, envs: Sequence[TaskEnv], num_threads: int, autoreset_mode: AutoresetMode) -> None:
        spaces = envs[0].observation_space, envs[0].action_space
        super().__init__([env.task for env in envs], spaces, autoreset_mode)
        templates = [env.template for env in envs]
        members: dict[tuple[object, ...], list[int]] = {}
        for index, template in enumerate(templates):
            members.setdefault(layout(template), []).append(index)
        self._shards = []
        for indices in members.values():
            own = [templates[index] for index in indices]
            rules = IMPLEMENTATIONS[own[0].task.base].rules
            engine = simulation.PooledPhysics if rules.needs_contact_forces else simulation.BatchPhysics
            models = [template.model for template in own]
            physics = engine(models, own[0].frame_skip, num_threads, rules.fields)
            self._shards.append(base.Shard(rules, physics, own, np.array(indices)))

    def __getstate__(self) -> dict[str, Any]:
        hint = "Make others, and reset them with the same seeds."
        raise BenchError("no-copy", "The environments cannot be copied.", vector_env.WHERE, hint)

    def _start(self, chosen: interfaces.Flags) -> None:
        for shard in self._shards:
            rows = np.flatnonzero(chosen[shard.members])
            if len(rows):
                shard.reset(rows, [self._generator(int(index)) for index in shard.members[rows]])

    def _advance(
        self, actions: NDArray[Any], resting: interfaces.Flags | None
    ) -> tuple[interfaces.Array, interfaces.Flags]:
        if len(self._shards) == 1:
            return self._shards[0].step(actions, None if resting is None else np.flatnonzero(~resting))
        rewards, terminations = np.empty(self.num_envs), np.empty(self.num_envs, np.bool_)
        for shard in self._shards:
            rows = None if resting is None else np.flatnonzero(~resting[shard.members])
            rewards[shard.members], terminations[shard.members] = shard.step(actions[shard.members], rows)
        return rewards, terminations

    def _observe(self) -> interfaces.Array:
        if len(self._shards) == 1:
            return self._shards[0].observe()
        observations: interfaces.Array = np.empty(self.observation_space.shape or ())
        for shard in self._shards:
            observations[shard.members] = shard.observe()
        return observations

    def _step_infos(self) -> list[vector_env.Part]:
        return [(shard.members, shard.step_infos()) for shard in self._shards]

    def _reset_infos(self) -> list[vector_env.Part]:
        return [(shard.members, shard.rules.reset_infos()) for shard in self._shards]

    def states(self) -> dict[str, interfaces.Array]:
        self._require_state()
        states: dict[str, interfaces.Array] = {}
        for shard in self._shards:
            for name, rows in shard.physics.states().items():
                blank = np.full((self.num_envs, *rows.shape[1:]), np.nan)
                states.setdefault(name, blank)[shard.members] = rows
        return states

    def close_extras(self, **kwargs: Any) -> None:
        for shard in self._shards:
            shard.physics.close()
