"""Steps environments that share a model layout, rules and effects as one physics batch and arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies.success import IS_SUCCESS
from gym_extensions.envs.batch.infos import Part
from gym_extensions.envs.effects.registry import vector_effects_of
from gym_extensions.envs.protocols import Array, Flags, Generators, Indices, Physics, States
from gym_extensions.envs.success import success_test
from gym_extensions.envs.vector.layout import rules_of
from gym_extensions.envs.vector.physics import BatchPhysics
from gym_extensions.envs.vector.template import TaskTemplate
from gym_extensions.envs.vector.thread_pool import PooledPhysics


def physics(templates: Sequence[TaskTemplate], num_threads: int) -> Physics:
    """Returns the simulations of the templates' models, on the engine that their rules need."""
    rules = rules_of(templates[0])
    models: list[mujoco.MjModel] = [template.model for template in templates]
    engine = PooledPhysics if rules.needs_contact_forces else BatchPhysics
    return engine(models, templates[0].frame_skip, num_threads, rules.fields)


class Shard:
    """Environments of one layout. ``members`` are their indices in the vector environment."""

    def __init__(self, members: Indices, templates: Sequence[TaskTemplate], num_threads: int) -> None:
        self.members = members
        self._arguments = members, templates, num_threads
        self._dt = templates[0].dt
        self._steps = np.zeros(len(templates), np.int64)
        self._physics = physics(templates, num_threads)
        self._rules = rules_of(templates[0])(self._physics, templates)
        self._effects = vector_effects_of(self._physics, templates)
        self._success = success_test(templates[0].task.body.success, templates[0].model)
        self._success_field = None if self._success is None else self._physics.field(self._success.field)

    def __getstate__(self) -> dict[str, Any]:
        """Returns the arguments, and copies of everything that changes from step to step."""
        return {
            "arguments": self._arguments,
            "steps": self._steps,
            "physics": self._physics.dump(),
            "saved": self.save(),
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Makes the shard again and continues where the copied one was."""
        Shard.__init__(self, *state["arguments"])
        everyone = np.arange(len(self.members))
        self._set_state(everyone, state["saved"])
        self._physics.undump(state["physics"])
        self._steps[:] = state["steps"]

    def reset(self, indices: Indices, generators: Generators) -> None:
        """Starts episodes in some environments.

        Each one draws from its own generator, the body before the effects.
        """
        rows = self._rules.draw(indices, generators)
        for effect in self._effects:
            effect.draw(indices, generators, rows)
        self._physics.reset(indices, rows)
        self._steps[indices] = 0
        self._rules.on_reset(indices)
        for effect in self._effects:
            effect.on_reset(indices)

    def step(self, actions: NDArray[Any], indices: Indices | None) -> tuple[Array, Flags]:
        """Returns rewards and terminations of one step in some environments, or in all."""
        self._rules.pre_step()
        ctrl = actions
        for effect in self._effects:
            effect.pre_step(self._steps)
            ctrl = effect.control(ctrl, self._steps)
        self._physics.step(ctrl, indices)
        self._steps += 1
        return self._rules.reward_and_termination(actions, ctrl)

    def step_infos(self) -> Part:
        """Returns the infos of the last step, with ``is_success`` if the tasks define success."""
        infos = self._rules.step_infos()
        if self._success is not None and self._success_field is not None:
            infos = infos | {IS_SUCCESS: self._success(self._success_field)}
        return self.members, infos

    def reset_infos(self) -> Part:
        """Returns the infos of the present states, for environments that have just been reset."""
        return self.members, self._rules.reset_infos()

    def observe(self) -> Array:
        """Returns a new array of observations."""
        seen = [effect.observation() for effect in self._effects]
        appended = [values for values in seen if values is not None]
        observations = self._rules.observe()
        return np.concatenate((observations, *appended), axis=1) if appended else observations

    def save(self) -> dict[str, Array]:
        """Returns copies of the states by name, one row per environment."""
        saved = self._physics.snapshot() | self._rules.get_state()
        for effect in self._effects:
            saved |= effect.get_state()
        return saved

    def load(self, indices: Indices, state: States) -> None:
        """Restores saved rows in some environments."""
        self._physics.load(indices, state)
        self._steps[indices] = np.rint(np.asarray(state["time"]) / self._dt).astype(np.int64)
        self._set_state(indices, state)

    def _set_state(self, indices: Indices, state: States) -> None:
        self._rules.set_state(indices, state)
        for effect in self._effects:
            effect.set_state(indices, state)

    def close(self) -> None:
        """Frees threads and memory."""
        self._physics.close()
