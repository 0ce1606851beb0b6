"""Prints scorecards for people, one screen per submission, or two submissions side by side."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from gym_extensions.scoring.leaderboard.model import Comparison
from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.metrics.paper_table import COLUMNS
from gym_extensions.scoring.output.console import (
    count,
    heading,
    number,
    plain_table,
    returns_cell,
    span,
    table_rows,
)
from gym_extensions.scoring.scorecard.highlights import highlights, task_name
from gym_extensions.scoring.scorecard.model import GroupScore, ReferencesInfo, Scorecard, SuiteScore

SHOWN = (
    "final_performance",
    "learning_performance",
    "forgetting",
    "asymptotic_transfer",
    "single_task_performance",
    "joint_gap",
)
"""The metrics of the screen; --json, --csv and --markdown have all."""


def _metrics(out: Console, score: GroupScore | SuiteScore, protocol: str) -> None:
    table = plain_table("metric", "mean", "95 % interval")
    reasons: dict[str, list[str]] = {}
    for metric in METRICS[protocol]:
        value = score.metrics[metric.name]
        if metric.name in SHOWN and value.mean is not None:
            table.add_row(metric.title, number(value.mean), span(value))
        elif metric.name in SHOWN:
            reasons.setdefault(value.why, []).append(metric.title)
    if table.row_count:
        out.print(table)
    for why, titles in reasons.items():
        out.print(f"{', '.join(titles)}: none. {why}")


def _table(out: Console, score: GroupScore) -> None:
    table = plain_table("task", *("\n".join(title.rsplit(" ", 1)) for title in COLUMNS.values()))
    for name, cells in table_rows(score):
        table.add_row(task_name(name), *map(returns_cell, cells))
    out.print(table)


def _group(out: Console, name: str, protocol: str, score: GroupScore, single: GroupScore | None) -> None:
    runs = f", {count(len(score.runs), 'run')}" if score.runs else ""
    out.print()
    custom = "" if score.published else ", custom group (not published)"
    heading(out, f"{name}, {protocol}", f", budget {score.budget}{runs}{custom}")
    _metrics(out, score, protocol)
    if score.paper_table:
        _table(out, score)
    for sentence in highlights(score, single):
        out.print(f"· {sentence}")
    for note in score.notes:
        out.print(f"! {note}")
    if score.missing_evidence:
        out.print(f"! no rank: {score.missing_evidence}")
    if score.missing_for_full_entry:
        out.print(f"missing for a full entry: {', '.join(score.missing_for_full_entry)}", style="dim")


def show_line(out: Console, card: Scorecard) -> None:
    """One line per submission, with all its problems and notes."""
    state = (count(len(card.problems), "problem"), "red") if card.problems else (str(card.trust), "green")
    out.print(Text.assemble((card.name, "bold"), f"  {card.title}  (", state, ")"))
    for problem in card.problems:
        message = f"  {problem.where}: {problem.message}"
        out.print(Text.assemble("  ", (problem.rule, "red"), message))
        if problem.hint:
            out.print(f"    {problem.hint}")
    for note in card.notes:
        out.print(f"  note: {note}")


def show(out: Console, card: Scorecard, references: ReferencesInfo) -> None:
    """One submission, with trust, problems, and per group the metrics, the paper's table and highlights."""
    show_line(out, card)
    scores = [
        (name, protocol, score)
        for name, protocols in card.groups.items()
        for protocol, score in protocols.items()
    ]
    if references.provisional and any(score.runs for _, _, score in scores):
        out.print(f"  provisional references {references.version!r}: fewer runs or a smaller budget")
    for name, protocol, score in scores:
        _group(out, name, protocol, score, card.groups[name].get("single"))
    for suite, suite_protocols in card.suites.items():
        for protocol, suite_score in suite_protocols.items():
            out.print()
            heading(out, f"suite {suite}, {protocol}", f", {count(len(suite_score.groups), 'group')}")
            _metrics(out, suite_score, protocol)
    out.print()


def show_comparison(out: Console, comparison: Comparison) -> None:
    """Two entries side by side, with the interval of their difference."""
    suites = {f"suite {name}": protocols for name, protocols in comparison.suites.items()}
    has_intervals = False
    for name, protocols in (comparison.groups | suites).items():
        for protocol, score in protocols.items():
            heading(out, f"{name}, {protocol}", f", budget {score.budget}")
            table = plain_table("metric", comparison.first, comparison.second, "difference", "95 % interval")
            for metric in METRICS[protocol]:
                if pair := score.metrics.get(metric.name):
                    numbers = map(number, (pair.first, pair.second, pair.difference.mean))
                    table.add_row(metric.title, *numbers, span(pair.difference))
                    has_intervals = has_intervals or pair.difference.low is not None
            out.print(table)
            if not table.row_count:
                out.print(
                    "They have no metric in common: see `score` on each. Custom groups need --references."
                )
    if has_intervals:
        out.print("Intervals are for this pair alone (Welch); an interval without 0 separates the two.")
