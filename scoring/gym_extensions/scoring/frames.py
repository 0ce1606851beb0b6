"""Scorecards and boards as pandas data frames, and from them as CSV and Markdown. Loads pandas."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import pandas as pd

from gym_extensions.catalog.groups import CORE, CORES
from gym_extensions.scoring.boards import Board, BoardEntry, CoreBoard, CoreEntry
from gym_extensions.scoring.comparisons import REFERENCE, SHOWN
from gym_extensions.scoring.documents import no_formula
from gym_extensions.scoring.metrics import BOARD_METRICS, BY_NAME, FINAL, METRICS
from gym_extensions.scoring.published import COLUMNS
from gym_extensions.scoring.scorecard import GroupScore, Scorecard, ScorecardDocument, SuiteScore
from gym_extensions.scoring.screen import count, number, table_rows

METRIC_DTYPES = {
    "name": "str",
    "level": "str",
    "group": "str",
    "protocol": "str",
    "budget": "str",
    "runs": "Int64",
    "metric": "str",
    "mean": "float64",
    "low": "float64",
    "high": "float64",
    "why": "str",
}
"""The columns of :func:`metrics_frame`; ``Int64`` may be missing."""

ENTRY_DTYPES = {
    "rank_first": "Int64",
    "rank_last": "Int64",
    "name": "str",
    "title": "str",
    "level": "str",
    "evaluation": "str",
    "runs": "int64",
    "ranked": "bool",
    "why": "str",
}
"""The columns of :func:`board_frame` before those of the metrics."""

CORE_DTYPES = {
    "rank_first": "Int64",
    "rank_last": "Int64",
    "name": "str",
    "title": "str",
    "level": "str",
    "observes_task": "bool",
    "look": "int64",
    "next_look": "Int64",
    "ranked": "bool",
    "why": "str",
    "vs_first": "str",
    "vs_reference": "str",
    **dict.fromkeys(
        (
            *(f"{metric}{end}" for metric in SHOWN for end in ("", "_low", "_high")),
            *CORES[CORE],
            *("steps", "cpu_seconds", "peak_memory_mb"),
        ),
        "float64",
    ),
    "stored_steps": "Int64",
    "parameters": "Int64",
    "notes": "str",
}
"""The columns of :func:`core_frame`."""

PAIR_DTYPES = {
    "metric": "str",
    "first": "str",
    "second": "str",
    "look": "int64",
    "paired": "bool",
    "mean": "float64",
    "low": "float64",
    "high": "float64",
    "p_value": "float64",
    "verdict": "str",
    "exploratory": "bool",
    "next_look": "Int64",
}
"""The columns of :func:`core_pairs_frame`."""
PAIR_COLUMNS = tuple(PAIR_DTYPES)[1:]

COMPUTED = "Computed from the references: no submission."

Row = tuple[object, ...]


def scores(card: Scorecard) -> Iterator[tuple[str, str, GroupScore | SuiteScore]]:
    """The scores of a scorecard with the group id or suite, and the protocol: groups before suites."""
    for groups in (card.groups, card.suites):
        for name, protocols in groups.items():
            for protocol, score in protocols.items():
                yield name, protocol, score


def _metric_rows(card: Scorecard) -> Iterator[Row]:
    for problem in card.problems:
        why = f"{problem.rule}: {problem.where}: {problem.message}"
        yield card.name, *[None] * (len(METRIC_DTYPES) - 2), why
    for name, protocol, score in scores(card):
        runs = len(score.runs) if isinstance(score, GroupScore) else None
        for metric in METRICS[protocol]:
            value = score.metrics[metric.name]
            group = (name, protocol, score.budget, runs)
            yield card.name, card.level, *group, metric.name, value.mean, value.low, value.high, value.why


TEXT: Any = "str" if int(pd.__version__.partition(".")[0]) >= 3 else "object"
"""The dtype of columns of texts; pandas 2 has none of its own for them."""


def typed(frame: pd.DataFrame, dtypes: Mapping[str, str]) -> pd.DataFrame:
    """The frame with these dtypes. With pandas 2, columns of texts have the dtype ``object``."""
    return frame.astype({name: TEXT if dtype == "str" else dtype for name, dtype in dtypes.items()})


def metrics_frame(document: ScorecardDocument) -> pd.DataFrame:
    """One row per submission, group or suite, protocol and metric, with the columns of ``METRIC_DTYPES``.

    A submission with problems has one row per problem, with its name and ``why`` alone.
    """
    rows = [row for card in document.submissions for row in _metric_rows(card)]
    return typed(pd.DataFrame(rows, columns=list(METRIC_DTYPES)), METRIC_DTYPES)


def board_dtypes(protocol: str) -> dict[str, str]:
    """The columns of a board of that protocol: the entry's, and three per metric."""
    ends = [f"{metric.name}{end}" for metric in BOARD_METRICS[protocol] for end in ("", "_low", "_high")]
    return ENTRY_DTYPES | dict.fromkeys(ends, "float64")


