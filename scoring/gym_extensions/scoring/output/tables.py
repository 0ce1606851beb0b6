"""Scorecards as flat tables: CSV for programs, Markdown for a page or a pull request."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from typing import Any

from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.metrics.paper_table import COLUMNS, shown_rows

Document = dict[str, Any]

CSV_COLUMNS = ("name", "trust", "group", "protocol", "budget", "runs", "metric", "mean", "low", "high", "why")


def _places(card: Document) -> Iterator[tuple[str, str, Document]]:
    for part in ("groups", "suites"):
        for name, protocols in card[part].items():
            for protocol, scored in protocols.items():
                yield name, protocol, scored


def csv_text(document: Document) -> str:
    """One row for each submission, group or suite, protocol and metric; a problem is a row of its own."""
    stream = io.StringIO()
    rows = csv.writer(stream, lineterminator="\n")
    rows.writerow(CSV_COLUMNS)
    for card in document["submissions"]:
        for problem in card["problems"]:
            why = f"{problem['rule']}: {problem['where']}: {problem['message']}"
            rows.writerow([card["name"], "", "", "", "", "", "", "", "", "", why])
        for name, protocol, scored in _places(card):
            runs = len(scored["runs"]) if "runs" in scored else ""
            for metric in METRICS[protocol]:
                score = scored["metrics"][metric.name]
                values = ("" if score[key] is None else repr(score[key]) for key in ("mean", "low", "high"))
                place = (name, protocol, scored["budget"], runs)
                rows.writerow(
                    [card["name"], card["trust"], *place, metric.name, *values, score.get("why", "")]
                )
    return stream.getvalue()


def _cell(text: object) -> str:
    return str(text).replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;").replace("\n", " ")


def _row(*cells: object) -> str:
    return f"| {' | '.join(map(_cell, cells))} |"


def _head(*cells: str) -> list[str]:
    return [_row(*cells), _row(*("---" for _ in cells))]


def _number(value: float | None, digits: int = 3) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def _group(name: str, protocol: str, scored: Document) -> list[str]:
    runs = f", {len(scored['runs'])} runs" if "runs" in scored else ""
    lines = [f"### {name}, {protocol}, budget {scored['budget']}{runs}", ""]
    lines += _head("metric", "mean", "95 % interval", "better")
    for metric in METRICS[protocol]:
        score = scored["metrics"][metric.name]
        span = "–" if score["low"] is None else f"{_number(score['low'])} to {_number(score['high'])}"
        lines.append(
            _row(metric.title, _number(score["mean"]), score.get("why") or span, metric.better or "–")
        )
    if "table" in scored:
        lines += ["", *_head("task", *COLUMNS.values())]
        for row in shown_rows(scored):
            cells = (row[column] for column in COLUMNS)
            shown = (f"{cell['mean']:.2f} ± {cell['std']:.2f}" if cell else "–" for cell in cells)
            lines.append(_row(row["task"].rsplit("/", 1)[-1], *shown))
    lines += ["", *(f"* {_cell(note)}" for note in scored.get("notes", []))]
    return lines


def markdown_text(document: Document) -> str:
    """A section a submission, with a table a group and protocol."""
    known = document["references"]
    lines: list[str] = []
    if known["provisional"]:
        lines += [
            f"Provisional references `{known['version']}`: fewer runs or a smaller budget.",
            "",
        ]
    for card in document["submissions"]:
        lines += [f"## {_cell(card['name'])}: {_cell(card['title'])}", ""]
        lines += [f"Trust: {card['trust']}." if not card["problems"] else "Problems:", ""]
        for problem in card["problems"]:
            told = f"{_cell(problem['where'])}: {_cell(problem['message'])} {_cell(problem['hint'])}"
            lines.append(f"* `{problem['rule']}` {told}")
        lines += [f"* {_cell(note)}" for note in card["notes"]]
        for name, protocol, scored in _places(card):
            lines += _group(name, protocol, scored)
        lines.append("")
    return "\n".join(lines).rstrip("\n") + "\n"
