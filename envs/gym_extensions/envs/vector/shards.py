"""All environments of a vector environment, grouped into shards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.envs.batch.engine import GeneratorOf
from gym_extensions.envs.batch.infos import Part
from gym_extensions.envs.batch.saved_states import check_names, rows_for
from gym_extensions.envs.protocols import Array, Flags, Indices, States
from gym_extensions.envs.vector.layout import layout
from gym_extensions.envs.vector.shard import Shard
from gym_extensions.envs.vector.template import TaskTemplate


class Shards:
    """Environments grouped by layout, in the order of each group's first environment.

    Results of the shards are put together in the order of the environments; a single shard's are passed on.
    """

    def __init__(self, templates: Sequence[TaskTemplate], num_threads: int) -> None:
        self._num_envs = len(templates)
        self._space = templates[0].observation_space
        members: dict[tuple[object, ...], list[int]] = {}
        for index, template in enumerate(templates):
            members.setdefault(layout(template), []).append(index)
        self._shards = [
            Shard(np.array(indices), [templates[index] for index in indices], num_threads)
            for indices in members.values()
        ]

    def check_options(self, options: Mapping[str, Any], indices: Indices) -> None:
        """All options are accepted and ignored, as by Gymnasium's bodies."""

    def start(self, indices: Indices, generator: GeneratorOf, options: Mapping[str, Any]) -> None:
        """Starts episodes in some environments."""
        starting = np.zeros(self._num_envs, np.bool_)
        starting[indices] = True
        for shard in self._shards:
            rows = np.flatnonzero(starting[shard.members])
            if len(rows):
                shard.reset(rows, [generator(int(index)) for index in shard.members[rows]])

    def step(self, actions: NDArray[Any], resting: Flags | None) -> tuple[Array, Flags]:
        """Returns rewards and terminations of one step. Rows of resting environments are meaningless."""
        if len(self._shards) == 1:
            return self._shards[0].step(actions, None if resting is None else np.flatnonzero(~resting))
        rewards, terminations = np.empty(self._num_envs), np.empty(self._num_envs, np.bool_)
        for shard in self._shards:
            rows = None if resting is None else np.flatnonzero(~resting[shard.members])
            rewards[shard.members], terminations[shard.members] = shard.step(actions[shard.members], rows)
        return rewards, terminations

    def observe(self) -> Array:
        """Returns a new array of observations, ``(num_envs, …)``."""
        if len(self._shards) == 1:
            return self._shards[0].observe()
        observations: Array = np.empty((self._num_envs, *self._space.shape))
        for shard in self._shards:
            observations[shard.members] = shard.observe()
        return observations

    def step_infos(self) -> list[Part]:
        """Returns the infos of the last step."""
        return [shard.step_infos() for shard in self._shards]

    def reset_infos(self) -> list[Part]:
        """Returns the infos of the present states, for environments that have just been reset."""
        return [shard.reset_infos() for shard in self._shards]

    def save(self) -> dict[str, Array]:
        """Returns the states by name. A name that some environments lack has NaN in their rows."""
        if len(self._shards) == 1:
            return self._shards[0].save()
        states: dict[str, Array] = {}
        for shard in self._shards:
            for name, rows in shard.save().items():
                blank = np.full((self._num_envs, *rows.shape[1:]), np.nan)
                states.setdefault(name, blank)[shard.members] = rows
        return states

    def save_each(self) -> list[dict[str, Array]]:
        """Returns one state per environment, with the names that its task has."""
        states: list[dict[str, Array]] = [{} for _ in range(self._num_envs)]
        for shard in self._shards:
            for name, rows in shard.save().items():
                for index, row in zip(shard.members, rows, strict=True):
                    states[index][name] = np.array(row)
        return states

    def load(self, indices: Indices, states: States) -> None:
        """Restores saved rows, one for each of the given environments.

        Raises:
            BenchError: a name is missing or unknown, or a value has another shape or is not finite.
        """
        shapes = [shard.save() for shard in self._shards]
        check_names(states, set().union(*shapes))
        checked = []
        for shard, expected in zip(self._shards, shapes, strict=True):
            rows = np.flatnonzero(np.isin(indices, shard.members))
            if len(rows):
                members = np.searchsorted(shard.members, indices[rows])
                checked.append((shard, members, rows_for(states, rows, expected)))
        for shard, members, state in checked:
            shard.load(members, state)

    def close(self) -> None:
        """Frees threads and memory."""
        for shard in self._shards:
            shard.close()
