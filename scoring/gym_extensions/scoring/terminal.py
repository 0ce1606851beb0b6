"""Scorecards for people: one screen a submission, readable at 80 columns, colour only on a terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from gym_extensions.scoring.metrics import METRICS
from gym_extensions.scoring.table import COLUMNS

Document = dict[str, Any]
SHOWN = (
    "final_performance",
    "learning_performance",
    "forgetting",
    "forward_transfer",
    "single_task_performance",
)


def number(value: float | None, digits: int = 3) -> str:
    """A number with a fixed count of digits, or a dash."""
    return "–" if value is None else f"{value:.{digits}f}"


def _metrics(scored: Document, protocol: str) -> Table:
    shown = Table("metric", "mean", "95 % interval", "runs", box=None, pad_edge=False)
    for metric in METRICS[protocol]:
        score = scored["metrics"][metric.name]
        if metric.name in SHOWN and score["mean"] is None:
            shown.add_row(metric.title, "–", escape(score["why"]))
        elif score["mean"] is not None:
            span = "–" if score["low"] is None else f"{number(score['low'])} to {number(score['high'])}"
            shown.add_row(metric.title, number(score["mean"]), span, str(len(score["runs"]) or ""))
    return shown


def _table(scored: Document) -> Table:
    shown = Table("task", *COLUMNS.values(), box=None, pad_edge=False)
    for row in [*scored["table"], {"task": "total", **scored["total"]}]:
        cells = [row[name] for name in COLUMNS]
        task = row["task"].rsplit("/", 1)[-1]
        shown.add_row(task, *(f"{cell['mean']:.0f} ± {cell['std']:.0f}" if cell else "–" for cell in cells))
    return shown


def show(document: Document, console: Console | None = None) -> None:
    """Prints every submission of a document: its trust, its problems or its groups."""
    out = console or Console(highlight=False, soft_wrap=True)
    for card in document["submissions"]:
        problems = card["problems"]
        state = f"{len(problems)} problem{'s' if len(problems) > 1 else ''}" if problems else card["trust"]
        out.print(f"[bold]{escape(card['name'])}[/bold]  {escape(card['title'])}  ({state})")
        for problem in problems:
            out.print(
                f"  [red]{problem['rule']}[/red]  {escape(problem['where'])}: {escape(problem['message'])}"
            )
            out.print(f"    {escape(problem['hint'])}")
        for note in card["notes"]:
            out.print(f"  note: {escape(note)}")
        for name, protocols in card["groups"].items():
            for protocol, scored in protocols.items():
                runs = len(scored["runs"])
                out.print(
                    f"\n{name}, {protocol}, budget {scored['budget']}, {runs} run{'s' if runs > 1 else ''}"
                )
                out.print(_metrics(scored, protocol))
                if protocol == "sequential":
                    out.print(_table(scored))
                if scored["missing"]:
                    out.print(f"missing for a full entry: {', '.join(scored['missing'])}")
        out.print()
