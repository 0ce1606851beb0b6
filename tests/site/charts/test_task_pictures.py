"""Drawings on the pages of tasks."""

from gym_extensions.catalog.tasks import TASKS, task
from gym_extensions.references import Expert, Floor, Reference
from gym_extensions.site.charts.task_pictures import reference_dots, task_picture

SOLVED = Reference(Floor(10.0), Expert(200.0, agent="expert"))


def test_every_task_has_a_picture_or_a_drawn_map() -> None:
    assert task_picture(task("HopperGravityHalf").id) == "pictures/hopper.webp"
    assert task_picture(task("State-Based-Navigation-2d-Map3-Goal1").id) == "pictures/map3-goal1.svg"
    assert all(map(task_picture, TASKS))


def test_the_expert_is_marked_1_and_runs_on_the_task_alone_are_dots() -> None:
    drawing = reference_dots(SOLVED, (90.0, 110.0))
    assert drawing.count("<circle") == 2
    assert ">1</text>" in drawing
    assert "floor 10.0; expert 200.0; trained alone 90.0, 110.0" in drawing
