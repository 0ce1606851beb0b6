"""Writes docs/reproduction.md: the paper's tables beside the submissions that repeat its training.

``make findings`` runs it. Every number and verdict is computed; the text is in ``reproduction.md.jinja``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from gym_extensions import results
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.errors import BenchError
from gym_extensions.files import write_text
from gym_extensions.metrics.statistics import (
    Interval,
    Summary,
    holm,
    mean_of_groups,
    subtract,
    to_interval,
    zero_mean_p,
)
from gym_extensions.scoring.group_score import PaperCell, PaperRow
from gym_extensions.scoring.pipeline import make_scorer
from gym_extensions.scoring.submission.stages import task_name
from gym_extensions.site.text import fixed, interval
from tools import ROOT
from tools.findings.figures import draw_reproduction
from tools.findings.findings import FOLDER, jinja
from tools.findings.paper_statements import PaperStatement, statements
from tools.findings.tables import FINE_TUNING

PAGE = ROOT / "docs" / "reproduction.md"
PRINTED = "henderson2017-trpo"
BATCH_EPISODES = 50
"""The least number of episodes in the paper's batch of 50,000 steps: an episode has at most 1,000."""
CLAIMS = (
    ("hopper-gravity", True, "trpo-2017-paper-hopper"),
    ("halfcheetah-gravity", False, "trpo-2017-paper"),
)
"""A group, whether the paper says that its earlier tasks are forgotten, and its repetition."""


@dataclass(frozen=True)
class Change:
    """Fully Trained minus After Env on an earlier task, and whether the corrected test separates the two."""

    task: str
    gap: Interval
    is_significant: bool

    @property
    def is_lower(self) -> bool:
        """Whether the task was forgotten in part."""
        return self.is_significant and self.gap.mean < 0


@dataclass(frozen=True)
class Table:
    """The paper's columns on one group from one source, and the changes on the tasks before the last one."""

    rows: tuple[PaperRow, ...]
    changes: tuple[Change, ...]
    mean_change: Interval

    @property
    def forgotten(self) -> int:
        """Number of earlier tasks that end significantly lower."""
        return sum(change.is_lower for change in self.changes)

    @property
    def kept(self) -> float:
        """Fully Trained in percent of After Env, both summed over the earlier tasks."""
        final, after = (
            sum(cell(row, column).mean for row in self.rows[:-1])
            for column in ("fully_trained", "after_env_training")
        )
        return 100 * final / after


@dataclass(frozen=True)
class Group:
    """A group with what the paper claims, what it prints, and what the submission shows."""

    name: str
    is_forgotten: bool
    submission: str
    printed: Table
    of_batches: Table  # as printed, with the episodes of a training batch in After Env
    reproduced: Table


def cell(row: PaperRow, column: str) -> PaperCell:
    """A cell that must be there."""
    found = row.cell(column)
    assert found is not None, (row.task, column)
    return found


def cell_summary(each: PaperCell, count: int) -> Summary:
    """The mean of ``count`` episodes with its sampling error; the cell's ``std`` divides by their number."""
    variance = each.std**2 * count / (count - 1)
    return Summary(each.mean, variance / count, count - 1.0, count)


def table(rows: Sequence[PaperRow], after: int = EVALUATION_EPISODES) -> Table:
    """The changes of the earlier tasks: Welch's test over episodes, with Holm's correction over the tasks.

    Args:
        rows: the tasks in training order.
        after: the number of episodes of After Env.
    """
    episodes = {"fully_trained": EVALUATION_EPISODES, "after_env_training": after}
    pairs = [[cell_summary(cell(row, name), count) for name, count in episodes.items()] for row in rows[:-1]]
    gaps = [subtract(*pair) for pair in pairs]
    separated = holm(np.array(list(map(zero_mean_p, gaps)), dtype=np.float64))
    changes = [
        Change(task_name(row.task), to_interval(gap), bool(apart))
        for row, gap, apart in zip(rows, gaps, separated, strict=False)
    ]
    return Table(tuple(rows), tuple(changes), to_interval(mean_of_groups(gaps)))


def deviation(each: PaperCell) -> str:
    """A mean and a standard deviation over episodes."""
    return f"{fixed(each.mean, 0)} ± {fixed(each.std, 0)}"


def gap(each: Interval) -> str:
    """A difference of returns with its interval."""
    assert each.low is not None and each.high is not None
    return f"{fixed(each.mean, 0)} ({interval(each.low, each.high, 0)})"


def gap_in_words(each: Change) -> str:
    """A change with its interval and verdict."""
    return f"{gap(each.gap)}, {'significant' if each.is_significant else 'not significant'}"


def verdict(group: Group, shown: Table) -> str:
    """What a table says about the paper's claim on its group."""
    agrees = "yes" if group.is_forgotten else "not contradicted"
    is_refuted = (shown.forgotten > 0) != group.is_forgotten
    count = (
        f"{shown.forgotten} of {len(shown.changes)} earlier tasks end lower, {fixed(shown.kept, 0)} % kept"
    )
    return f"{'no' if is_refuted else agrees}: {count}"


def page(groups: Sequence[Group], further: Sequence[PaperStatement]) -> str:
    """The text of the page."""
    templates = jinja()
    templates.filters.update(
        deviation=deviation, change=gap_in_words, gap=gap, whole=partial(fixed, digits=0), task_name=task_name
    )
    text = templates.get_template("reproduction.md.jinja").render(
        groups=groups,
        further=further,
        verdict=verdict,
        episodes=EVALUATION_EPISODES,
        batch_episodes=BATCH_EPISODES,
    )
    return text + "\n"


def main() -> None:
    """Writes the page and its figure."""
    submissions = ROOT / "submissions"
    scorer = make_scorer()
    cards = {name: scorer(submissions / name) for name in (PRINTED, FINE_TUNING, *(row[2] for row in CLAIMS))}
    printed = cards[PRINTED].groups
    groups = []
    for name, is_forgotten, submission in CLAIMS:
        group_id = GROUPS[name].id
        ours = cards[submission].groups[group_id]["sequential"]
        if len(ours.return_matrix) > 1:
            # Its episodes would count as independent, although the run is the statistical unit.
            raise BenchError("several-runs", "The page compares one run per group.", submission)
        rows = printed[group_id]["sequential"].paper_table
        tables = table(rows), table(rows, BATCH_EPISODES), table(ours.paper_table)
        groups.append(Group(name, is_forgotten, submission, *tables))
    shown = [(group.name, group.printed.rows, group.reproduced.rows) for group in groups]
    draw_reproduction(shown, FOLDER / "reproduction.svg")
    episodes = results.episodes(submissions / FINE_TUNING)
    sequential = episodes[episodes["protocol"] == "sequential"]
    further = statements(cards[PRINTED], cards[CLAIMS[0][2]], cards[FINE_TUNING], sequential)
    write_text(PAGE, page(groups, further))
