"""Boards and groups as pages show them: rows with the scores of their submissions, who is first."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from gym_extensions.catalog.groups import CORE, CORES, GROUPS, SUITES
from gym_extensions.catalog.protocol import BUDGETS, PROTOCOLS
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.metrics import formulas, values
from gym_extensions.references import References
from gym_extensions.scoring.group_score import GroupScore
from gym_extensions.scoring.ranking import boards as model, group_board
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site.submission_results import SEQUENTIAL, SubmissionResult, group_order
from gym_extensions.submissions.review import REPORTED


def shortened(card: Scorecard) -> Scorecard:
    """The part of a scorecard that pages of many submissions show, so that many fit in memory.

    It lacks success rates of runs, training curves, provenance and the README.
    """

    def part(scores: Mapping[str, GroupScore]) -> dict[str, GroupScore]:
        return {
            key: replace(score, success_rates=(), curves=(), provenance=()) for key, score in scores.items()
        }

    groups = {group: part(scores) for group, scores in card.groups.items()}
    return replace(card, readme="", groups=groups, own=part(card.own))


@dataclass(frozen=True)
class Row:
    """One submission on a board."""

    card: Scorecard  # shortened
    result: SubmissionResult  # its scores on this board
    submission: model.BoardRow  # what the scorer's board says of it
    ranked_on: Mapping[str, int]  # the number of ranked submissions per metric

    @property
    def score(self) -> values.MetricValue:
        """The metric that sorts the board."""
        return self.result.metric(formulas.COLUMNS[self.result.protocol][0])

    @property
    def little_learned(self) -> str:
        """Why little forgetting is no retention, where the submission learned less than each task alone."""
        lost = self.submission.metrics.get(formulas.FORGETTING.name)
        return lost.rank_note if lost is not None and lost.rank_note == values.LITTLE_LEARNED else ""

    def rank(self, metric: str) -> tuple[int, int] | None:
        """Best and worst possible rank on a metric; None if it has none, or if it alone is ranked."""
        return self.submission.metrics[metric].rank if self.ranked_on[metric] > 1 else None


@dataclass(frozen=True)
class BoardView:
    """The submissions of one group or suite, protocol and budget; task-conditioned ones are apart."""

    group: str
    protocol: str
    budget: str
    task_conditioned: bool
    suite: bool
    rows: tuple[Row, ...]
    scored: model.Board

    @property
    def id(self) -> str:
        """Its name, for example ``hopper-gravity-v0-sequential-100k``."""
        return self.scored.id

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of its metrics, the sorting one first."""
        return formulas.COLUMNS[self.protocol]

    @cached_property
    def results(self) -> tuple[SubmissionResult, ...]:
        """The results of its submissions, from top to bottom."""
        return tuple(row.result for row in self.rows)

    @cached_property
    def open_tasks(self) -> tuple[str, ...]:
        """Tasks without an expert; normalized means exclude them."""
        return next((result.open_tasks for result in self.results if result.open_tasks), ())

    @property
    def provisional_tasks(self) -> tuple[tuple[str, str], ...]:
        """Tasks whose expert is provisional, and why it is."""
        return next((result.provisional_tasks for result in self.results if result.provisional_tasks), ())

    def row(self, name: str | None) -> Row | None:
        """The row of a submission; None for None."""
        return next((row for row in self.rows if row.submission.name == name), None)

    @cached_property
    def leader(self) -> Row | None:
        """The first ranked submission, or if none is ranked the first with a score; None without a score."""
        return self.row(self.scored.lead.name) if self.scored.lead else None

    @cached_property
    def least_forgetting(self) -> Row | None:
        """The ranked submission that forgets least of those that learned something."""
        return self.row(self.scored.least_forgetting)


def board_views(scored: Sequence[model.Board], cards: Sequence[Scorecard]) -> tuple[BoardView, ...]:
    """The scorer's boards by protocol, budget (longest first), suites, groups; task-conditioned ones last.

    Boards that have only published tables without logs are omitted.
    """
    by_name, budgets, views = {card.name: card for card in cards}, list(BUDGETS), list[BoardView]()
    for board in scored:
        if all(row.level == REPORTED for row in board.rows):
            continue
        metrics = [(name, metric) for row in board.rows for name, metric in row.metrics.items()]
        ranked_on = Counter(name for name, metric in metrics if metric.rank is not None)
        suite = board.group in SUITES
        rows = []
        for row in board.rows:
            card = by_name[row.name]
            score = (card.suites if suite else card.groups)[board.group][board.protocol]
            rows.append(Row(card, SubmissionResult(board.group, board.protocol, score), row, ranked_on))
        key = (board.group, board.protocol, board.budget, board.task_conditioned)
        views.append(BoardView(*key, suite, tuple(rows), board))

    def order(view: BoardView) -> tuple[bool, int, int, bool, tuple[int, str]]:
        place = (PROTOCOLS.index(view.protocol), budgets.index(view.budget))
        return view.task_conditioned, *place, not view.suite, group_order(view.group)

    return tuple(sorted(views, key=order))


@dataclass(frozen=True)
class Group:
    """A group or suite."""

    id: str  # group id or suite name
    tasks: tuple[str, ...]  # task ids in training order; empty for a suite
    members: tuple[str, ...]  # the group ids of a suite; empty for a group
    boards: tuple[BoardView, ...]  # by protocol, most submissions first, task-conditioned ones last

    @property
    def summaries(self) -> tuple[str, ...]:
        """What its bodies are and do, one sentence per base body."""
        return tuple(dict.fromkeys(TASKS[task].body.prose.summary for task in self.tasks if task in TASKS))

    @property
    def submissions(self) -> int:
        """The number of different submissions on its boards."""
        return len({row.submission.name for board in self.boards for row in board.rows})

    @property
    def best(self) -> Row | None:
        """The first ranked submission of its first board of sequential training that has one."""
        leaders = (board.leader for board in self.boards if board.protocol == SEQUENTIAL)
        return next((row for row in leaders if row and row.submission.ranked), None)


@dataclass(frozen=True)
class Leaderboard:
    """All submissions and their boards."""

    references: References  # that normalize all scores
    submissions: tuple[Scorecard, ...]  # of every submission, shortened, sorted by name

    @cached_property
    def boards(self) -> tuple[BoardView, ...]:
        """Every board, in the order of the overview."""
        return board_views(self.scored.boards, self.submissions)

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        """The groups of the core, other published groups and those that have a board, then the suites."""
        by_group: dict[str, list[BoardView]] = {}
        for board in self.boards:
            by_group.setdefault(board.group, []).append(board)
        published = {group.id: group.task_ids for group in GROUPS.values()}
        ids = [name for name in dict.fromkeys((*CORES[CORE], *published, *by_group)) if name not in SUITES]
        found = []
        for name in (*ids, *SUITES):
            boards = by_group.get(name, [])
            tasks = published.get(name) or next((board.results[0].tasks for board in boards), ())
            boards.sort(key=lambda b: (PROTOCOLS.index(b.protocol), b.task_conditioned, -len(b.rows)))
            found.append(Group(name, tasks, SUITES.get(name, ()), tuple(boards)))
        return tuple(found)

    @cached_property
    def scored(self) -> model.BoardsDocument:
        """The scorer's boards of all submissions without problems."""
        cards = [card for card in self.submissions if not card.problems]
        return group_board.boards(cards, self.references)
