"""What variations do while the simulation runs, on one environment and on many.

Environments call the effects of their variations at the moments that :class:`Effect` names.
"""

import functools
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog import bodies, tasks, variations
from gym_extensions.envs import range_beams
from gym_extensions.envs.interfaces import Array, Generators, Indices, Physics, Steps, Template
from gym_extensions.errors import BenchError
from gym_extensions.files import compiled


class Effect:
    """The effect of a variation on environments with one model layout; a single environment is one of them.

    The methods do nothing; an effect overrides those it needs. ``steps`` counts environment steps since each
    reset.
    """

    kind: ClassVar[type[variations.Variation]]
    """The class of the variation."""
    kept: ClassVar[tuple[str, ...]] = ()
    """Attributes beside the physics on which later steps depend; copies have them too."""

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        """Reads the parameters of the variation, from the template of each environment."""

    @staticmethod
    def shard_key(variation: Any) -> object:
        """What is equal in the variations of environments that are stepped in one shard."""
        return repr(variation)

    def draw(self, indices: Indices, generators: Generators, starts: dict[str, Array]) -> None:
        """Draws after the body, and adds to the rows of the states in which environments start."""

    def on_reset(self, indices: Indices) -> None:
        """Acts after some environments have started an episode."""

    def pre_step(self, steps: Steps) -> None:
        """Acts before the physics of a step. Rows of environments that are not stepped are ignored."""

    def control(self, ctrl: NDArray[Any], steps: Steps) -> NDArray[Any]:
        """Returns what the motors receive for commands ``(num_envs, nu)``."""
        return ctrl

    def observation(self) -> Array | None:
        """Returns what the effect appends to the observations, ``(num_envs, …)``."""
        return None


class SeededNoise(Effect):
    """An effect whose noise in an episode follows from one number, the seed that is drawn at reset."""

    def fill_noise(self, index: int, seed: int) -> None:
        """Computes the noise of an environment's episode."""
        raise NotImplementedError

    def draw(self, indices: Indices, generators: Generators, starts: dict[str, Array]) -> None:
        for index, generator in zip(indices.tolist(), generators, strict=True):
            self.fill_noise(index, int(generator.integers(2**32)))


def variation_of(task: tasks.Task, kind: type) -> Any:
    """Returns the task's variation of a class, or None."""
    return next((variation for variation in task.variations if isinstance(variation, kind)), None)


class WallEffect(Effect):
    """Places the walls."""

    kind = variations.Wall

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        self._walls = [variation_of(template.task, variations.Wall) for template in templates]
        self._rest = [each.model.body_pos[each.model.body_mocapid >= 0] for each in templates]
        self._wall = templates[0].model.body(variations.WALL).mocapid[0]

    @staticmethod
    def shard_key(variation: variations.Wall) -> object:
        return variation.half_sizes

    def draw(self, indices: Indices, generators: Generators, starts: dict[str, Array]) -> None:
        """Adds ``mocap_pos``, with the walls' centers."""
        starts["mocap_pos"] = np.array([self._rest[index] for index in indices])
        for centers, index, generator in zip(starts["mocap_pos"], indices, generators, strict=True):
            wall = self._walls[index]
            if not wall.parked:
                centers[self._wall, 0] = generator.uniform(wall.nearest, wall.farthest)


@functools.cache
def compiled_readings() -> Callable[..., Array]:
    """The readings of the range sensor, compiled: this loads a compiler, which other tasks do not need."""
    return compiled(range_beams.readings)


class RangeSensorEffect(Effect):
    """Appends the 10 beams, in [0, 1]. Their walls have one size."""

    kind: ClassVar[type[variations.Variation]] = variations.RangeSensor

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        self._num_envs = len(templates)
        self._fan = range_beams.FANS[templates[0].task.body.beams]
        self._lift = np.array([template.root_lift for template in templates])
        self._qpos, self._center = physics.field("qpos"), None
        if (wall := variation_of(templates[0].task, variations.Wall)) is not None:
            self._center = physics.field("mocap_pos")[:, templates[0].model.body(variations.WALL).mocapid[0]]
            self._half_sizes = np.array(wall.half_sizes)

    def observation(self) -> Array:
        """The present readings, (num_envs, 10)."""
        if self._center is None:
            return np.zeros((self._num_envs, range_beams.BEAMS))
        origins, directions = self._fan(self._qpos, self._lift)
        return compiled_readings()(origins, directions, self._center, self._half_sizes)


class SensorNoiseEffect(SeededNoise, RangeSensorEffect):
    """Appends the noisy readings of the step before."""

    kind = variations.SensorNoise
    kept = ("_working", "_shift", "_latched")

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        super().__init__(physics, templates)
        self._noise = variation_of(templates[0].task, variations.SensorNoise)
        self._max_steps = templates[0].task.max_steps
        shape = (len(templates), self._max_steps + 1, range_beams.BEAMS)
        self._working, self._shift = np.zeros(shape, np.bool_), np.zeros(shape)
        self._latched = np.zeros((len(templates), range_beams.BEAMS))

    def fill_noise(self, index: int, seed: int) -> None:
        noise = range_beams.beam_noise(seed, self._max_steps, self._noise.dropout, self._noise.noise)
        self._working[index], self._shift[index] = noise

    def on_reset(self, indices: Indices) -> None:
        """The first observation has the present reading."""
        present = super().observation()[indices]
        self._latched[indices] = range_beams.disturb(
            present, self._working[indices, 0], self._shift[indices, 0]
        )

    def pre_step(self, steps: Steps) -> None:
        """Latches the readings before the step, which the next observations show."""
        row = np.arange(len(steps)), (steps + 1) % (self._max_steps + 1)
        self._latched = range_beams.disturb(super().observation(), self._working[row], self._shift[row])

    def observation(self) -> Array:
        return self._latched