def _board_row(entry: BoardEntry, protocol: str) -> Row:
    values = [entry.metrics[metric.name] for metric in BOARD_METRICS[protocol]]
    ends = [end for value in values for end in (value.mean, value.low, value.high)]
    ranks = values[0].rank or (None, None)
    names = (entry.name, entry.title, entry.level, entry.evaluation)
    return *ranks, *names, entry.runs, entry.ranked, entry.why, *ends


def _core_row(board: CoreBoard, entry: CoreEntry) -> Row:
    first = board.rows[0].name

    def verdict(other: str) -> str | None:
        pair = board.pair(FINAL.name, entry.name, other)
        return pair.verdict if pair else None

    ends = [end for value in entry.metrics.values() for end in (value.mean, value.low, value.high)]
    groups = [value.mean if (value := entry.groups.get(name)) else None for name in CORES[CORE]]
    cost = entry.cost
    return (
        *(entry.metrics[FINAL.name].rank or (None, None)),
        *(entry.name, entry.title, entry.level),
        bool(entry.observes and entry.observes.task_in_evaluation),
        *(entry.look, entry.next_look, entry.ranked, entry.why, verdict(first), verdict(REFERENCE)),
        *(*ends, *groups),
        *(cost.steps, cost.cpu_seconds, cost.peak_memory_mb, cost.stored_steps, cost.parameters),
        " ".join(entry.notes),
    )


def core_frame(board: CoreBoard | None) -> pd.DataFrame:
    """One row per method in the order of the core board, with the columns of ``CORE_DTYPES``."""
    rows = [_core_row(board, entry) for entry in board.rows] if board else []
    return typed(pd.DataFrame(rows, columns=list(CORE_DTYPES)), CORE_DTYPES)


def core_pairs_frame(board: CoreBoard | None) -> pd.DataFrame:
    """One row per metric and pair of ranked methods, with the columns of ``PAIR_DTYPES``."""
    families = board.pairs.items() if board else ()
    rows = [
        (metric, *(getattr(pair, name) for name in PAIR_COLUMNS))
        for metric, pairs in families
        for pair in pairs
    ]
    return typed(pd.DataFrame(rows, columns=list(PAIR_DTYPES)), PAIR_DTYPES)


def board_frame(board: Board) -> pd.DataFrame:
    """One row per entry in the order of the board, then computed ones; columns: :func:`board_dtypes`.

    The computed rows (``alone``, ``random``, ``zero``) have no level, no rank and no runs.
    """
    dtypes = board_dtypes(board.protocol)
    rows = [_board_row(entry, board.protocol) for entry in board.rows]
    for entry in board.computed:
        values = [entry.metrics[metric.name] for metric in BOARD_METRICS[board.protocol]]
        ends = [end for value in values for end in (value.mean, value.low, value.high)]
        rows.append((None, None, entry.name, entry.title, None, None, 0, False, COMPUTED, *ends))
    return typed(pd.DataFrame(rows, columns=list(dtypes)), dtypes)


KEY = ["name", "group", "protocol"]


def csv_text(document: ScorecardDocument) -> str:
    """The frame of all metrics as CSV."""
    return to_csv(metrics_frame(document))


def to_csv(frame: pd.DataFrame) -> str:
    """A frame as CSV: floats by ``repr``, missing values empty.

    Texts that a spreadsheet would take for a formula begin with an apostrophe.
    """
    texts = frame.columns[frame.dtypes == TEXT]
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
        frame[end].map(number, na_action="ignore").astype(TEXT) for end in ("mean", "low", "high")
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
    for card in document.submissions:
        lines += [f"## {_cell(card.name)}: {_cell(card.title)}", ""]
        lines += ["Problems:" if card.problems else f"Level: {card.level}.", ""]
        for problem in card.problems:
            message = f"{_cell(problem.where)}: {_cell(problem.message)} {_cell(problem.hint)}"
            lines.append(f"* `{problem.rule}` {message}")
        lines += [f"* {_cell(note)}" for note in card.notes]
        for name, protocol, score in scores(card):
            lines += _group(name, protocol, score, metrics[card.name, name, protocol])
        lines.append("")
    return "\n".join(lines).rstrip("\n") + "\n"
