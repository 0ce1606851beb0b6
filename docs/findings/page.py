"""The text of docs/findings.md, from ``page.md.jinja``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from comparison import Row, Verdict, count, separated_from_zero
from costs import hours
from groups import FINE_TUNING, Group
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from numbers_as_text import mean
from suites import Suite
from transfer import TITLES, Transfer, shown

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.scoring.statistics import Interval

TEMPLATES = Path(__file__).parent


def excludes_zero(each: Interval) -> str:
    """``yes`` if the interval excludes 0, else ``no``."""
    return "no" if (each.low or 0.0) <= 0 <= (each.high or 0.0) else "yes"


def verdict(each: Verdict | None) -> str:
    """A difference with its interval and verdict; empty for fine-tuning itself."""
    return "" if each is None else f"{mean(each.gap)}, {'**separated**' if each.is_separated else 'tie'}"


def render(
    groups: Sequence[Group],
    without_score: Sequence[str] = (),
    transfers: Sequence[Transfer] = (),
    open_tasks: Mapping[str, Sequence[str]] = MappingProxyType({}),
    suites: Sequence[Suite] = (),
    *,
    by_alone: Mapping[str, Row] = MappingProxyType({}),
) -> str:
    """The text of the page.

    Args:
        groups: the groups on which fine-tuning has a score.
        without_score: names of the groups on which it was trained without a score: every task is open.
        transfers: the transfers of fine-tuning on each group.
        open_tasks: the open tasks of groups that have any.
        suites: the suites on which fine-tuning has a score.
        by_alone: fine-tuning on each group, where 1 is the same agent on each task alone.
    """
    templates = Environment(
        loader=FileSystemLoader(TEMPLATES), undefined=StrictUndefined, trim_blocks=True, autoescape=False
    )
    templates.filters.update(mean=mean, excludes_zero=excludes_zero, verdict=verdict, hours=hours)
    rows = [row for group in groups for row in group.rows]
    learned = [group for group in groups if group.is_learned]
    trained = {group.name for group in groups} | set(without_score)
    return (
        templates.get_template("page.md.jinja").render(
            budget=STANDARD_BUDGET,
            fine_tuning=FINE_TUNING,
            groups=groups,
            with_learners=[group for group in groups if group.learners],
            without_score=without_score,
            suites=suites,
            open_tasks={group.name: open_tasks[group.name] for group in groups if group.name in open_tasks},
            by_alone=by_alone,
            transfer_titles=TITLES,
            transfers=shown(transfers),
            without_fine_tuning=[group.name for group in GROUPS.values() if group.name not in trained],
            by_forgetting=sorted(learned, key=lambda group: -group.rows[0].forgetting.mean),
            forgotten=separated_from_zero({group.name: group.rows[0].values[2] for group in learned}),
            counts=[
                count("final performance", [row.final_verdict for row in rows]),
                count("forgetting", [row.forgetting_verdict for row in rows]),
            ],
        )
        + "\n"
    )
