"""How far the work is: bars on a terminal, a line for each finished cell in a log."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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

from gym_extensions.baselines.training.runner import News


class Screen:
    """Hears how far each piece of work is and shows it, counted in evaluated cells."""

    def __init__(self, console: Console, bars: Progress | None) -> None:
        self._console, self._bars = console, bars
        self._cells: dict[str, int] = {}
        self._rows: dict[str, TaskID] = {}
        self._total: TaskID | None = None

    def plan(self, cells: Mapping[str, int]) -> None:
        """Says how much there is to do: the cells of every piece of work, by its title."""
        self._cells = dict(cells)
        if self._bars is None:
            self._line(f"{len(cells)} units to run, {sum(cells.values())} cells to evaluate")
        elif cells:
            self._total = self._bars.add_task("all", total=sum(cells.values()))

    def hear(self, news: News) -> None:
        """Moves a bar, or prints a line for a finished cell."""
        text = f"{news.work} stage {news.stage}"
        if self._bars is None:
            if news.evaluated:
                self._line(f"{text}: {news.evaluated} mean return {news.mean:.1f}")
            return
        if news.work not in self._rows:
            self._rows[news.work] = self._bars.add_task(news.work, total=self._cells.get(news.work))
        row = self._rows[news.work]
        if not news.evaluated:
            self._bars.update(row, description=f"{text} training {news.steps:,}")
            return
        self._bars.update(row, description=f"{text} evaluating", advance=1)
        if self._total is not None:
            self._bars.advance(self._total)
        self._cells[news.work] -= 1
        if self._cells[news.work] <= 0:
            self._bars.remove_task(row)

    def _line(self, text: str) -> None:
        self._console.print(text, highlight=False, soft_wrap=True, markup=False)


@contextmanager
def shown() -> Iterator[Screen]:
    """A screen for one command: bars where there is a terminal, plain lines elsewhere."""
    console = Console()
    if not console.is_terminal:
        yield Screen(console, None)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bars:
        yield Screen(console, bars)
