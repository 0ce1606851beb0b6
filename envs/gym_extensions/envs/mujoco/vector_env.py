"""MuJoCo environments of a vector environment, in groups that share a model layout, rules and effects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from gym_extensions.catalog.bodies import IS_SUCCESS
from gym_extensions.envs.effects import effects_of, shard_keys
from gym_extensions.envs.interfaces import Array, Flags, Generators, Indices, Template, success_test
from gym_extensions.envs.mujoco.env import IMPLEMENTATIONS
from gym_extensions.envs.mujoco.simulation import BatchPhysics, PooledPhysics
from gym_extensions.envs.vector_env import WHERE, Part, TaskVectorEnv
from gym_extensions.errors import BenchError

LAYOUT = (
    *("nq", "nv", "nu", "na", "nbody", "njnt", "ngeom", "nsite", "ncam", "nlight", "nmesh", "nmocap"),
    *("neq", "ntendon", "nsensor", "nsensordata", "nuserdata", "nplugin"),
)
"""Sizes of MjModel that the simulations of one batch have in common."""


def layout(template: Template) -> tuple[object, ...]:
    """Returns the rules, effects and model sizes that the environments of a shard share."""
    task, model = template.task, template.model
    sizes = tuple(int(getattr(model, name)) for name in LAYOUT)
    return task.base, task.max_steps, template.frame_skip, model.opt.timestep, sizes, shard_keys(task)


class Shard:
    """Environments of one layout. ``members`` are their indices in the vector environment."""

    def __init__(self, members: Indices, templates: Sequence[Template], num_threads: int) -> None:
        self.members = members
        rules = IMPLEMENTATIONS[templates[0].task.base].rules
        self._steps = np.zeros(len(templates), np.int64)
        models: list[mujoco.MjModel] = [template.model for template in templates]
        engine = PooledPhysics if rules.needs_contact_forces else BatchPhysics
        self.physics = engine(models, templates[0].frame_skip, num_threads, rules.fields)
        self._rules = rules(self.physics, templates)
        self._effects = effects_of(self.physics, templates)
        self._success = success_test(templates[0].task.body.success, models[0], self.physics)

    def reset(self, indices: Indices, generators: Generators) -> None:
        """Starts episodes in some environments.

        Each one draws from its own generator, the body before the effects.
        """
        self.physics.require_threads()
        rows = self._rules.draw(indices, generators)
        for effect in self._effects:
            effect.draw(indices, generators, rows)
        self.physics.reset(indices, rows)
        self._steps[indices] = 0
        self._rules.on_reset(indices)
        for effect in self._effects:
            effect.on_reset(indices)

    def step(self, actions: NDArray[Any], indices: Indices | None) -> tuple[Array, Flags]:
        """Returns rewards and terminations of one step in some environments, or in all."""
        self.physics.require_threads()
        self._rules.pre_step()
        ctrl = actions
        for effect in self._effects:
            effect.pre_step(self._steps)
            ctrl = effect.control(ctrl, self._steps)
        self.physics.step(ctrl, indices)
        self._steps += 1
        return self._rules.reward_and_termination(actions, ctrl)

    def step_infos(self) -> Part:
        """Returns the infos of the last step, with ``is_success`` if the tasks define success."""
        infos = self._rules.step_infos()
        if self._success is not None:
            infos = infos | {IS_SUCCESS: self._success()}
        return self.members, infos

    def reset_infos(self) -> Part:
        """Returns the infos of the present states, for environments that have just been reset."""
        return self.members, self._rules.reset_infos()

    def observe(self) -> Array:
        seen = [effect.observation() for effect in self._effects]
        appended = [values for values in seen if values is not None]
        observations = self._rules.observe()
        return np.concatenate((observations, *appended), axis=1) if appended else observations


class MujocoVectorEnv(TaskVectorEnv):
    """MuJoCo environments stepped together, in shards in the order of each one's first environment.

    Results of the shards are put together in the order of the environments; a single shard's are passed on.
    They are not copied, because rules and effects hold views of the engine's memory.
    """

    def __init__(
        self, templates: Sequence[Template], num_threads: int, autoreset_mode: AutoresetMode
    ) -> None:
        spaces = templates[0].observation_space, templates[0].action_space
        super().__init__([template.task for template in templates], spaces, autoreset_mode)
        members: dict[tuple[object, ...], list[int]] = {}
        for index, template in enumerate(templates):
            members.setdefault(layout(template), []).append(index)
        self._shards = [
            Shard(np.array(indices), [templates[index] for index in indices], num_threads)
            for indices in members.values()
        ]

    def __getstate__(self) -> dict[str, Any]:
        message, hint = (
            "The environments cannot be copied.",
            "Make others, and reset them with the same seeds.",
        )
        raise BenchError("no-copy", message, WHERE, hint)

    def _start(self, indices: Indices) -> None:
        starting = np.zeros(self.num_envs, np.bool_)
        starting[indices] = True
        for shard in self._shards:
            rows = np.flatnonzero(starting[shard.members])
            if len(rows):
                shard.reset(rows, [self._generator(int(index)) for index in shard.members[rows]])

    def _advance(self, actions: NDArray[Any], resting: Flags | None) -> tuple[Array, Flags]:
        if len(self._shards) == 1:
            return self._shards[0].step(actions, None if resting is None else np.flatnonzero(~resting))
        rewards, terminations = np.empty(self.num_envs), np.empty(self.num_envs, np.bool_)
        for shard in self._shards:
            rows = None if resting is None else np.flatnonzero(~resting[shard.members])
            rewards[shard.members], terminations[shard.members] = shard.step(actions[shard.members], rows)
        return rewards, terminations

    def _observe(self) -> Array:
        if len(self._shards) == 1:
            return self._shards[0].observe()
        observations: Array = np.empty(self.observation_space.shape or ())
        for shard in self._shards:
            observations[shard.members] = shard.observe()
        return observations

    def _step_infos(self) -> list[Part]:
        return [shard.step_infos() for shard in self._shards]

    def _reset_infos(self) -> list[Part]:
        return [shard.reset_infos() for shard in self._shards]

    def states(self) -> dict[str, Array]:
        self._require_state()
        states: dict[str, Array] = {}
        for shard in self._shards:
            for name, rows in shard.physics.states().items():
                blank = np.full((self.num_envs, *rows.shape[1:]), np.nan)
                states.setdefault(name, blank)[shard.members] = rows
        return states

    def close_extras(self, **kwargs: Any) -> None:
        for shard in self._shards:
            shard.physics.close()
