"""The 150 navigation tasks and their five groups, as data."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gym_extensions.catalog.variations.maps import Course

if TYPE_CHECKING:
    pass

BASE = "Navigation"
MAPS, GOALS = range(10), range(3)

FAMILIES = {
    "state": "State-Based-Navigation-2d-Map{map}-Goal{goal}",
    "state-goal": "State-Based-Navigation-2d-Map{map}-Goal{goal}-KnownGoalPosition",
    "range": "Limited-Range-Based-Navigation-2d-Map{map}-Goal{goal}",
    "range-known": "Limited-Range-Based-Navigation-2d-Map{map}-Goal{goal}-KnownPositions",
    "image": "Image-Based-Navigation-2d-Map{map}-Goal{goal}",
}
"""The paper's names of the tasks of each family, a family being what the agent observes."""


def course_rows() -> list[tuple[str, Course]]:
    """The name and the course of every task, family by family, then map by map, then goal by goal."""
    return [
        (pattern.format(map=number, goal=goal), Course(family, number, goal))
        for family, pattern in FAMILIES.items()
        for number in MAPS
        for goal in GOALS
    ]


def group_rows() -> list[tuple[str, tuple[str, ...]]]:
    """The name of every group and the names of its tasks, in training order."""
    return [
        (f"nav-{family}", tuple(name for name, course in course_rows() if course.family == family))
        for family in FAMILIES
    ]
