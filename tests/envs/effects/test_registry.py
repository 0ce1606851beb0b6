"""The registry of effects: their order, and what a task's effects are."""

from __future__ import annotations

import pytest

from gym_extensions.catalog.tasks import task
from gym_extensions.envs.effects.registry import KINDS, RUNTIME_VARIATIONS, kinds_of, shard_keys


def test_effects_draw_in_the_published_order() -> None:
    names = [kind.variation.__name__ for kind in KINDS]
    assert names[:5] == ["Wall", "RangeSensor", "SensorNoise", "MotorNoise", "TrackingGoal"]
    assert len({kind.draw_order for kind in KINDS}) == len(KINDS)
    assert {kind.variation for kind in KINDS} < set(RUNTIME_VARIATIONS)


@pytest.mark.parametrize(
    ("name", "variations"),
    [
        ("Hopper", []),
        ("HopperWall", ["Wall", "RangeSensor"]),
        ("HopperNoisyWall", ["Wall", "SensorNoise"]),
        ("PusherTrackingGoal", ["TrackingGoal"]),
    ],
)
def test_sensor_noise_replaces_the_range_sensor(name: str, variations: list[str]) -> None:
    assert [kind.variation.__name__ for kind in kinds_of(task(name))] == variations


def test_environments_of_a_wall_group_share_a_shard_and_a_wider_wall_does_not() -> None:
    assert shard_keys(task("HopperWithSensor")) == shard_keys(task("HopperWall"))
    assert shard_keys(task("HopperWall")) != shard_keys(task("HopperNoisyWall"))
    assert shard_keys(task("HopperWall")) != shard_keys(task("HumanoidWall"))
