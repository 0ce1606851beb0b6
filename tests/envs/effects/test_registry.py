"""The registry of effects: discovery, order, and what a task's effects are."""

from __future__ import annotations

import pkgutil

import pytest

from gym_extensions.catalog.registry import task
from gym_extensions.envs import effects
from gym_extensions.envs.effects.registry import KINDS, RUNTIME_VARIATIONS, effects_of, kinds_of, shard_keys
from gym_extensions.envs.vector.layout import is_vectorized


def test_every_module_with_an_effect_is_found_in_the_published_draw_order() -> None:
    names = [kind.variation.__name__ for kind in KINDS]
    assert names[:5] == ["Wall", "RangeSensor", "SensorNoise", "MotorNoise", "TrackingGoal"]
    modules = {module.name for module in pkgutil.iter_modules(effects.__path__)}
    assert len(KINDS) == len(modules - {"base", "registry", "seeded_noise"})
    assert len({kind.draw_order for kind in KINDS}) == len(KINDS)


@pytest.mark.parametrize(
    ("name", "variations"),
    [
        ("Hopper", []),
        ("HopperWall", ["Wall", "RangeSensor"]),
        ("HopperNoisyWall", ["Wall", "SensorNoise"]),
        ("HopperMotorNoise", ["MotorNoise"]),
        ("PusherTrackingGoal", ["TrackingGoal"]),
    ],
)
def test_sensor_noise_replaces_the_range_sensor(name: str, variations: list[str]) -> None:
    row = task(name)
    assert [kind.variation.__name__ for kind in kinds_of(row)] == variations
    assert len(effects_of(row)) == len(variations)


def test_environments_of_a_wall_group_share_a_shard_and_a_wider_wall_does_not() -> None:
    assert shard_keys(task("HopperWithSensor")) == shard_keys(task("HopperWall"))
    assert shard_keys(task("HopperWall")) != shard_keys(task("HopperNoisyWall"))
    assert shard_keys(task("HopperWall")) != shard_keys(task("HumanoidWall"))


def test_every_published_runtime_variation_is_vectorized() -> None:
    assert {kind.variation for kind in KINDS} < set(RUNTIME_VARIATIONS)
    assert is_vectorized(task("PusherMovingGoal"))
    assert not is_vectorized(task("State-Based-Navigation-2d-Map0-Goal0"))
