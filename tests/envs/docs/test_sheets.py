"""Every task has a sheet, and the committed large pictures are those of the tasks."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gym_extensions.catalog.sheets import large_picture, sheet
from gym_extensions.catalog.tasks import TASKS, task
from gym_extensions.envs.docs.sheets import rectangles
from gym_extensions.envs.navigation.geometry import load

PICTURES = Path(__file__).parents[3] / "site" / "gym_extensions" / "site" / "pictures"


def test_every_task_has_a_sheet_that_draws_it() -> None:
    for task_id, row in TASKS.items():
        facts = sheet(task_id)
        assert facts is not None
        if row.body.family == "navigation":
            assert facts.goal is not None and facts.obstacles
        else:
            assert facts.skeleton is not None and facts.actions


def test_the_part_that_differs_is_marked() -> None:
    facts = sheet(task("Walker2dBigFoot").id)
    assert facts is not None and facts.skeleton is not None
    shapes = [shape for link in facts.skeleton.links for shape in link.shapes]
    assert [(shape.role, shape.radius) for shape in shapes if shape.role == "changed"] == [
        ("changed", 0.075)
    ] * 2


def test_rectangles_cover_every_obstacle_once() -> None:
    cells = load(3).cells
    covered = np.zeros(cells.shape, dtype=int)
    for x, y, width, height in rectangles(cells):
        covered[y : y + height, x : x + width] += 1
    np.testing.assert_array_equal(covered, cells)


def test_exactly_the_large_pictures_of_tasks_are_committed() -> None:
    names = {large_picture(row) for row in TASKS.values()} - {""}
    assert {path.name for path in PICTURES.iterdir()} == names
    assert sum(path.stat().st_size for path in PICTURES.iterdir()) < 400_000
