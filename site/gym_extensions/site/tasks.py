"""Tasks as pages show them: pictures, references, what differs from the base body, best entries."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

from markupsafe import Markup, escape

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import GROUPS, SUITES
from gym_extensions.catalog.sheets import Sheet, large_picture, sheet
from gym_extensions.catalog.tasks import TASKS, VERSIONS, Task, task
from gym_extensions.catalog.variations import Course, Gravity
from gym_extensions.experts.references import REFERENCES, parse_file
from gym_extensions.experts.references import Task as Reference
from gym_extensions.scoring.references import load_references, trained_alone
from gym_extensions.scoring.scorecard import PaperRow, ReferencesInfo
from gym_extensions.site.boards import Board, Row
from gym_extensions.site.charts.svg import picture, px, scale_around, stroke, text, tick_label
from gym_extensions.site.text import digits_for, fixed, is_verified
from gym_extensions.site.trial import SEQUENTIAL

FOLDER = Path(__file__).parent / "pictures"


@cache
def pictures() -> dict[str, Path]:
    """The picture files of the package by their names; empty without the folder."""
    return {file.name: file for file in sorted(FOLDER.iterdir())} if FOLDER.is_dir() else {}


def map_picture(task: Task) -> str:
    """The file name of the drawn map with its goal; empty for a task without a map."""
    courses = [variation for variation in task.variations if isinstance(variation, Course)]
    return f"map{courses[0].map}-goal{courses[0].goal}.svg" if courses else ""


def task_picture(task_id: str) -> str:
    """The path of a task's picture on the site; empty without one."""
    task = TASKS.get(task_id)
    if task is None:
        return ""
    name = large_picture(task)
    name = name if name in pictures() else map_picture(task)
    return f"pictures/{name}" if name else ""


def group_picture(group_id: str) -> str:
    """The path of the picture that stands for a group or suite; empty without one."""
    member = next(
        (group for group in GROUPS.values() if group.id == SUITES.get(group_id, (group_id,))[0]), None
    )
    tasks = member.task_ids if member else ()
    return next((path for task in tasks if (path := task_picture(task))), "")


WALL, GOAL = "#9a7b5b", "#c62828"
SIZE = (640, 480)
"""Width and height of a map in units; y points down in pictures and up in coordinates."""


def map_file(sheet: Sheet) -> str:
    """The map with its goal as an SVG file."""
    obstacles = "".join(f"M{x} {y}h{width}v{height}h-{width}" for x, y, width, height in sheet.obstacles)
    x, y = sheet.goal or (0.0, 0.0)
    width, height = SIZE
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
        f'height="{height}"><rect width="{width}" height="{height}" fill="#fff"/>'
        f'<path d="{obstacles}" fill="{WALL}"/><circle cx="{x:g}" cy="{y:g}" r="20" fill="{GOAL}"/></svg>\n'
    )


@cache
def measured(info: ReferencesInfo) -> Mapping[str, Reference]:
    """Floor and expert by task id, of this benchmark version; empty if the digest of its file is another."""
    if not info.sha256 or load_references(info.version).digest != info.sha256:
        return {}
    return parse_file((REFERENCES / f"{info.version}.json").read_bytes()).tasks


def alone(task_id: str) -> tuple[float, ...]:
    """The mean return of each run of the reference agent on a task alone."""
    found = trained_alone().get(task_id)
    return tuple(run.mean for run in found.runs) if found else ()


BEST = 5
"""Entries that the page of a task lists."""


@dataclass(frozen=True)
class BestEntry:
    """An entry on a board, with the mean returns of one task."""

    board: Board
    row: Row
    returns: PaperRow

    @property
    def end(self) -> float:
        """The mean return at the end."""
        return self.returns.fully_trained.mean if self.returns.fully_trained else float("-inf")


