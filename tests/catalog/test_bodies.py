"""The table of base bodies: every row fits its model and its tasks."""

import pytest

from gym_extensions.catalog.bodies import BODIES
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.envs.mujoco.env import IMPLEMENTATIONS
from gym_extensions.envs.mujoco.model import base_spec

MUJOCO = [row for row in BODIES.values() if row.asset]


@pytest.mark.parametrize("name", [row.name for row in MUJOCO])
def test_the_row_of_a_mujoco_body_agrees_with_its_model(name: str) -> None:
    row = BODIES[name]
    spec = base_spec(row)
    assert (spec.option.gravity[2] != 0) == row.has_gravity
    for geoms in row.parts.values():
        assert all(spec.geom(geom) is not None for geom in geoms)


def test_every_mujoco_body_has_rules_and_no_other_body_has() -> None:
    assert IMPLEMENTATIONS.keys() == {row.name for row in MUJOCO}


@pytest.mark.parametrize(
    ("task", "bounds"),
    [
        ("Hopper", (-20_000.0, 20_000.0)),
        ("Pusher", (-3_000.0, 0.0)),
        ("State-Based-Navigation-2d-Map0-Goal0", (-6_000.0, 9.0)),
    ],
)
def test_return_bounds_cover_episodes_of_every_length(task: str, bounds: tuple[float, float]) -> None:
    assert TASKS[f"gym_extensions/{task}-v0"].return_bounds == bounds
