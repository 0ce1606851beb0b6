"""What a family of bodies adds to physics, on arrays: start, observation, reward and end; and their order."""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies import IS_SUCCESS, Distance, Height, Success
from gym_extensions.envs.effects import effects_of
from gym_extensions.envs.interfaces import Array, Flags, Generators, Indices, Physics, Template


class Rules:
    """The rules of the environments of one shard. Most keep nothing between steps."""

    needs_contact_forces: ClassVar[bool] = False
    """Whether they read the results of mj_rnePostConstraint."""
    fields: ClassVar[tuple[str, ...]] = ()
    """Derived fields of MjData that they read."""
    kept: ClassVar[tuple[str, ...]] = ()
    """Attributes beside the physics on which later steps depend; copies have them too."""

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        self._templates, self._body = templates, templates[0].task.body
        self._qpos, self._qvel = physics.field("qpos"), physics.field("qvel")
        self._rest_qpos = np.array([template.init_qpos for template in templates])
        self._rest_qvel = np.array([template.init_qvel for template in templates])
        self._terms: dict[str, NDArray[Any]] = {}

    def draw(self, indices: Indices, generators: Generators) -> dict[str, Array]:
        """Draws the states in which some environments start an episode, one row each, by name.

        Each is drawn from its own generator, with the numbers that the single environment takes from it: by
        default uniform noise on positions and velocities at rest.
        """
        positions = self._qpos.shape[1]
        noise = uniform_rows(generators, self._body.noise, positions + self._qvel.shape[1])
        qpos, qvel = self._rest_qpos[indices], self._rest_qvel[indices]
        return {"qpos": qpos + noise[:, :positions], "qvel": qvel + noise[:, positions:]}

    def on_reset(self, indices: Indices) -> None:
        """Acts after some environments have started an episode."""

    def pre_step(self) -> None:
        """Stores what the reward compares with, before a step."""

    def reward_and_termination(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """Returns rewards and terminations after a step, ``(num_envs,)`` each.

        Rows of environments that were not stepped are meaningless.

        Args:
            actions: ``(num_envs, nu)`` from the agent, in the agent's precision.
            ctrl: ``(num_envs, nu)`` as the motors received them.
        """
        raise NotImplementedError

    def step_infos(self) -> dict[str, NDArray[Any]]:
        """Returns the single environment's infos of the last step by key, as new arrays."""
        return self.reset_infos() | self._terms

    def reset_infos(self) -> dict[str, NDArray[Any]]:
        """Returns the single environment's infos of a reset by key, as new arrays."""
        return {}

    def observe(self) -> Array:
        """Returns a new array of observations."""
        raise NotImplementedError


def success_test(rule: Success | None, model: mujoco.MjModel, physics: Physics) -> Callable[[], Flags] | None:
    """Returns the test of a MuJoCo body's success, (num_envs,), or None if the body defines none."""
    match rule:
        case Distance(bodies, distance):
            first, second = (model.body(name).id for name in bodies)
            limit, positions = distance * distance, physics.field("xpos")

            def close() -> Flags:
                gap = positions[:, first, :2] - positions[:, second, :2]
                x, y = gap[:, 0], gap[:, 1]
                return x * x + y * y <= limit

            return close
        case Height(low, high):
            height = physics.field("qpos")[:, 2]  # of the free root
            return lambda: (height > low) & (height < high)
        case _:  # the arrival at a goal is navigation's
            return None


class Shard:
    """Environments of one layout with their rules and effects; a single environment is one of them.

    ``members`` are their indices in a vector environment.
    """

    def __init__(
        self, rules: type[Rules], physics: Physics, templates: Sequence[Template], members: Indices
    ) -> None:
        self.members, self.physics = members, physics
        self.steps = np.zeros(len(templates), np.int64)
        self.rules, self.effects = rules(physics, templates), effects_of(physics, templates)
        self._success = success_test(templates[0].task.body.success, templates[0].model, physics)

    def reset(self, indices: Indices, generators: Generators) -> None:
        """Starts episodes. Each draws from its environment's generator, the body before the effects."""
        self.physics.require_threads()
        rows = self.rules.draw(indices, generators)
        for effect in self.effects:
            effect.draw(indices, generators, rows)
        self.physics.reset(indices, rows)
        self.steps[indices] = 0
        self.rules.on_reset(indices)
        for effect in self.effects:
            effect.on_reset(indices)

    def step(self, actions: NDArray[Any], indices: Indices | None) -> tuple[Array, Flags]:
        """Returns rewards and terminations of one step in some environments, or in all."""
        self.physics.require_threads()
        self.rules.pre_step()
        ctrl = actions
        for effect in self.effects:
            effect.pre_step(self.steps)
            ctrl = effect.control(ctrl, self.steps)
        self.physics.step(ctrl, indices)
        self.steps += 1
        return self.rules.reward_and_termination(actions, ctrl)

    def step_infos(self) -> dict[str, NDArray[Any]]:
        """Returns the infos of the last step, with ``is_success`` if the tasks define success."""
        infos = self.rules.step_infos()
        return infos if self._success is None else infos | {IS_SUCCESS: self._success()}

    def observe(self) -> Array:
        """Returns a new array of observations, the body's before the effects'."""
        seen = [effect.observation() for effect in self.effects]
        appended = [values for values in seen if values is not None]
        observations = self.rules.observe()
        return np.concatenate((observations, *appended), axis=1) if appended else observations


def uniform_rows(generators: Generators, noise: float, size: int) -> Array:
    """Draws ``size`` numbers in [−noise, noise) from each generator, (generators, size)."""
    return np.array([generator.uniform(-noise, noise, size) for generator in generators])