@dataclass(frozen=True)
class TaskView:
    """A task as its page shows it."""

    task: Task
    measured: Reference | None
    best: tuple[BestEntry, ...]

    @property
    def id(self) -> str:
        """The task's id."""
        return self.task.id

    @property
    def inputs(self) -> bytes:
        """What its page depends on besides the code and the references."""
        best = [(row.board.id, row.row.card.name, row.row.card.title, row.returns) for row in self.best]
        return repr((self.task, self.measured, alone(self.id), best)).encode()

    @cached_property
    def sheet(self) -> Sheet | None:
        """What follows from its model."""
        return sheet(self.task.id)

    @property
    def base(self) -> Task | None:
        """The task of the base body without variations; None for that task itself and for maps."""
        if not self.task.variations or self.task.body.family == "navigation":
            return None
        return task(self.task.base)

    @property
    def picture(self) -> str:
        """The path of its picture; empty without one."""
        return task_picture(self.task.id)

    @property
    def base_picture(self) -> str:
        """The path of the base body's picture; empty if it is the same."""
        picture = task_picture(self.base.id) if self.base else ""
        return "" if picture == self.picture else picture

    @property
    def gravity(self) -> float | None:
        """Its gravity relative to that of the base body; None if gravity does not differ."""
        factors = [variation.factor for variation in self.task.variations if isinstance(variation, Gravity)]
        return factors[0] if factors else None

    @property
    def fingerprint(self) -> str:
        """Its published fingerprint."""
        return published(self.task.id)

    @property
    def versions(self) -> tuple[tuple[int, str], ...]:
        """Each version and what changed with it."""
        return tuple((number, VERSIONS[number]) for number in range(self.task.version + 1))

    @property
    def facts(self) -> tuple[tuple[str, Markup], ...]:
        """Reward, start, end, time limit, success and source, in words."""
        prose, success = self.task.body.prose, self.task.body.success
        facts = (
            ("Reward per step", prose.reward),
            ("Start", prose.start),
            ("End", prose.end),
            ("Time limit", f"{self.task.max_steps} steps."),
            ("Success", success.text if success else "Not defined."),
            ("Source", prose.source),
        )
        return tuple((name, _with_code(text)) for name, text in facts)

    @property
    def groups(self) -> tuple[tuple[str, int, int], ...]:
        """Id of each group that it belongs to, its position there, and the number of tasks."""
        return tuple(
            (group.id, group.task_ids.index(self.task.id) + 1, len(group.tasks))
            for group in GROUPS.values()
            if self.task.id in group.task_ids
        )


def _with_code(text: str) -> Markup:
    """A text of the catalog, with what is between backticks as code."""
    return Markup(re.sub(r"`([^`]*)`", r"<code>\1</code>", str(escape(text))))


def best_entries(boards: Sequence[Board]) -> dict[str, tuple[BestEntry, ...]]:
    """The verified entries with the highest return at the end of sequential training, by task id."""
    by_task: dict[str, list[BestEntry]] = {}
    for board in boards:
        if board.protocol != SEQUENTIAL or board.suite:
            continue
        for row in board.rows:
            detail = row.trial.detail
            if detail is None or row.duplicate_of or not is_verified(row.card):
                continue
            for returns in detail.paper_table:
                if returns.fully_trained:
                    by_task.setdefault(returns.task, []).append(BestEntry(board, row, returns))
    return {
        name: tuple(sorted(rows, key=lambda best: (-best.end, best.row.card.name))[:BEST])
        for name, rows in by_task.items()
    }


def by_base() -> dict[str, tuple[Task, ...]]:
    """Every published task by the name of its base body, in the order of the catalog."""
    bases: dict[str, list[Task]] = {}
    for row in TASKS.values():
        bases.setdefault(row.base, []).append(row)
    return {base: tuple(rows) for base, rows in bases.items()}


LENGTH, TOP = 80.0, 20
"""Length of the base body's arrow, and where arrows begin."""


def gravity_arrows(factor: float) -> Markup:
    """A picture of both arrows; their lengths are proportional to gravity."""
    arrows = _arrow(40, 1.0, "base", "× 1") + _arrow(120, factor, "changed", f"× {factor:g}")
    return picture("gravity", "160", "160", f"gravity {factor:g} times that of the base body", arrows)


def _arrow(x: int, factor: float, kind: str, label: str) -> str:
    tip = TOP + LENGTH * factor
    head = f"M{x} {TOP}V{tip:g}M{x - 7} {tip - 9:g}L{x} {tip:g}L{x + 7} {tip - 9:g}"
    return f'<path class="{kind}" d="{head}"/><text class="tick" x="{x}" y="12">{label}</text>'


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
    parts += [f'<circle class="run" cx="{px(scale.at(run))}" cy="{px(y)}" r="4"/>' for run in runs]
    label = [f"floor {fixed(floor, digits)}", *(f"{agent} {fixed(each, digits)}" for each in one)]
    if runs:
        label.append(f"trained alone {', '.join(fixed(run, digits) for run in runs)}")
    return picture("references dots", str(WIDTH), px(y + 28), "; ".join(label), "".join(parts))
