"""``customize``: custom tasks, their names, and published tasks that they equal."""

from __future__ import annotations

import pytest

from gym_extensions.catalog.custom import customize
from gym_extensions.catalog.registry import task
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.gravity import Gravity
from gym_extensions.catalog.variations.morphology import LimbScale
from gym_extensions.catalog.variations.obstacles import RangeSensor, Wall


@pytest.mark.parametrize("base", ["Hopper", "gym_extensions/Hopper-v0", task("Hopper")])
def test_a_task_is_given_by_name_id_or_value(base: str | Task) -> None:
    assert customize(base) == task("Hopper")


def test_a_custom_task_has_its_parameters_in_its_name() -> None:
    row = customize("Hopper", [Gravity(0.8), LimbScale("Foot", 1.1)], max_steps=500)
    assert row.id == "gym_extensions/Hopper.Gravity-0.8.LimbScale-Foot-1.1.steps-500-v0"
    assert (row.base, row.max_steps) == ("Hopper", 500)
    assert row.variations == (Gravity(0.8), LimbScale("Foot", 1.1))


def test_variations_are_added_after_those_of_the_task() -> None:
    row = customize("HopperGravityHalf", [LimbScale("Foot", 1.1)])
    assert row.variations == (Gravity(0.5), LimbScale("Foot", 1.1))
    assert row.name == "HopperGravityHalf.LimbScale-Foot-1.1"


@pytest.mark.parametrize("order", [1, -1])
def test_a_combination_that_is_published_is_the_published_task_in_any_order(order: int) -> None:
    variations = [RangeSensor(), Wall(0.8)][::order]
    assert customize("Hopper", variations) is task("HopperWall")


def test_another_time_limit_is_another_task() -> None:
    assert customize("Hopper", max_steps=1000) is task("Hopper")
    assert customize("Hopper", max_steps=999).name == "Hopper.steps-999"
