"""Worlds between and beyond tasks: what varies, what is trained, and that they are no published tasks."""

import pytest

from gym_extensions.catalog.groups import GROUPS, TaskGroup, group
from gym_extensions.catalog.tasks import TASKS, Task, customize, task as task_named
from gym_extensions.catalog.variations import Gravity, LimbScale, RangeSensor, Wall
from gym_extensions.catalog.worlds import Axis, Trained, axes
from gym_extensions.envs.mujoco.env import TaskEnv

WITH_AXES = {name for name in GROUPS if name.endswith(("-gravity", "-body", "-wall")) and "noisy" not in name}
ALL = [(name, axis) for name, members in GROUPS.items() for axis in axes(members)]


def axis_of(name: str, number: int = 0) -> Axis:
    return axes(group(name))[number]


def test_gravity_body_and_wall_groups_vary_one_quantity() -> None:
    assert {name for name, _ in ALL} == WITH_AXES - {"humanoid-standup-run-wall"}
    assert [axis.name for axis in axes(group("hopper-body"))] == ["foot", "leg", "thigh", "torso"]


SEEING = customize("Hopper", [RangeSensor()])
NO_AXES = {
    "two bodies": (task_named("HopperGravityHalf"), task_named("Walker2d")),
    "two kinds": (task_named("HopperGravityHalf"), task_named("HopperBigFoot")),
    "two quantities in one task": (
        customize("HopperBigFoot", [LimbScale("Leg", 1.25)]),
        task_named("Hopper"),
    ),
    "walls of two widths": (customize(SEEING, [Wall(0.9)]), customize(SEEING, [Wall(1.0)])),
    "a wall, and none": (customize(SEEING, [Wall(0.9)]), SEEING),
}


@pytest.mark.parametrize("tasks", NO_AXES.values(), ids=NO_AXES)
def test_a_group_that_varies_more_than_one_quantity_has_no_axes(tasks: tuple[Task, ...]) -> None:
    assert axes(TaskGroup("mine", tasks)) == ()


def test_a_task_without_the_variation_trains_on_the_value_of_its_body() -> None:
    (foot,) = axes(TaskGroup("mine", (task_named("HopperBigFoot"), task_named("Hopper"))))
    assert foot.trained == (Trained(0, 1.25, 1.25), Trained(1, 1.0, 1.0))
    (wall,) = axes(group("hopper-wall"))
    assert wall.trained == (Trained(1, 1.8, 3.8),), "the first task's wall is parked"


@pytest.mark.parametrize(("name", "axis"), ALL, ids=lambda value: getattr(value, "name", value))
def test_every_trained_value_is_a_point_and_no_world_has_a_published_id(name: str, axis: Axis) -> None:
    assert list(axis.points) == sorted(set(axis.points))
    for each in axis.trained:
        assert {each.low, each.high} <= set(axis.points)
        assert axis.nearest(each.low) == axis.nearest(each.high) == each.task
    assert all(axis.indices(place) for place in ("trained", "beyond"))
    worlds = [axis.world(value) for value in axis.points]
    assert not {world.id for world in worlds} & TASKS.keys()
    assert len({world.id for world in worlds}) == len(worlds)
    assert {world.max_steps for world in worlds} == {group(name).tasks[0].max_steps}


def test_fifteen_gravities_surround_the_five_of_the_tasks() -> None:
    axis = axis_of("hopper-gravity")
    assert (len(axis.points), axis.points[0], axis.points[-1]) == (15, 0.3, 1.7)
    assert [axis.points[at] for at in axis.indices("trained")] == [0.5, 0.75, 1.0, 1.25, 1.5]
    assert [axis.points[at] for at in axis.indices("between")] == [0.625, 0.875, 1.125, 1.375]
    assert [axis.nearest(value) for value in (0.3, 0.625, 0.9, 1.7)] == [0, 0, 2, 4]
    assert axis.world(0.3).variations == (Gravity(0.3),)


def test_a_wall_is_trained_at_every_distance_in_between() -> None:
    axis = axis_of("hopper-wall")
    assert axis.indices("between") == ()
    assert [axis.points[at] for at in axis.indices("beyond")] == [1.2, 1.4, 1.6, 4.2, 4.6, 5.0]
    (wall,) = (each for each in axis.world(4.2).variations if isinstance(each, Wall))
    assert wall == Wall(nearest=4.2, farthest=4.2)


@pytest.mark.parametrize(
    ("name", "number", "value", "published"),
    [
        ("hopper-gravity", 0, 1.0, "Hopper"),
        ("halfcheetah-gravity", 0, 0.5, "HalfCheetahGravityHalf"),
        ("walker2d-body", 2, 1.25, "Walker2dBigThigh"),
    ],
)
def test_the_world_at_a_trained_value_is_the_model_of_the_task(
    name: str, number: int, value: float, published: str
) -> None:
    world, task = (
        TaskEnv(each).model for each in (axis_of(name, number).world(value), task_named(published))
    )
    for part in ("geom_size", "body_mass", "body_inertia"):
        assert (getattr(world, part) == getattr(task, part)).all()
    assert (world.opt.gravity == task.opt.gravity).all()
