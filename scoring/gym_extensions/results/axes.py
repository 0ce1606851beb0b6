"""Axes to draw on, and the labels and colors of tasks."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from gym_extensions.errors import BenchError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PLOT_HINT = "Install it with: pip install 'gym-extensions[plot]'"


def new_axes(ax: Axes | None) -> Axes:
    """``ax``, or the axes of a new figure if it is None.

    Raises:
        BenchError: matplotlib is missing.
    """
    try:
        from matplotlib import pyplot
    except ModuleNotFoundError as missing:
        raise BenchError("missing-extra", f"Plots need {missing.name}.", hint=PLOT_HINT) from missing
    return pyplot.subplots(layout="constrained")[1] if ax is None else ax


def short_name(task_id: str) -> str:
    """A task's id without namespace and version: ``HopperGravityHalf``."""
    return task_id.rpartition("/")[2].rpartition("-v")[0] or task_id


def task_colors(tasks: Iterable[str]) -> dict[str, str]:
    """A color of matplotlib's cycle for each task, in the order of the tasks."""
    return {task: f"C{index}" for index, task in enumerate(dict.fromkeys(tasks))}
