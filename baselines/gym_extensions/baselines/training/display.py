"""Progress on the screen: bars on a terminal, else one line per evaluated task."""

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

from gym_extensions.baselines.training.events import Event


class Screen:
    """Shows the progress of every job, measured in evaluated tasks."""

    def __init__(self, console: Console, bars: Progress | None) -> None:
        self._console, self._bars = console, bars
        self._remaining: dict[str, int] = {}
        self._rows: dict[str, TaskID] = {}
        self._total: TaskID | None = None

    def plan(self, evaluations: Mapping[str, int]) -> None:
        """Announces the work: the number of evaluations of every job, by its title."""
        self._remaining = dict(evaluations)
        total = sum(evaluations.values())
        if self._bars is None:
            self._print(f"{len(evaluations)} jobs, {total} evaluations")
        elif evaluations:
            self._total = self._bars.add_task("all", total=total)

    def show(self, event: Event) -> None:
        """Moves a bar, or prints a line for an evaluated task."""
        text = f"{event.job} stage {event.stage}"
        if self._bars is None:
            if event.task:
                self._print(f"{text}: {event.task} mean return {event.mean_return:.1f}")
            return
        if event.job not in self._rows:
            self._rows[event.job] = self._bars.add_task(event.job, total=self._remaining.get(event.job))
        row = self._rows[event.job]
        if not event.task:
            self._bars.update(row, description=f"{text} training {event.steps:,}")
            return
        self._bars.update(row, description=f"{text} evaluating", advance=1)
        if self._total is not None:
            self._bars.advance(self._total)
        self._remaining[event.job] -= 1
        if self._remaining[event.job] <= 0:
            self._bars.remove_task(row)

    def _print(self, text: str) -> None:
        self._console.print(text, highlight=False, soft_wrap=True, markup=False)


@contextmanager
def open_screen() -> Iterator[Screen]:
    """A screen for one command: bars on a terminal, plain lines elsewhere."""
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
