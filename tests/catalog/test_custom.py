"""``customize``: custom tasks, their names, and published tasks that they equal."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from gym_extensions import envs
from gym_extensions.catalog.bodies import Body
from gym_extensions.catalog.descriptions import picture_file
from gym_extensions.catalog.tasks import Task, customize, task
from gym_extensions.catalog.variations import Gravity, LimbScale, Variation, Wall
from gym_extensions.errors import BenchError

from ..conftest import refused

WORD: Any = "no"
PAIR: Any = np.array([0.5, 1.0])


@dataclass(frozen=True)
class Wind(Variation):
    """Blows along x: a variation of a user."""

    speed: float

    def apply(self, body: Body, spec: Any) -> None:
        spec.option.wind = [self.speed, 0, 0]


OwnGravity = type("Gravity", (Wind,), {"__repr__": lambda self: f"Gravity(factor={self.speed})"})


NAMES = ("Hopper", "gym_extensions/Hopper-v0", "gym_extensions.envs:gym_extensions/Hopper-v0")


@pytest.mark.parametrize("base", [*NAMES, task("Hopper")])
def test_a_task_is_given_by_name_id_or_value(base: str | Task) -> None:
    assert customize(base) == task("Hopper")


def test_variations_are_added_after_those_of_the_task_and_named_in_its_id() -> None:
    row = customize("HopperGravityHalf", [LimbScale("Foot", 1.1)], max_steps=500)
    assert (row.variations, row.max_steps) == ((Gravity(0.5), LimbScale("Foot", 1.1)), 500)
    assert row.id == "gym_extensions/HopperGravityHalf.LimbScale-Foot-1.1.steps-500-v0"


@pytest.mark.parametrize("order", [1, -1])
def test_a_combination_that_is_published_is_the_published_task_in_any_order(order: int) -> None:
    variations = [envs.RangeSensor(), Wall(0.8)][::order]
    assert customize("Hopper", variations) is task("HopperWall")


@pytest.mark.parametrize("factor", [np.float64(0.5), np.float32(0.5), 0.5])
def test_numbers_of_any_type_give_one_task(factor: float) -> None:
    assert customize("Hopper", [Gravity(factor)]) is task("HopperGravityHalf")
    assert customize("Humanoid", [envs.RangeSensor(), Wall(10)]) is task("HumanoidWall")
    assert customize("Hopper", [Gravity(2)]) == customize("Hopper", [Gravity(2.0)])
    assert customize("Hopper", [Gravity(2)]).id == "gym_extensions/Hopper.Gravity-2.0-v0"
    limit: Any = np.int64(1000)
    assert customize("Hopper", max_steps=limit) is task("Hopper")


def test_a_variation_of_a_users_own_class_is_applied_and_never_published() -> None:
    assert customize("Hopper", [Wind(2)]).id == "gym_extensions/Hopper.Wind-2.0-v0"
    for kind in (Wind, OwnGravity):
        assert envs.make("Hopper", [kind(0.5)]).unwrapped.model.opt.wind[0] == 0.5  # type: ignore[attr-defined]


def test_values_that_differ_in_a_sign_give_two_ids() -> None:
    walls = [Wall(0.9, centre_height=height) for height in (0.125, -0.125)]
    names = [customize("Hopper", [wall]).name for wall in walls]
    assert names == [f"Hopper.Wall-0.9-0.4-0.5-{height}-1.8-3.8-False" for height in ("0.125", "m0.125")]
    assert customize("Hopper", [Gravity(1e16)]).id != customize("Hopper", [Gravity(1e-16)]).id


@pytest.mark.parametrize(
    ("make", "fact"),
    [
        (lambda: Gravity(-0.5), "Gravity's factor is -0.5"),
        (lambda: LimbScale("Foot", float("nan")), "LimbScale's factor is nan"),
        (lambda: Gravity(10**400), "factor is 1000"),
        (lambda: Gravity(PAIR), r"factor is array\(\[0.5, 1."),
        (lambda: Wind(float("inf")), "Wind's speed is inf"),
        (lambda: envs.MotorNoise(0), "MotorNoise's scale is 0"),
        (lambda: envs.SensorNoise(dropout=1.5), "dropout is 1.5"),
        (lambda: Wall(farthest=float("inf")), "farthest is inf"),
        (lambda: Wall(farthest=WORD), "farthest is 'no'"),
        (lambda: Wall(nearest=3.0, farthest=2.0), "nearest 3.0"),
        (lambda: Wall(centre_height=float("nan")), "centre_height is nan"),
        (lambda: Wall(parked=WORD), "parked is 'no'"),
        (lambda: envs.TrackingGoal(4.1), "Give at most 4"),
    ],
)
def test_a_value_that_no_simulation_can_have_is_refused(make: Callable[[], object], fact: str) -> None:
    with pytest.raises(BenchError, match=fact):
        make()


def test_a_limb_is_named_and_has_a_mass_that_mujoco_simulates() -> None:
    parts: Any = ["Foot", "Leg"]
    with refused("bad-value"):
        LimbScale(parts, 1.2)
    for name in ("Hopper", "HopperWall"):
        with refused("bad-model"):
            envs.make(name, [LimbScale("Foot", 1e-9)])


@pytest.mark.parametrize(
    ("made", "picture"),
    [
        (customize("Hopper", [Gravity(0.3), envs.MotorNoise()]), "hopper.webp"),
        (customize("Hopper", [envs.RangeSensor(), Wall(), envs.SensorNoise(0.1)]), "hopperwall.webp"),
        (customize("HopperBigFoot", [Gravity(0.3)]), "hopperbigfoot.webp"),
        (customize("Hopper", [LimbScale("Foot", 1.1)]), "hopper.limbscale-foot-1.1.webp"),
    ],
)
def test_a_picture_is_of_what_is_seen_of_the_variations(made: Task, picture: str) -> None:
    assert picture_file(made) == picture
