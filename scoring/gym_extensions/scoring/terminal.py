"""Scorecards for people: one screen a submission, readable at 80 columns, colour only on a terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from gym_extensions.scoring.metrics import METRICS
from gym_extensions.scoring.outstanding import outstanding
from gym_extensions.scoring.table import COLUMNS, shown_rows

Document = dict[str, Any]
SHOWN = (
    "final_performance",
    "learning_performance",
    "forgetting",
    "forward_transfer",
    "single_task_performance",
    "joint_gap",
)
"""The metrics of the first screen; all are in --json, --csv and --markdown."""


class _Console(Console):
    def on_broken_pipe(self) -> None:
        """Leaves it to the command what to do when nobody reads on; rich would end the program."""
        raise BrokenPipeError


def console() -> Console:
    """Standard output: 80 columns and no colour where it is no terminal; NO_COLOR is honoured."""
    return _Console(highlight=False)


def number(value: float | None, digits: int = 3) -> str:
    """A number with a fixed count of digits, or a dash."""
    return "–" if value is None else f"{value:.{digits}f}"


def span(score: Document) -> str:
    """An interval, or a dash."""
    return "–" if score["low"] is None else f"{number(score['low'])} to {number(score['high'])}"


def count(number: int, word: str) -> str:
    """``1 run``, ``2 runs``."""
    return f"{number} {word}{'' if number == 1 else 's'}"


def _plain_table(*columns: str) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for place, column in enumerate(columns):
        table.add_column(column, justify="left" if place == 0 else "right", overflow="fold")
    return table


def _metrics(out: Console, scored: Document, protocol: str) -> None:
    shown = _plain_table("metric", "mean", "95 % interval")
    reasons: dict[str, list[str]] = {}
    for metric in METRICS[protocol]:
        score = scored["metrics"][metric.name]
        if metric.name in SHOWN and score["mean"] is not None:
            shown.add_row(metric.title, number(score["mean"]), span(score))
        elif metric.name in SHOWN:
            reasons.setdefault(score["why"], []).append(metric.title)
    if shown.row_count:
        out.print(shown)
    for why, titles in reasons.items():
        out.print(f"{', '.join(titles)}: none. {escape(why)}")


def _table(out: Console, scored: Document) -> None:
    shown = _plain_table("task", *("\n".join(title.rsplit(" ", 1)) for title in COLUMNS.values()))
    for row in shown_rows(scored):
        cells = (row[name] for name in COLUMNS)
        task = row["task"].rsplit("/", 1)[-1].rsplit("-v", 1)[0]
        shown.add_row(task, *(f"{cell['mean']:.0f} ± {cell['std']:.0f}" if cell else "–" for cell in cells))
    out.print(shown)


def _group(out: Console, name: str, protocol: str, scored: Document, alone: Document | None) -> None:
    runs = f", {count(len(scored['runs']), 'run')}" if scored["runs"] else ""
    out.print(f"\n[bold]{name}, {protocol}[/bold], budget {scored['budget']}{runs}")
    _metrics(out, scored, protocol)
    if "table" in scored:
        _table(out, scored)
    for sentence in outstanding(scored, alone):
        out.print(f"· {escape(sentence)}")
    for note in scored.get("notes", []):
        out.print(f"! {escape(note)}")
    if scored["missing"]:
        out.print(f"missing for a full entry: {', '.join(scored['missing'])}", style="dim")


def show_line(out: Console, card: Document) -> None:
    """One line on a submission, and all its problems and notes."""
    problems = card["problems"]
    state = f"[red]{count(len(problems), 'problem')}[/red]" if problems else f"[green]{card['trust']}[/green]"
    out.print(f"[bold]{escape(card['name'])}[/bold]  {escape(card['title'])}  ({state})")
    for problem in problems:
        out.print(f"  [red]{problem['rule']}[/red]  {escape(problem['where'])}: {escape(problem['message'])}")
        if problem["hint"]:
            out.print(f"    {escape(problem['hint'])}")
    for note in card["notes"]:
        out.print(f"  note: {escape(note)}")


def show(out: Console, card: Document, references: Document) -> None:
    """One submission: trust, problems, groups with intervals and the paper's table, what stands out."""
    show_line(out, card)
    scored = [
        (name, protocol, found)
        for name, protocols in card["groups"].items()
        for protocol, found in protocols.items()
    ]
    if references["provisional"] and any(found["runs"] for _, _, found in scored):
        out.print(f"  provisional references {references['version']!r}: fewer runs or a smaller budget")
    for name, protocol, found in scored:
        _group(out, name, protocol, found, card["groups"][name].get("single"))
    for suite, protocols in card["suites"].items():
        for protocol, found in protocols.items():
            out.print(f"\n[bold]suite {suite}, {protocol}[/bold], {count(len(found['groups']), 'group')}")
            _metrics(out, found, protocol)
    out.print()


def show_comparison(out: Console, compared: Document) -> None:
    """Two entries side by side, with the interval of their difference."""
    first, second = compared["first"], compared["second"]
    suites = {f"suite {name}": protocols for name, protocols in compared["suites"].items()}
    for name, protocols in (compared["groups"] | suites).items():
        for protocol, found in protocols.items():
            out.print(f"[bold]{name}, {protocol}[/bold], budget {found['budget']}")
            shown = _plain_table("metric", first, second, "difference", "95 % interval")
            for metric in METRICS[protocol]:
                if metric.name in found["metrics"]:
                    pair = found["metrics"][metric.name]
                    gap = pair["difference"]
                    cells = (number(pair["first"]), number(pair["second"]), number(gap["mean"]), span(gap))
                    shown.add_row(metric.title, *cells)
            out.print(shown)
            if not shown.row_count:
                out.print("They have no metric in common.")
    out.print("Intervals are for this pair alone (Welch); an interval without 0 separates the two.")
