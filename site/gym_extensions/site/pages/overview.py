"""The first page: one task that is forgotten, one sentence with its limits, one table, and what is open."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from markupsafe import Markup

from gym_extensions.baselines import algorithms
from gym_extensions.metrics.formulas import CORE_METRICS
from gym_extensions.scoring.ranking.boards import Board, BoardRow, CoreBoard, CorePair, CoreRow
from gym_extensions.scoring.ranking.core_board import REFERENCE
from gym_extensions.scoring.ranking.wanted import Wanted, wanted
from gym_extensions.scoring.scorecard import CoreGroup, Scorecard
from gym_extensions.scoring.submission.core_score import core_logs
from gym_extensions.site import paths, text
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.charts.strips import MARGIN, WIDTH
from gym_extensions.site.charts.svg import Scale, scale_around
from gym_extensions.site.pages import core, groups
from gym_extensions.site.pages.page import File, Render
from gym_extensions.site.play.forgetting import forgetting
from gym_extensions.site.submission_results import SEQUENTIAL
from gym_extensions.site.text import count, ends, mean, short, split_version

OF_LIST = 9
"""Rows of each list on the page; a script loads the others."""
MOST_NAMED = 3
"""Up to this many methods are named in a sentence; more are counted."""
MOST_IN_TRIANGLE = 12
"""Methods whose pairs are shown."""
LISTS = (
    ("Without task label", "one policy for all tasks"),
    ("With the task label at test time", "a method may keep a network for each task"),
)
"""Title of a list, and what its agents are, by whether they observe the task in evaluation."""


@dataclass(frozen=True)
class Cell:
    """A method on a group: how its score compares with the highest of its list, and how it is coloured."""

    value: CoreGroup | None
    kind: str  # "best", "tied" (not significantly different from it), "lower", or "untested"

    @property
    def tint(self) -> str:
        """The class of its colour: a step per tenth of the score."""
        score = self.value.mean if self.value and self.value.mean is not None else 0.0
        return "below" if score < 0 else f"h{min(10, round(10 * score))}"


@dataclass(frozen=True)
class Overview:
    """What the page says of a core board."""

    board: CoreBoard
    cards: Mapping[str, Scorecard]
    boards: Sequence[Board]

    @cached_property
    def ranked(self) -> list[CoreRow]:
        """The ranked methods of the first list that has one, best first."""
        found = [[row for row in each.rows if row.ranked] for each in self.board.lists]
        return next(filter(None, found), [])

    @cached_property
    def scale(self) -> Scale:
        """The scale of the strips, the same in both lists, with every interval and 0."""
        levels = [each.value.mean or 0.0 for each in self.board.references]
        return scale_around([*core.ends_of(self.board.rows), *levels], MARGIN, WIDTH - MARGIN, always=(0.0, 0.5))

    @cached_property
    def _on_groups(self) -> dict[tuple[str, str], tuple[BoardRow, bool]]:
        """By group and name, the row on the board of the group, and whether it is first of those ranked."""
        return {
            (each.group, row.name): (row, at == 0 and row.ranked)
            for each in self.boards
            if each.protocol == SEQUENTIAL and each.budget == self.board.budget
            for at, row in enumerate(each.rows)
        }

    def cells(self, row: CoreRow) -> list[Cell]:
        """The method on every group of the core."""
        found = []
        for group in self.board.groups:
            value = row.groups.get(group)
            on_group, is_first = self._on_groups.get((group, row.name), (None, False))
            kind = "best" if is_first else "untested"
            if on_group and on_group.vs_leader:
                kind = "lower" if on_group.vs_leader.separated else "tied"
            found.append(Cell(value if value and value.mean is not None else None, kind))
        return found

    def numbers(self, row: CoreRow) -> str:
        """The values of the cells in thousandths: of each metric that they may show, group by group."""
        found = []
        for name in CORE_METRICS:
            values = [row.groups.get(group, CoreGroup()) for group in self.board.groups]
            means = [each.mean if name == core.FINAL else each.others.get(name) for each in values]
            found.append(" ".join("-" if each is None else str(round(1000 * each)) for each in means))
        return ";".join(found)

    def statement(self) -> Markup:
        """What the reference agent loses, what the best method keeps, of how many, and how certain that is."""
        if not self.ranked:
            return Markup("No method has all runs of the core suite yet. Each row says what is missing.")
        first, *others = self.ranked
        name, score = NAME.format(short(first.title, 40)), f"{mean(first.metrics[core.FINAL])} ({ends(first.metrics[core.FINAL])})"
        if not others:
            only = "{} is the only method with all runs of the core suite so far; it keeps {}."
            return Markup(only).format(name, score)
        parts = []
        for row in others:
            if row.name == REFERENCE:
                learned, kept = (mean(row.metrics[metric]) for metric in (core.LEARNED, core.FINAL))
                lost = "Trained on one task after another, {} falls from {} to {} (expert: 1)."
                parts.append(Markup(lost).format(NAME.format(short(row.title, 40)), learned, kept))
        pairs = [pair for row in others if (pair := self.board.pair(core.FINAL, first.name, row.name))]
        # On fewer runs, the one with the lower mean can be significantly better.
        won = [pair for pair in pairs if pair.verdict == "separated" and (pair.mean > 0) == (pair.first == first.name)]
        label = "" if first.task_conditioned else " without task label"
        verb = "keeps most" if len(won) == len(others) else "has the highest mean"
        parts.append(Markup("Of {} methods{} that ran all {} groups, {} {}, {}").format(
            len(self.ranked), label, len(self.board.groups), name, verb, score))
        if not won:
            parts[-1] += Markup("; no difference is significant.")
            return Markup(" ").join(parts)
        better = "every other" if len(won) == len(others) else f"{len(won)} of the others"
        found = [self._on_groups[group, first.name][0] for group in self.board.groups]
        alone = sum(row.metrics[core.FINAL].rank == (1, 1) for row in found)
        parts[-1] += Markup(": significantly more than {}, alone first in {} of {}.").format(better, alone, count(len(self.board.groups), "group"))
        looks = sorted({pair.look for pair in won})
        parts.append(Markup("{} runs{}").format(" to ".join(map(str, dict.fromkeys((looks[0], looks[-1])))), PRELIMINARY if any(pair.exploratory for pair in won) else "."))
        return Markup(" ").join(parts)

    def limits(self) -> list[Markup]:
        """What the statement does not show, at most six sentences with a link each."""
        rows, found = [row for row in self.board.rows if row.ranked], []
        known = [(row, manifest) for row in rows if (manifest := self.cards[row.name].manifest)]
        if not known:
            return []
        parent, alike = Counter(row.parent for row in rows).most_common(1)[0]
        line = 'One base learner: {} of {} ranked methods learn as <a href="{}">{}</a> does.'
        if alike > 1:
            found.append(Markup(line).format(alike, len(rows), paths.submission_path(parent), parent))
        spent = [(manifest.tuning.steps if manifest.tuning else 0, row.name) for row, manifest in known]
        (most, name), none = max(spent), sum(not steps for steps, _ in spent)
        line = 'Settings were tuned unequally: not at all for {} of them, with {} steps for <a href="{}">{}</a>.'
        found.append(Markup(line).format(none, core.short_count(most), paths.submission_path(name), name))
        if lacking := [row.name for row in self.board.rows if row.missing]:
            line = 'Not compared, because <a href="#open">groups are missing</a>: {}.'
            found.append(Markup(line).format(text_list(lacking)))
        if provisional := sorted(self.provisional):
            line = 'The expert of {} is <a href="references.html">provisional</a>: scores there may be far above 1.'
            found.append(Markup(line).format(text_list([split_version(task)[0] for task in provisional])))
        (author, made), = Counter(manifest.authors[0] for _, manifest in known if manifest.authors).most_common(1) or [("", 0)]
        if made:
            line = '{} of {} ranked <a href="submissions.html">submissions</a> are by {}.'
            found.append(Markup(line).format(made, len(rows), author))
        if self.board.edition == 1:
            line = 'Runs had been seen <a href="metrics.html#core">when the test was chosen</a>: results of up to 20 runs are preliminary.'
            found.append(Markup(line))
        return found

    @cached_property
    def provisional(self) -> dict[str, str]:
        """The tasks of the core with a provisional expert, and why it is."""
        logs = [log for row in self.board.rows for log in core_logs(self.cards[row.name]).values()]
        return {task: each.provisional for log in logs for task, each in log.reference.items() if each.provisional}

    def pairs(self, metric: str) -> list[tuple[CoreRow, list[CorePair | None]]]:
        """The triangle: each ranked method but the first with its pairs with those above it."""
        rows = [row for row in self.board.rows if row.ranked][:MOST_IN_TRIANGLE]
        return [
            (row, [self.board.pair(metric, other.name, row.name) for other in rows[:at]])
            for at, row in enumerate(rows)
        ]

    @cached_property
    def wanted(self) -> list[Wanted]:
        """The runs that would decide most."""
        return wanted(list(self.cards.values()), self.board, algorithms.names())

    @property
    def wanted_names(self) -> set[str]:
        """The submissions whose missing runs anybody can train."""
        return {each.name for each in self.wanted}

    def minutes(self, row: CoreRow) -> str:
        """The processor time of a run of the core in minutes; a dash where a group does not state it."""
        return "–" if row.cost.cpu_seconds is None else text.fixed(row.cost.cpu_seconds / 60, 0)

    def tuning(self, row: CoreRow) -> int | None:
        """The steps spent on choosing the settings."""
        manifest = self.cards[row.name].manifest
        return manifest.tuning.steps if manifest and manifest.tuning else None


NAME = Markup("<strong><bdi>{}</bdi></strong>")
PRELIMINARY = Markup('; <a href="metrics.html#core">preliminary</a>.')


def text_list(names: Sequence[str]) -> str:
    """Names with commas; of many, the first."""
    return ", ".join(names[:MOST_NAMED]) + (f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else "")


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """The first page, the rows that do not fit on it, the page of the core, and the list of groups."""
    cards = {card.name: card for card in site.submissions}
    board = site.scored.core
    view = Overview(board, cards, site.scored.boards) if board else None
    best = view.ranked[0].name if view and view.ranked else ""
    on_board = {each.group: each.id for each in reversed(site.boards) if render.landscapes.rows(each)}
    values = {
        "view": view,
        "board": board,
        "core": core,
        "shown": forgetting(site.submissions, render.folders, best),
        "of_list": OF_LIST,
        "lists": LISTS,
        "simulator": render.simulator,
        "groups": groups.groups(site),
        "landscapes": on_board,
    }
    yield "index.html", render("index.html", "index.html", **values)
    yield "groups.html", render("groups.html", "groups.html", **values)
    yield "core.html", render("core.html", "core.html", **values)
