"""The 150 navigation tasks and their five groups, as data."""

from __future__ import annotations

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.maps import Course

BASE = "Navigation"
MAPS, GOALS = range(10), range(3)

FAMILIES = {
    "state": "State-Based-Navigation-2d-Map{map}-Goal{goal}",
    "state-goal": "State-Based-Navigation-2d-Map{map}-Goal{goal}-KnownGoalPosition",
    "range": "Limited-Range-Based-Navigation-2d-Map{map}-Goal{goal}",
    "range-known": "Limited-Range-Based-Navigation-2d-Map{map}-Goal{goal}-KnownPositions",
    "image": "Image-Based-Navigation-2d-Map{map}-Goal{goal}",
}
"""The paper's task names by family. The tasks of one family have the same kind of observation."""


def courses() -> dict[str, Course]:
    """The course of every task by its name, family by family, then map by map, then goal by goal."""
    return {
        pattern.format(map=number, goal=goal): Course(family, number, goal)
        for family, pattern in FAMILIES.items()
        for number in MAPS
        for goal in GOALS
    }


def navigation_tasks() -> list[Task]:
    """Every navigation task."""
    return [Task(name, BASE, (course,)) for name, course in courses().items()]


def navigation_groups() -> dict[str, tuple[str, ...]]:
    """The names of the tasks of every group, in training order, by the group's name."""
    return {
        f"nav-{family}": tuple(name for name, course in courses().items() if course.family == family)
        for family in FAMILIES
    }