class MotorNoiseEffect(SeededNoise):
    """Adds the episodes' noise to every command."""

    kind = variations.MotorNoise
    kept = ("_noise",)

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        self._max_steps = templates[0].task.max_steps
        self._scale = variation_of(templates[0].task, variations.MotorNoise).scale
        self._ranges = templates[0].model.actuator_ctrlrange
        self._noise = np.zeros((len(templates), self._max_steps, len(self._ranges)))

    def fill_noise(self, index: int, seed: int) -> None:
        generator = np.random.Generator(np.random.PCG64(seed))
        self._noise[index] = generator.standard_normal(self._noise[index].shape)

    def control(self, ctrl: NDArray[Any], steps: Steps) -> NDArray[Any]:
        """Commands plus noise of ``scale`` × the motors' range, clipped to that range."""
        noise = self._noise[np.arange(len(ctrl)), steps % self._max_steps]
        low, high = self._ranges[:, 0], self._ranges[:, 1]
        return np.clip(ctrl + self._scale * (high - low) * noise, low, high)


def move(position: Array, velocity: Array, area: bodies.Rectangle, seconds: float) -> tuple[Array, Array]:
    """Returns position and velocity (…, 2) of a goal that moves straight and is reflected at the edges."""
    low, high = np.array(area.low), np.array(area.high)
    ahead = position + velocity * seconds
    below, above = ahead < low, ahead > high
    reflected = np.where(below, 2 * low - ahead, np.where(above, 2 * high - ahead, ahead))
    return reflected, np.where(below | above, -velocity, velocity)


class TrackingGoalEffect(Effect):
    """Moves the goals before the physics of every step."""

    kind = variations.TrackingGoal
    kept = ("_velocity",)

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        task = templates[0].task
        assert task.body.goal_area is not None, "the variation fits only bodies with one"
        self._area, self._dt = task.body.goal_area, templates[0].dt
        self._speed = variation_of(task, variations.TrackingGoal).speed
        self._velocity = np.zeros((len(templates), 2))
        mocap = templates[0].model.nmocap > 0  # Striker's goal is a mocap body, Pusher's is on slides
        self._position = physics.field("mocap_pos")[:, 0, :2] if mocap else physics.field("qpos")[:, -2:]

    def draw(self, indices: Indices, generators: Generators, starts: dict[str, Array]) -> None:
        speed = self._speed
        self._velocity[indices] = [generator.uniform(-speed, speed, 2) for generator in generators]

    def pre_step(self, steps: Steps) -> None:
        """Moves the goals to their positions at the end of the step."""
        self._position[...], self._velocity = move(self._position, self._velocity, self._area, self._dt)


EFFECTS: tuple[type[Effect], ...] = (
    *(WallEffect, RangeSensorEffect, SensorNoiseEffect, MotorNoiseEffect, TrackingGoalEffect),
)
"""Every effect, in the order in which effects draw at reset; a new one is the last."""


def effects_of(physics: Physics, templates: Sequence[Template]) -> list[Effect]:
    """Returns the effects on environments with one layout, in the order in which they draw."""
    present = [each for each in EFFECTS if variation_of(templates[0].task, each.kind) is not None]
    replaced = {each.kind.needs for each in present}
    return [each(physics, templates) for each in present if each.kind not in replaced]


def shard_keys(task: tasks.Task) -> tuple[object, ...]:
    """Returns what environments of one shard have in common in their effects."""
    pairs = [(each, variation_of(task, each.kind)) for each in EFFECTS]
    return tuple(None if variation is None else each.shard_key(variation) for each, variation in pairs)


def check_variations(task: tasks.Task) -> None:
    """Checks that the variations fit the base body and each other.

    Raises:
        BenchError: a variation does not fit the base body, has an effect and appears twice, or lacks the
            variation that it needs.
    """
    kinds_with_effect = {each.kind for each in EFFECTS}
    counts = Counter(type(variation) for variation in task.variations)
    for kind, count in counts.items():
        if not kind.fits(task.body):
            message = f"{kind.__name__} does not fit {task.base}."
            fitting = ", ".join(body.name for body in bodies.BODIES.values() if kind.fits(body))
            raise BenchError("misplaced-variation", message, task.id, f"It fits {fitting}.")
        if kind in kinds_with_effect and count > 1:
            message = f"The variation {kind.__name__} is given {count} times."
            raise BenchError("repeated-variation", message, task.id, "Give it once.")
        if kind.needs is not None and kind.needs not in counts:
            message, hint = f"{kind.__name__} needs a {kind.needs.__name__}.", f"Add {kind.needs.__name__}()."
            raise BenchError("missing-variation", message, task.id, hint)
