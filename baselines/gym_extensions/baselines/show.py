"""How far the training is: bars on a terminal, a line for each finished cell in a log."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from gym_extensions.baselines.protocol import News
from gym_extensions.baselines.units import Unit
from gym_extensions.catalog.protocol import budget


class Screen:
    """Hears news of units and shows them; work is counted in evaluated cells and trained stages' steps."""

    def __init__(self, budget_name: str, console: Console, bars: Progress | None) -> None:
        self._budget, self._console, self._bars = budget_name, console, bars
        self._rows: dict[Unit, TaskID] = {}
        self._total: TaskID | None = None
        self._finished = 0

    def plan(self, units: Sequence[Unit]) -> None:
        """Says how much there is to do."""
        steps = sum(unit.steps(budget(self._budget)) for unit in units)
        if self._bars is None:
            self._console.print(f"{len(units)} units, {steps:,} training steps", highlight=False)
        else:
            self._total = self._bars.add_task("all cells", total=sum(self._cells(unit) for unit in units))

    def hear(self, news: News) -> None:
        """Moves a bar, or prints a line for a finished cell."""
        unit = news.unit
        text = f"{unit.group} {unit.name} stage {news.stage}"
        if self._bars is None:
            if news.evaluated:
                line = f"{text}: {news.evaluated} mean return {news.mean:.1f}"
                self._console.print(line, highlight=False, soft_wrap=True)
            return
        row = self._row(unit)
        if news.evaluated:
            self._bars.update(row, description=f"{text} evaluating")
            self._bars.advance(row)
            if self._total is not None:
                self._bars.advance(self._total)
        else:
            self._bars.update(row, description=f"{text} training {news.steps:,}")

    def _row(self, unit: Unit) -> TaskID:
        if unit not in self._rows and self._bars is not None:
            for old in [one for one in self._rows if self._bars.tasks and self._is_done(one)]:
                self._bars.remove_task(self._rows.pop(old))
            self._rows[unit] = self._bars.add_task(unit.name, total=self._cells(unit))
        return self._rows[unit]

    def _is_done(self, unit: Unit) -> bool:
        if self._bars is None:
            return False
        return any(row.id == self._rows[unit] and row.finished for row in self._bars.tasks)

    def _cells(self, unit: Unit) -> int:
        return sum(len(stage.evaluated) for stage in unit.stages(budget(self._budget)))


@contextmanager
def shown(budget_name: str) -> Iterator[Screen]:
    """A screen for one command: bars where there is a terminal, plain lines elsewhere."""
    console = Console()
    if not console.is_terminal:
        yield Screen(budget_name, console, None)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bars:
        yield Screen(budget_name, console, bars)
