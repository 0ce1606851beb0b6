"""MuJoCo environments of a vector environment, in groups that share a model layout, rules and effects."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from gym_extensions.envs import effects, vector_env
from gym_extensions.envs.interfaces import Array, Flags, Indices, Template
from gym_extensions.envs.mujoco import base, env, simulation
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
    return task.base, task.max_steps, template.frame_skip, model.opt.timestep, sizes, effects.shard_keys(task)


class MujocoVectorEnv(vector_env.TaskVectorEnv):
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
        self._shards = []
        for indices in members.values():
            own = [templates[index] for index in indices]
            rules = env.IMPLEMENTATIONS[own[0].task.base].rules
            engine = simulation.PooledPhysics if rules.needs_contact_forces else simulation.BatchPhysics
            models = [template.model for template in own]
            physics = engine(models, own[0].frame_skip, num_threads, rules.fields)
            self._shards.append(base.Shard(rules, physics, own, np.array(indices)))

    def __getstate__(self) -> dict[str, Any]:
        message, hint = (
            "The environments cannot be copied.",
            "Make others, and reset them with the same seeds.",
        )
        raise BenchError("no-copy", message, vector_env.WHERE, hint)

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

    def _step_infos(self) -> list[vector_env.Part]:
        return [(shard.members, shard.step_infos()) for shard in self._shards]

    def _reset_infos(self) -> list[vector_env.Part]:
        return [(shard.members, shard.rules.reset_infos()) for shard in self._shards]

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
