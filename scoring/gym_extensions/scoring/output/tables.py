"""Scorecards as flat tables: CSV for programs, Markdown for a page or a pull request."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator

from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.metrics.paper_table import COLUMNS, PaperCell
from gym_extensions.scoring.output.console import number, span
from gym_extensions.scoring.scorecard.model import GroupScore, Scorecard, ScorecardDocument, SuiteScore

CSV_COLUMNS = ("name", "trust", "group", "protocol", "budget", "runs", "metric", "mean", "low", "high", "why")


def table_rows(score: GroupScore) -> Iterator[tuple[str, list[PaperCell | None]]]:
    """The paper's table row by row: task id or name of the total, and the four cells."""
    for row in score.paper_table:
        yield row.task, row.cells()
    for name, total in (("total", score.paper_total), ("printed total", score.printed_total)):
        if total:
            yield name, total.cells()


def _scores(card: Scorecard) -> Iterator[tuple[str, str, GroupScore | SuiteScore]]:
    for scores in (card.groups, card.suites):
        for name, protocols in scores.items():
            for protocol, score in protocols.items():
                yield name, protocol, score


def csv_text(document: ScorecardDocument) -> str:
    """One row per submission, group or suite, protocol and metric; one row per problem."""
    stream = io.StringIO()
    rows = csv.writer(stream, lineterminator="\n")
    rows.writerow(CSV_COLUMNS)
    for card in document.submissions:
        for problem in card.problems:
            why = f"{problem.rule}: {problem.where}: {problem.message}"
            rows.writerow([card.name, *[""] * (len(CSV_COLUMNS) - 2), why])
        for name, protocol, score in _scores(card):
            runs = len(score.runs) if isinstance(score, GroupScore) else ""
            for metric in METRICS[protocol]:
                value = score.metrics[metric.name]
                ends = ("" if end is None else repr(end) for end in (value.mean, value.low, value.high))
                group = (name, protocol, score.budget, runs)
                rows.writerow([card.name, card.trust, *group, metric.name, *ends, value.why])
    return stream.getvalue()


def _cell(text: object) -> str:
    return str(text).replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;").replace("\n", " ")


def _row(*cells: object) -> str:
    return f"| {' | '.join(map(_cell, cells))} |"


def _head(*cells: str) -> list[str]:
    return [_row(*cells), _row(*("---" for _ in cells))]


def _group(name: str, protocol: str, score: GroupScore | SuiteScore) -> list[str]:
    runs = f", {len(score.runs)} runs" if isinstance(score, GroupScore) else ""
    custom = "" if isinstance(score, SuiteScore) or score.published else ", custom group (not published)"
    lines = [f"### {name}, {protocol}, budget {score.budget}{runs}{custom}", ""]
    lines += _head("metric", "mean", "95 % interval", "better")
    for metric in METRICS[protocol]:
        value = score.metrics[metric.name]
        lines.append(_row(metric.title, number(value.mean), value.why or span(value), metric.better or "–"))
    if isinstance(score, SuiteScore):
        return [*lines, ""]
    if score.paper_table:
        lines += ["", *_head("task", *COLUMNS.values())]
        for task, cells in table_rows(score):
            texts = (f"{cell.mean:.2f} ± {cell.std:.2f}" if cell else "–" for cell in cells)
            lines.append(_row(task.rsplit("/", 1)[-1], *texts))
    return [*lines, "", *(f"* {_cell(note)}" for note in score.notes)]


def markdown_text(document: ScorecardDocument) -> str:
    """One section per submission, one table per group and protocol."""
    lines: list[str] = []
    if document.references.provisional:
        version = document.references.version
        lines += [f"Provisional references `{version}`: fewer runs or a smaller budget.", ""]
    for card in document.submissions:
        lines += [f"## {_cell(card.name)}: {_cell(card.title)}", ""]
        lines += ["Problems:" if card.problems else f"Trust: {card.trust}.", ""]
        for problem in card.problems:
            message = f"{_cell(problem.where)}: {_cell(problem.message)} {_cell(problem.hint)}"
            lines.append(f"* `{problem.rule}` {message}")
        lines += [f"* {_cell(note)}" for note in card.notes]
        for name, protocol, score in _scores(card):
            lines += _group(name, protocol, score)
        lines.append("")
    return "\n".join(lines).rstrip("\n") + "\n"
