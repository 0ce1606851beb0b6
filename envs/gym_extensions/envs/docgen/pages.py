"""The pages of docs/environments, made from the catalog."""

from __future__ import annotations

from collections.abc import Iterable

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import EXTRAS, PAPER_GROUPS, TaskGroup
from gym_extensions.catalog.navigation_tasks import FAMILIES, MAPS
from gym_extensions.catalog.registry import TASKS, task
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.obstacles import RangeSensor
from gym_extensions.envs.docgen.descriptions import differences
from gym_extensions.envs.docgen.prose import HISTORY, PROSE
from gym_extensions.envs.docgen.summary import PICTURE
from gym_extensions.envs.docgen.tables import Field, action_fields, indexed, observation_fields
from gym_extensions.envs.docgen.thumbnails import map_picture, pictured, task_picture

NOTE = "<!-- Written by `gym-extensions envs docs`; edit the catalog instead. -->"
IMAGE_FAMILY = "image"
PICTURED = dict.fromkeys(("Pusher", "Striker"), "After a reset with seed 0.")


def pages() -> dict[str, str]:
    """The text of every page by its file name: an index, and a page a base body."""
    bases = list(dict.fromkeys(row.base for row in TASKS.values()))
    made = {"README.md": _index(bases)}
    for base in bases:
        made[_file(base)] = _navigation() if base == "Navigation" else _body(base)
    return made


def _file(base: str) -> str:
    return f"{base.lower()}.md"


def _index(bases: Iterable[str]) -> str:
    lines = ["# Environments", "", NOTE, ""]
    lines += [
        f"{len(TASKS)} tasks in {len(PAPER_GROUPS) + len(EXTRAS)} groups, trained in the order below.",
        "",
    ]
    bodies = [f"* [{base}]({_file(base)}): {PROSE[base].what}" for base in bases]
    lines += ["## Base bodies", "", *bodies, ""]
    lines += [
        "## The paper's groups",
        "",
        *_groups(PAPER_GROUPS),
        "",
        "## Further groups",
        "",
        *_groups(EXTRAS),
        "",
    ]
    lines += [
        "`gym-extensions envs show ID` prints everything about one task, `gym-extensions envs check` compares"
    ]
    lines += ["every task with its published fingerprint.", ""]
    return "\n".join(lines)


def _groups(groups: Iterable[TaskGroup]) -> list[str]:
    rows = [(f"`{group.id}`", _names(group)) for group in groups]
    return _table(("group", "tasks, in training order"), rows)


def _names(group: TaskGroup) -> str:
    if group.tasks[0].base != "Navigation":
        return ", ".join(row.name for row in group.tasks)
    return (
        f"{group.tasks[0].name}, {group.tasks[1].name}, … {group.tasks[-1].name} ({len(group.tasks)} tasks)"
    )


def _body(base: str) -> str:
    tasks = [row for row in TASKS.values() if row.base == base]
    plain = tasks[0]
    sensing = [row for row in tasks if RangeSensor() in row.variations]
    lines = [*_head(base), *_play(base, plain)]
    lines += ["## Action", "", *_fields(action_fields(plain)), ""]
    lines += ["## Observation", "", *_fields(observation_fields(plain)), ""]
    if sensing:
        beams = [row for row in indexed(observation_fields(sensing[0])) if "beam" in row[1].meaning]
        lines += ["With a range sensor, in addition:", "", *_rows(beams), ""]
    lines += ["## Tasks", "", *_tasks(tasks), "", *_versions(tasks)]
    shown = [row for row in tasks if pictured(row)]
    lines += ["## Pictures", "", PICTURED.get(base, "In the rest pose, all from the same place."), ""]
    cells = [f"![{row.name}](pictures/{task_picture(row)})<br>{row.name}" for row in shown]
    lines += [*_grid(cells, 4), ""]
    return "\n".join(lines)


def _navigation() -> str:
    first = {family: task(_name(family)) for family in FAMILIES}
    tasks = [row for row in TASKS.values() if row.base == "Navigation"]
    lines = [*_head("Navigation"), *_play("Navigation", tasks[0])]
    lines += [
        "The map is a grid of 64 × 48 cells of 10 units with a solid border; y points up. The agent is a",
        "point. If the straight way to its new place touches an occupied cell, it stays where it is: a",
        "collision.",
        "",
    ]
    lines += ["## Action", "", *_fields(action_fields(tasks[0])), "", "## Observation", ""]
    for family, row in first.items():
        lines += [f"### `{FAMILIES[family].format(map='{m}', goal='{g}')}`", ""]
        lines += [PICTURE + ".", ""] if family == IMAGE_FAMILY else [*_fields(observation_fields(row)), ""]
    lines += ["## Tasks", "", *_tasks(tasks), "", *_versions(tasks)]
    lines += ["## Maps", "", "Each with its three goals.", ""]
    lines += [
        *_grid([f"![map {number}](pictures/{map_picture(number)})<br>map {number}" for number in MAPS], 3),
        "",
    ]
    return "\n".join(lines)


def _name(family: str) -> str:
    return FAMILIES[family].format(map=0, goal=0)


def _head(base: str) -> list[str]:
    return [f"# {base}", "", NOTE, "", PROSE[base].what, "", f"Source: {PROSE[base].source}", ""]


def _play(base: str, row: Task) -> list[str]:
    prose = PROSE[base]
    facts = {
        "Reward": prose.reward,
        "Start": prose.start,
        "End": prose.end,
        "Time limit": f"{row.max_steps} steps.",
    }
    return [*(f"* **{name}**: {text}" for name, text in facts.items()), ""]


def _fields(fields: Iterable[Field]) -> list[str]:
    return _rows(indexed(fields))


def _rows(rows: Iterable[tuple[str, Field]]) -> list[str]:
    cells = [(place, field.meaning, field.unit, field.range) for place, field in rows]
    return _table(("index", "meaning", "unit", "range"), cells)


def _tasks(tasks: Iterable[Task]) -> list[str]:
    rows = [(f"`{row.id}`", " ".join(differences(row)) or "–", f"`{published(row.id)}`") for row in tasks]
    return _table(("task", "what differs", "fingerprint"), rows)


def _versions(tasks: Iterable[Task]) -> list[str]:
    newest = max(row.version for row in tasks)
    history = [f"* v{number}: {HISTORY[number]}." for number in range(newest + 1)]
    return ["## Versions", "", *history, ""]


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> list[str]:
    lines = [head, tuple("---" for _ in head), *rows]
    return ["| " + " | ".join(text.replace("|", "\\|") for text in line) + " |" for line in lines]


def _grid(cells: list[str], columns: int) -> list[str]:
    padded = [*cells, *[""] * (-len(cells) % columns)]
    lines = [padded[start : start + columns] for start in range(0, len(padded), columns)]
    return ["| " + " | ".join(line) + " |" for line in ([""] * columns, ["---"] * columns, *lines)]
