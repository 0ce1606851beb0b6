"""Pictures of tasks: those of the package, drawn maps, and drawings of gravity and of the references."""

from functools import cache
from pathlib import Path

from markupsafe import Markup

from gym_extensions.catalog import descriptions, groups, variations
from gym_extensions.catalog.tasks import TASKS, Task
from gym_extensions.references import Reference
from gym_extensions.site import FOLDER
from gym_extensions.site.charts.svg import disc, picture, scale_around, stroke, text, tick_label
from gym_extensions.site.text import digits_for, fixed

INSTALLED = FOLDER / "pictures"
PICTURES = INSTALLED if INSTALLED.exists() else FOLDER.parents[2] / "docs" / "environments" / "pictures"


@cache
def pictures() -> dict[str, Path]:
    """The picture files of tasks by their names; none without the folder."""
    return {file.name: file for file in sorted(PICTURES.glob("*.webp"))}


def map_picture(task: Task) -> str:
    """The file name of the drawn map with its goal; empty for a task without a map."""
    courses = [variation for variation in task.variations if isinstance(variation, variations.Course)]
    return f"map{courses[0].map}-goal{courses[0].goal}.svg" if courses else ""


def task_picture(task_id: str) -> str:
    """The path of a task's picture on the site; empty without one."""
    task = TASKS.get(task_id)
    if task is None:
        return ""
    name = descriptions.picture_file(task)
    name = name if name in pictures() else map_picture(task)
    return f"pictures/{name}" if name else ""


def group_picture(group_id: str) -> str:
    """The path of the picture that stands for a group or suite; empty without one."""
    shown = groups.SUITES.get(group_id, (group_id,))[0]
    tasks = (task for group in groups.GROUPS.values() if group.id == shown for task in group.task_ids)
    return next(filter(None, map(task_picture, tasks)), "")


WALL, GOAL = "#9a7b5b", "#c62828"
SIZE = (640, 480)
"""Width and height of a map in units; y points down in pictures and up in coordinates."""


def map_shapes(description: descriptions.Description) -> str:
    """The map with its goal."""
    obstacles = "".join(
        f"M{x} {y}h{width}v{height}h-{width}" for x, y, width, height in description.obstacles
    )
    x, y = description.goal or (0.0, 0.0)
    return (
        f'<path class="wall" d="{obstacles}" fill="{WALL}"/>'
        f'<circle class="goal" cx="{x:g}" cy="{y:g}" r="20" fill="{GOAL}"/>'
    )


def map_file(description: descriptions.Description) -> str:
    """The map with its goal as an SVG file."""
    width, height = SIZE
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
        f'height="{height}"><rect width="{width}" height="{height}" fill="#fff"/>'
        f"{map_shapes(description)}</svg>\n"
    )


LENGTH, TOP = 80.0, 20
"""Length of the base body's arrow, and where arrows begin."""


def gravity_arrows(factor: float) -> Markup:
    """A picture of both arrows; their lengths are proportional to gravity."""
    arrows = ""
    for x, length, kind in ((40, 1.0, "base"), (120, factor, "changed")):
        tip = TOP + LENGTH * length
        head = f"M{x} {TOP}V{tip:g}M{x - 7} {tip - 9:g}L{x} {tip:g}L{x + 7} {tip - 9:g}"
        arrows += f'<path class="{kind}" d="{head}"/>{text("tick", x, 12, f"× {length:g}")}'
    return picture("gravity", 160, 160, f"gravity {factor:g} times that of the base body", arrows)


WIDTH, MARGIN, LINE = 480, 24, 34


def reference_dots(reference: Reference, runs: tuple[float, ...]) -> Markup:
    """The floor as a line marked 0, the expert as one marked 1, and the runs on the task alone as dots."""
    floor, agent = reference.floor.mean, reference.expert.agent if reference.expert else ""
    one = (reference.expert.mean,) if reference.expert else ()
    values = [floor, *runs, *one]
    scale = scale_around(values, MARGIN, WIDTH - MARGIN, always=())
    y, digits = LINE / 2 + 8, digits_for(values)
    parts = [stroke(scale.start, y, scale.end, y, "level")]
    parts += [text("tick", scale.at(mark), y + 24, tick_label(mark)) for mark in scale.ticks()]
    marks = [(floor, "0", "reference-floor"), *((each, "1", "cell-mean") for each in one)]
    for value, mark, kind in marks:
        parts.append(stroke(scale.at(value), y - 9, scale.at(value), y + 9, kind))
        parts.append(text("tick key", scale.at(value), y - 13, mark))
    parts += [disc("run", scale.at(run), y, 4) for run in runs]
    label = [f"floor {fixed(floor, digits)}", *(f"{agent} {fixed(each, digits)}" for each in one)]
    if runs:
        label.append(f"trained alone {', '.join(fixed(run, digits) for run in runs)}")
    return picture("references dots", WIDTH, y + 28, "; ".join(label), "".join(parts))
