"""Cells of the tables of metrics and returns.

They are written here, because a large site has a hundred thousand of them and a template needs several times
as long for each.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from markupsafe import Markup, escape

from gym_extensions.scoring.metrics.definitions import BY_NAME
from gym_extensions.scoring.metrics.paper_table import PaperCell
from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.site.text import labels
from gym_extensions.site.text.numbers import fixed
from gym_extensions.site.text.values import half_width, tied
from gym_extensions.site.views.board_row import Row
from gym_extensions.site.views.trial import Trial, nothing_to_forget


def spreads(cells: Iterable[PaperCell | None], digits: int) -> Markup:
    """Mean ± standard deviation of each cell, or a dash."""
    return Markup("".join(_spread(cell, digits) for cell in cells))


def _spread(cell: PaperCell | None, digits: int) -> str:
    if cell is None:
        return '<td class="num"><span class="none">–</span></td>'
    mean, deviation = fixed(cell.mean, digits), fixed(cell.std, digits)
    return f'<td class="num">{mean} <span class="ends">± {deviation}</span></td>'


def nothing(trial: Trial) -> Markup:
    """The note beside the forgetting of an agent that learned nothing; else empty."""
    if not trial.learned_nothing:
        return Markup("")
    return Markup('<span class="nothing">{}</span>').format(nothing_to_forget(trial))


def figures(
    trial: Trial, columns: Sequence[str], reasons: Sequence[str], notes: str, row: Row | None = None
) -> Markup:
    """A cell per metric: mean, interval, and on a board the rank.

    Args:
        trial: the scores.
        columns: the names of the metrics.
        reasons: why values are missing, as the notes below the table list them.
        notes: the beginning of the anchor of these notes.
        row: the row of the board; without it, there are no ranks and no values for sorting.
    """
    estimates = (_estimate(trial.metric(name), reasons, notes) for name in columns)
    return Markup(
        "".join(
            _figure(trial, name, estimate, row, is_first=name == columns[0])
            for name, estimate in zip(columns, estimates, strict=True)
        )
    )


def _figure(trial: Trial, name: str, estimate: str, row: Row | None, *, is_first: bool) -> str:
    is_forgetting = name == "forgetting"
    kind = f"num{' first' if is_first else ''}{' muted' if is_forgetting and trial.learned_nothing else ''}"
    return (
        f'<td class="{kind}" data-label="{escape(BY_NAME[name].title)}"'
        f"{_sorted_by(trial.metric(name)) if row else ''}>"
        f"{estimate}{f' {nothing(trial)}' if is_forgetting else ''}"
        f"{_rank(row, name, with_ties=is_first) if row else ''}</td>\n"
    )


def _sorted_by(value: MetricValue) -> str:
    """The attributes that the script of the table reads."""
    half = half_width(value)
    mean = "" if value.mean is None else f' data-v="{value.mean:.4f}"'
    return mean if half is None or not mean else f'{mean} data-h="{half:.4f}"'


def _estimate(value: MetricValue, reasons: Sequence[str], notes: str) -> str:
    if value.mean is None:
        number, why = reasons.index(value.why) + 1, escape(value.why)
        see = f'<a class="see" href="#{notes}-{number}" title="{why}">note {number}</a>'
        return f'<span class="none">– {see}</span>'
    return f'<span class="value">{fixed(value.mean)}</span> <span class="ends">{labels.ends(value)}</span>'


def _rank(row: Row, name: str, *, with_ties: bool) -> str:
    rank = row.shown_rank(name)
    if rank is None:
        return ""
    others = row.tied(name) if with_ties else 0
    versus = row.entry.vs_leader
    level = "; level with the first" if versus and not versus.separated else ""
    ties = f' <span class="tied">{tied(others)}{level}</span>' if others else ""
    return f' <span class="rank">{labels.rank(rank)}</span>{ties}'
