"""Tasks as pages show them: pictures, references, what differs from the base body, best entries."""

from __future__ import annotations

import json
import re
import statistics
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
from gym_extensions.scoring.published import PaperRow
from gym_extensions.scoring.references import REFERENCES, load_references
from gym_extensions.scoring.scorecard import ReferencesInfo
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


@dataclass(frozen=True)
class Measured:
    """How a task's floor and ceiling were measured.

    Args:
        floor: mean return of the agent that ignores observations.
        floor_agent: its name.
        agent: the reference agent; empty if no attempt is recorded.
        budget: its training budget; empty for an agent that is not trained.
        runs: the mean return of each reference run.
        ceiling: their mean; None for an unsolved task, whose runs are attempts, and without reference runs.
        error: the standard error of the ceiling over runs; None where it is not recorded.
        floor_error: the standard error of the floor over its episodes; None where it is not recorded.
        floor_episodes: the number of these episodes.
    """

    floor: float
    floor_agent: str
    agent: str
    budget: str
    runs: tuple[float, ...]
    ceiling: float | None
    error: float | None = None
    floor_error: float | None = None
    floor_episodes: int = 0

    @property
    def is_unsolved(self) -> bool | None:
        """Whether no reference agent learned the task; None if none was trained on it."""
        return self.ceiling is None if self.agent else None


@cache
def measured(info: ReferencesInfo) -> Mapping[str, Measured]:
    """By task id, from the file of this benchmark version; empty if its digest is another."""
    if not info.sha256 or load_references(info.version).digest != info.sha256:
        return {}
    document = json.loads((REFERENCES / f"{info.version}.json").read_bytes())
    return {task: _measured(row) for task, row in document["tasks"].items()}


def _measured(row: dict[str, dict[str, object] | None]) -> Measured:
    floor, ceiling = row["floor"] or {}, row.get("ceiling")
    best = ceiling or row.get("attempts") or {}
    runs = best.get("runs")
    return Measured(
        floor=float(str(floor["mean"])),
        floor_agent=str(floor["agent"]),
        floor_error=_number(floor.get("standard_error")),
        floor_episodes=int(str(floor.get("episodes") or 0)),
        agent=str(best.get("agent") or ""),
        budget=str(best.get("budget") or ""),
        runs=tuple(float(run["mean"]) for run in runs) if isinstance(runs, list) else (),
        ceiling=float(str(ceiling["mean"])) if ceiling else None,
        error=_number(best.get("standard_error")),
    )


def _number(value: object) -> float | None:
    return value if isinstance(value, float) else None


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
    measured: Measured | None
    best: tuple[BestEntry, ...]

    @property
    def id(self) -> str:
        """The task's id."""
        return self.task.id

    @property
    def inputs(self) -> bytes:
        """What its page depends on besides the code and the references."""
        best = [(row.board.id, row.row.card.name, row.row.card.title, row.returns) for row in self.best]
        return repr((self.task, self.measured, best)).encode()

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


def reference_dots(measured: Measured) -> Markup:
    """The floor as a line marked 0, runs as dots, and their mean as a line, marked 1 if it is the ceiling."""
    values = [measured.floor, *measured.runs]
    scale = scale_around(values, MARGIN, WIDTH - MARGIN, always=())
    y, digits = LINE / 2 + 8, digits_for(values)
    parts = [stroke(scale.start, y, scale.end, y, "level")]
    parts += [text("tick", scale.at(mark), y + 24, tick_label(mark)) for mark in scale.ticks()]
    parts.append(stroke(scale.at(measured.floor), y - 9, scale.at(measured.floor), y + 9, "reference-floor"))
    parts.append(text("tick key", scale.at(measured.floor), y - 13, "0"))
    label = f"floor {fixed(measured.floor, digits)}"
    if measured.runs:
        mean = statistics.fmean(measured.runs)
        parts += [
            f'<circle class="run final" cx="{px(scale.at(run))}" cy="{px(y)}" r="4"/>'
            for run in measured.runs
        ]
        parts.append(stroke(scale.at(mean), y - 9, scale.at(mean), y + 9, "cell-mean"))
        if measured.ceiling is not None:
            parts.append(text("tick key", scale.at(mean), y - 13, "1"))
        agent = "runs of the reference agent" if measured.budget else measured.agent
        label += f"; {agent} {', '.join(fixed(run, digits) for run in measured.runs)}"
    return picture("references dots", str(WIDTH), px(y + 28), label, "".join(parts))
