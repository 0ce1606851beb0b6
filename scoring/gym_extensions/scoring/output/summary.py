"""Scorecards for people: one screen a submission, or two submissions side by side."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.text import Text

from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.metrics.paper_table import COLUMNS, shown_rows
from gym_extensions.scoring.output.console import count, heading, number, plain_table, returns_cell, span
from gym_extensions.scoring.scorecard.highlights import outstanding

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


def _metrics(out: Console, scored: Document, protocol: str) -> None:
    shown = plain_table("metric", "mean", "95 % interval")
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
        out.print(f"{', '.join(titles)}: none. {why}")


def _table(out: Console, scored: Document) -> None:
    shown = plain_table("task", *("\n".join(title.rsplit(" ", 1)) for title in COLUMNS.values()))
    for row in shown_rows(scored):
        task = row["task"].rsplit("/", 1)[-1].rsplit("-v", 1)[0]
        shown.add_row(task, *(returns_cell(row[name]) for name in COLUMNS))
    out.print(shown)


def _group(out: Console, name: str, protocol: str, scored: Document, alone: Document | None) -> None:
    runs = f", {count(len(scored['runs']), 'run')}" if scored["runs"] else ""
    out.print()
    heading(out, f"{name}, {protocol}", f", budget {scored['budget']}{runs}")
    _metrics(out, scored, protocol)
    if "table" in scored:
        _table(out, scored)
    for sentence in outstanding(scored, alone):
        out.print(f"· {sentence}")
    for note in scored.get("notes", []):
        out.print(f"! {note}")
    if scored["missing"]:
        out.print(f"missing for a full entry: {', '.join(scored['missing'])}", style="dim")


def show_line(out: Console, card: Document) -> None:
    """One line on a submission, and all its problems and notes."""
    problems = card["problems"]
    state = (count(len(problems), "problem"), "red") if problems else (card["trust"], "green")
    out.print(Text.assemble((card["name"], "bold"), f"  {card['title']}  (", state, ")"))
    for problem in problems:
        place = f"  {problem['where']}: {problem['message']}"
        out.print(Text.assemble("  ", (problem["rule"], "red"), place))
        if problem["hint"]:
            out.print(f"    {problem['hint']}")
    for note in card["notes"]:
        out.print(f"  note: {note}")


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
            out.print()
            heading(out, f"suite {suite}, {protocol}", f", {count(len(found['groups']), 'group')}")
            _metrics(out, found, protocol)
    out.print()


def show_comparison(out: Console, compared: Document) -> None:
    """Two entries side by side, with the interval of their difference."""
    first, second = compared["first"], compared["second"]
    suites = {f"suite {name}": protocols for name, protocols in compared["suites"].items()}
    for name, protocols in (compared["groups"] | suites).items():
        for protocol, found in protocols.items():
            heading(out, f"{name}, {protocol}", f", budget {found['budget']}")
            shown = plain_table("metric", first, second, "difference", "95 % interval")
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
