"""The moments at which environments call the effects of their run-time variations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from numpy.typing import NDArray

from gym_extensions.catalog.tasks import Task
from gym_extensions.envs.interfaces import Array, Fields, Generators, Indices, Steps, Template

NOISE_SEEDS = 2**32
"""Seeds of the noise of an episode are below this."""


class Effect:
    """The effect of a variation on environments with one model layout; a single environment is one of them.

    The methods do nothing; an effect overrides those it needs. ``steps`` counts environment steps since each
    reset.
    """

    kept: ClassVar[tuple[str, ...]] = ()
    """Attributes beside the physics on which later steps depend; copies have them too."""

    def __init__(self, fields: Fields, templates: Sequence[Template]) -> None:
        """Reads the parameters of the variation, from the template of each environment."""

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
            self.fill_noise(index, int(generator.integers(NOISE_SEEDS)))


@dataclass(frozen=True)
class EffectKind:
    """A submission of the registry of effects."""

    variation: type  # its class
    effect: Callable[[Fields, Sequence[Template]], Effect]  # makes the effect on environments
    shard_key: Callable[[Any], object] = repr  # environments share a shard only if this of theirs is equal
    replaces: type | None = None  # the variation whose effect this one replaces; a task must have it too


def variation_of(task: Task, kind: type) -> Any:
    """Returns the task's variation of a class, or None."""
    return next((variation for variation in task.variations if isinstance(variation, kind)), None)
