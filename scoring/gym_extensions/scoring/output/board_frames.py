"""Scorecards and boards as pandas data frames, and from them as CSV. Loads pandas."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import pandas as pd

from gym_extensions.catalog.groups import CORE, CORES
from gym_extensions.metrics.formulas import BOARD_METRICS, CORE_METRICS, FINAL, FORGETTING, METRICS
from gym_extensions.metrics.values import Estimate
from gym_extensions.scoring.group_score import GroupScore
from gym_extensions.scoring.ranking import boards, core_board
from gym_extensions.scoring.scorecard import Scorecard

ENDS = ("", "_low", "_high")
METRIC_DTYPES = dict.fromkeys(("name", "level", "group", "protocol", "budget"), "str")
METRIC_DTYPES |= {"runs": "Int64", "metric": "str", "mean": "float64", "low": "float64", "high": "float64"}
METRIC_DTYPES |= {"why": "str"}
"""The columns of :func:`metrics_frame`; ``Int64`` may be missing."""

NAMED_DTYPES = {"rank_first": "Int64", "rank_last": "Int64", "name": "str", "title": "str", "level": "str"}
SUBMISSION_DTYPES = NAMED_DTYPES | {"evaluation": "str", "runs": "int64", "ranked": "bool", "why": "str"}
"""The columns of :func:`board_frame` before those of the metrics."""

CORE_DTYPES = NAMED_DTYPES | {"observes_task": "bool", "look": "int64", "next_look": "Int64"}
CORE_DTYPES |= {"ranked": "bool", "why": "str", "vs_first": "str", "vs_reference": "str"}
CORE_DTYPES |= dict.fromkeys([f"{metric}{end}" for metric in CORE_METRICS for end in ENDS], "float64")
CORE_DTYPES |= dict.fromkeys([f"retention{end}" for end in ENDS], "float64") | {"forgetting_note": "str"}
CORE_DTYPES |= dict.fromkeys((*CORES[CORE], "steps", "cpu_seconds", "peak_memory_mb"), "float64")
CORE_DTYPES |= {"stored_steps": "Int64", "parameters": "Int64", "notes": "str"}
"""The columns of :func:`core_frame`."""

PAIR_DTYPES = {"metric": "str", "first": "str", "second": "str", "look": "int64", "paired": "bool"}
PAIR_DTYPES |= dict.fromkeys(("mean", "low", "high", "p_value"), "float64")
PAIR_DTYPES |= {"verdict": "str", "exploratory": "bool", "next_look": "Int64"}
"""The columns of :func:`core_pairs_frame`."""

VARIANT_DTYPES = {"variant": "str", "title": "str", "name": "str", "observes_task": "bool", "place": "int64"}
VARIANT_DTYPES |= {"rank_first": "Int64", "rank_last": "Int64"}
VARIANT_DTYPES |= dict.fromkeys(("mean", "low", "high"), "float64")
"""The columns of :func:`core_variants_frame`."""

FORMULA = r"^([=+\-@\t\r])"
"""The beginning of a text that a spreadsheet would take for a formula."""
Row = tuple[object, ...]
TEXT: Any = "str" if int(pd.__version__.partition(".")[0]) >= 3 else "object"
"""The dtype of columns of texts; pandas 2 has none of its own for them."""


def typed(data: pd.DataFrame | Iterable[Row], dtypes: Mapping[str, str]) -> pd.DataFrame:
    """The frame, or the rows as a frame, with these columns and dtypes. With pandas 2, texts are objects."""
    frame = data if isinstance(data, pd.DataFrame) else pd.DataFrame(list(data), columns=list(dtypes))
    return frame.astype({name: TEXT if dtype == "str" else dtype for name, dtype in dtypes.items()})


def _metric_rows(card: Scorecard) -> Iterator[Row]:
    for problem in card.problems:
        why = f"{problem.rule}: {problem.where}: {problem.message}"
        yield card.name, *[None] * (len(METRIC_DTYPES) - 2), why
    for name, protocol, score in card.scores():
        runs = len(score.runs) if isinstance(score, GroupScore) else None
        for metric in METRICS[protocol]:
            value = score.metrics[metric.name]
            group = (name, protocol, score.budget, runs)
            yield card.name, card.level, *group, metric.name, value.mean, value.low, value.high, value.why


def metrics_frame(cards: Iterable[Scorecard]) -> pd.DataFrame:
    """One row per submission, group or suite, protocol and metric, with the columns of ``METRIC_DTYPES``.

    A submission with problems has one row per problem, with its name and ``why`` alone.
    """
    return typed((row for card in cards for row in _metric_rows(card)), METRIC_DTYPES)


def _ends(metrics: Iterable[Estimate]) -> list[float | None]:
    return [end for value in metrics for end in (value.mean, value.low, value.high)]


def board_frame(board: boards.Board) -> pd.DataFrame:
    """One row per submission in the order of the board, then computed ones.

    The columns are those of ``SUBMISSION_DTYPES``, and three per metric. The computed rows (``alone``,
    ``random``, ``zero``) have no level, no rank and no runs.
    """
    names = [metric.name for metric in BOARD_METRICS[board.protocol]]
    _, _, *facts_of = SUBMISSION_DTYPES
    rows: list[Row] = []
    for submission in board.rows:
        values = [submission.metrics[name] for name in names]
        facts = (getattr(submission, column) for column in facts_of)
        rows.append((*(values[0].rank or (None, None)), *facts, *_ends(values)))
    for each in board.computed:
        why = "Computed from the references: no submission."
        unranked = (None, None, each.name, each.title, None, None, 0, False, why)
        rows.append((*unranked, *_ends(each.metrics[name] for name in names)))
    return typed(rows, SUBMISSION_DTYPES | {f"{name}{end}": "float64" for name in names for end in ENDS})


def core_frame(board: boards.CoreBoard | None) -> pd.DataFrame:
    """One row per method in the order of the two lists, then the reference agent trained in other ways.

    The columns are those of ``CORE_DTYPES``.
    """
    if board is None:
        return typed((), CORE_DTYPES)
    rows: list[Row] = []
    for first, row in ((each.rows[0].name, row) for each in board.lists for row in each.rows):
        against = (board.pair(FINAL.name, row.name, other) for other in (first, core_board.REFERENCE))
        cost = row.cost
        rows.append(
            (
                *(row.metrics[FINAL.name].rank or (None, None)),
                *(row.name, row.title, row.level, row.task_conditioned),
                *(row.look, row.next_look, row.ranked, row.why),
                *(pair.verdict if pair else None for pair in against),
                *_ends([*(row.metrics[name] for name in CORE_METRICS), row.retention]),
                row.metrics[FORGETTING.name].rank_note,
                *(value.mean if (value := row.groups.get(name)) else None for name in CORES[CORE]),
                *(cost.steps, cost.cpu_seconds, cost.peak_memory_mb, cost.stored_steps, cost.parameters),
                " ".join(row.notes),
            )
        )
    for each in board.references:
        facts: dict[str, object] = {"name": each.name, "title": each.title, "level": "", "notes": ""}
        facts |= {"observes_task": False, "look": each.runs, "ranked": False}
        facts |= {"why": "Trained in another way: no sequence of tasks."}
        facts |= {name: group.mean for name, group in each.groups.items()}
        facts |= zip([f"{FINAL.name}{end}" for end in ENDS], _ends([each.value]), strict=True)
        rows.append(tuple(facts.get(column) for column in CORE_DTYPES))
    return typed(rows, CORE_DTYPES)


def core_pairs_frame(board: boards.CoreBoard | None) -> pd.DataFrame:
    """One row per metric and pair of ranked methods, with the columns of ``PAIR_DTYPES``."""
    _, *columns = PAIR_DTYPES
    families = board.pairs.items() if board else ()
    rows = (
        (metric, *(getattr(pair, name) for name in columns)) for metric, pairs in families for pair in pairs
    )
    return typed(rows, PAIR_DTYPES)


def core_variants_frame(board: boards.CoreBoard | None) -> pd.DataFrame:
    """One row per variant of the core and ranked method, with the columns of ``VARIANT_DTYPES``."""
    rows = (
        (
            *(variant.name, variant.title, row.name, row.task_conditioned, score.place),
            *(*(score.rank or (None, None)), *_ends([score])),
        )
        for variant in (board.variants if board else ())
        for row in (board.rows if board else ())
        if (score := variant.scores.get(row.name))
    )
    return typed(rows, VARIANT_DTYPES)


def to_csv(frame: pd.DataFrame) -> str:
    """A frame as CSV: floats by ``repr``, missing values empty.

    Texts that a spreadsheet would take for a formula begin with an apostrophe.
    """
    texts = frame.columns[frame.dtypes == TEXT]
    quoted = frame.assign(**frame[texts].replace(FORMULA, r"'\1", regex=True))
    return quoted.to_csv(index=False, lineterminator="\n")
