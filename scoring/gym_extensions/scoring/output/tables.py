"""Scorecards as CSV for programs and as Markdown for a page or a pull request, from the same data frame."""

from __future__ import annotations

import pandas as pd

from gym_extensions.scoring.metrics.definitions import BY_NAME
from gym_extensions.scoring.metrics.paper_table import COLUMNS
from gym_extensions.scoring.output.console import count, number, table_rows
from gym_extensions.scoring.output.frames import metrics_frame, scores
from gym_extensions.scoring.output.spreadsheet import no_formula
from gym_extensions.scoring.scorecard.model import GroupScore, ScorecardDocument, SuiteScore

KEY = ["name", "group", "protocol"]


def csv_text(document: ScorecardDocument) -> str:
    """The frame of all metrics as CSV: floats by ``repr``, missing values empty.

    Texts that a spreadsheet would take for a formula begin with an apostrophe.
    """
    frame = metrics_frame(document)
    texts = frame.columns[frame.dtypes == "str"]
    frame[texts] = frame[texts].map(no_formula, na_action="ignore")
    return frame.to_csv(index=False, lineterminator="\n")


def _cell(text: object) -> str:
    return str(text).replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;").replace("\n", " ")


def _row(*cells: object) -> str:
    return f"| {' | '.join(map(_cell, cells))} |"


def _head(*cells: str) -> list[str]:
    return [_row(*cells), _row(*("---" for _ in cells))]


def _metric_lines(frame: pd.DataFrame) -> dict[tuple[str, str, str], list[str]]:
    """The lines of each table of metrics by submission, group or suite, and protocol."""
    mean, low, high = (
        frame[end].map(number, na_action="ignore").astype("str") for end in ("mean", "low", "high")
    )
    interval = frame["why"].where(frame["why"] != "", (low + " to " + high).fillna("–"))
    cells = frame[[*KEY, "metric"]].assign(mean=mean.fillna("–"), interval=interval)
    lines: dict[tuple[str, str, str], list[str]] = {}
    for name, group, protocol, metric, *texts in cells.dropna(subset=KEY).itertuples(index=False):
        row = _row(BY_NAME[metric].title, *texts, BY_NAME[metric].better or "–")
        lines.setdefault((name, group, protocol), []).append(row)
    return lines


def _group(name: str, protocol: str, score: GroupScore | SuiteScore, metrics: list[str]) -> list[str]:
    runs = f", {count(len(score.runs), 'run')}" if isinstance(score, GroupScore) else ""
    custom = "" if isinstance(score, SuiteScore) or score.published else ", custom group (not published)"
    lines = [f"### {name}, {protocol}, budget {score.budget}{runs}{custom}", ""]
    lines += [*_head("metric", "mean", "95 % interval", "better"), *metrics]
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
    metrics = _metric_lines(metrics_frame(document))
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
        for name, protocol, score in scores(card):
            lines += _group(name, protocol, score, metrics[card.name, name, protocol])
        lines.append("")
    return "\n".join(lines).rstrip("\n") + "\n"
