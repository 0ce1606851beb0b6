"""The first page: one task that is forgotten, one sentence with its limits, one table, and what is open."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from operator import sub
from pathlib import Path
from typing import Any

from markupsafe import Markup

from gym_extensions.baselines import algorithms
from gym_extensions.metrics.formulas import CORE_METRICS
from gym_extensions.scoring.ranking.boards import Board, BoardRow, CoreBoard, CorePair, CoreRow
from gym_extensions.scoring.ranking.core_board import REFERENCE
from gym_extensions.scoring.ranking.wanted import Wanted, wanted
from gym_extensions.scoring.scorecard import CoreGroup, Scorecard
from gym_extensions.scoring.submission.core_score import core_logs
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.charts import svg
from gym_extensions.site.charts.strips import MARGIN, WIDTH
from gym_extensions.site.pages import core
from gym_extensions.site.pages.page import File, Render
from gym_extensions.site.play.watch import Episode, stroboscopes, watched
from gym_extensions.site.submission_results import SEQUENTIAL, SubmissionResult, shade
from gym_extensions.site.text import ends, fixed, group_name, mean, short, split_version, variation
from gym_extensions.submissions.poses import Poses, load_submission, motion_of

MOST_IN_TRIANGLE = 12
"""Methods whose pairs are shown."""
MOST_NAMED = 3
"""Groups that the statement names."""
COLUMNS = {
    "rank": (
        "Rank",
        "First and last possible place in its list. 1–3: the test does not tell which of these.",
    ),
    "name": ("Method", "Its page has every run, file and command."),
    "drawn": (
        "Score",
        "0 is the floor, random or no action; 1 is the expert, one published policy per task.",
    ),
    "kept": ("Kept", "Score at the end, the mean over groups, with its 95 % interval. It sorts a list."),
    "group": (
        "",
        "Mean over tasks of this group and over runs: the score at the end, or what you choose to see.",
    ),
    "forgotten": (
        "Forgotten",
        "Score right after the training on a task minus that at the end; lower is better. Below: the share "
        "of what was learned that is left.",
    ),
    "minutes": ("Minutes", "Processor time of a run of all groups: the mean over the runs that state it."),
    "tuning": ("Tuning", "Training steps spent on choosing the settings."),
    "level": (
        "Level",
        "Trained here: by the project, on seeds that nobody knew before. Verified: its policies ran again on "
        "such seeds. Claimed: not yet.",
    ),
}
"""Name and definition of the columns of the table, in which a column for each group stands in one's place."""
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
        return shade(self.value.mean if self.value and self.value.mean is not None else 0.0)


@dataclass(frozen=True)
class Overview:
    """What the page says of a core board."""

    board: CoreBoard
    cards: Mapping[str, Scorecard]
    boards: Sequence[Board]
    provisional: Mapping[str, str]  # the tasks of the core with a provisional expert, and why it is

    @cached_property
    def ranked(self) -> list[CoreRow]:
        """The ranked methods of the first list that has one, best first."""
        found = [[row for row in each.rows if row.ranked] for each in self.board.lists]
        return next(filter(None, found), [])

    @cached_property
    def scale(self) -> svg.Scale:
        """The scale of the strips, the same in both lists, with every interval and 0."""
        levels = [
            end for each in self.board.references for end in each.value.ends or (each.value.mean or 0.0,)
        ]
        reach = [*core.ends_of(self.board.rows), *levels]
        return svg.scale_around(reach, MARGIN, WIDTH - MARGIN, always=(0.0, 0.5))

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
        """What the reference agent loses, what the best method keeps, of how many, and how certain it is."""
        if not self.ranked:
            return Markup("No method has all runs of the core suite yet. Each row says what is missing.")
        first, *others = self.ranked
        name, kept = NAME.format(short(first.title, 40)), first.metrics[core.FINAL]
        score = f"{mean(kept)} ({ends(kept)})"
        if not others:
            return Markup(ALONE).format(name, score)
        start = Markup("")
        if reference := next((row for row in others if row.name == REFERENCE), None):
            levels = [mean(reference.metrics[metric]) for metric in (core.LEARNING, core.FINAL)]
            start = Markup(FALLS).format(NAME.format(short(reference.title, 40)), *levels)
        start += Markup("Of {} methods{} that ran all {} groups, {} ").format(
            len(self.ranked),
            "" if first.task_conditioned else " without task label",
            len(self.board.groups),
            name,
        )
        pairs = [pair for row in others if (pair := self.board.pair(core.FINAL, first.name, row.name))]
        # On fewer runs, the one with the lower mean can be significantly better.
        wins = [pair for pair in pairs if (pair.mean > 0) == (pair.first == first.name)]
        won = [pair for pair in wins if pair.verdict == "separated"]
        if not won:
            return start + Markup("has the highest mean, {}; no difference is significant.").format(score)
        is_clear = len(won) == len(others)
        each = f"each of the other {len(others)}" if len(others) > 1 else "the other"
        looks = sorted({pair.look for pair in won})
        return start + Markup(LEADS).format(
            "keeps most" if is_clear else "has the highest mean",
            score,
            each if is_clear else f"{len(won)} of {len(others)} others",
            self._alone_first(first),
            " to ".join(map(str, dict.fromkeys((looks[0], looks[-1])))),
            EXPLORATORY.format(core.EXPLORATORY[self.board.edition])
            if any(pair.exploratory for pair in won)
            else ".",
        )

    def _alone_first(self, row: CoreRow) -> str:
        """On which groups a method is significantly ahead; nothing if its row of the core is on no board."""
        boards = {group: self._on_groups.get((group, row.name)) for group in self.board.groups}
        found = {group: each[0] for group, each in boards.items() if each}
        alone = [group_name(name) for name, each in found.items() if each.metrics[core.FINAL].rank == (1, 1)]
        named = f" ({', '.join(alone)})" if 0 < len(alone) <= MOST_NAMED else ""
        return ON_GROUPS.format(len(alone), len(found), named) if found else ""

    def limits(self) -> dict[str, Any]:
        """The facts of what the statement does not show; none without a ranked method that states them."""
        rows = [row for row in self.board.rows if row.ranked]
        known = [(row.name, manifest) for row in rows if (manifest := self.cards[row.name].manifest)]
        if not known:
            return {}
        spent = {name: manifest.tuning.steps if manifest.tuning else 0 for name, manifest in known}
        most = max(spent.values())
        authors = Counter(author for _, manifest in known for author in manifest.authors)
        return {
            "ranked": len(rows),
            "parent": Counter(row.parent for row in rows).most_common(1)[0],  # and of how many methods
            "most_tuned": (most, [name for name, steps in spent.items() if steps == most]),
            "untuned": sum(not steps for steps in spent.values()),
            "lacking": [row.name for row in self.board.rows if row.missing],
            "provisional": [split_version(task)[0] for task in sorted(self.provisional)],
            "maker": authors.most_common(1)[0] if authors else None,  # and of how many methods
        }

    def pairs(self, metric: str) -> list[tuple[CoreRow, list[CorePair | None]]]:
        """The triangle: each method that is compared in a metric, with its pairs with those above it."""
        compared = {name for pair in self.board.pairs[metric] for name in (pair.first, pair.second)}
        rows = [row for row in self.board.rows if row.name in compared][:MOST_IN_TRIANGLE]
        return [
            (row, [self.board.pair(metric, other.name, row.name) for other in rows[:at]])
            for at, row in enumerate(rows)
        ]

    def tint_of(self, pair: CorePair, metric: str) -> str:
        """The class of the colour of a difference: a step per 0.06, better or worse."""
        step = min(5, math.ceil(abs(pair.mean) / 0.06))
        return f"{'won' if (pair.mean > 0) != (metric == core.FORGETTING) else 'lost'}{step}" if step else ""

    @cached_property
    def wanted(self) -> list[Wanted]:
        """The runs that would decide most."""
        return wanted(list(self.cards.values()), self.board, algorithms.names())

    @property
    def of_first_arithmetic(self) -> int:
        """The number of methods whose compared runs were logged in the first arithmetic."""
        return sum(self.cards[row.name].arithmetic == 1 for row in self.board.rows if not row.trained_here)

    def tuning(self, row: CoreRow) -> int | None:
        """The steps spent on choosing the settings."""
        manifest = self.cards[row.name].manifest
        return manifest.tuning.steps if manifest and manifest.tuning else None


NAME = Markup("<strong><bdi>{}</bdi></strong>")
EXPLORATORY = Markup('; <a href="metrics.html#core">{}</a>.')
ALONE = "{} is the only method with all runs of the core suite so far; it keeps {}."
FALLS = "Trained task after task, {} falls from {} to {} (expert: 1). "
LEADS = "{}, {}: significantly more than {}.{} Compared on {} runs per method{}"
ON_GROUPS = " In a single group, it is significantly ahead of all others in {} of {}{}."
"""The sentences of the statement."""

X, Y = (52.0, 306.0), (92.0, 10.0)
"""Left and right, bottom and top of the scores by stage."""
BEGINNING = 2
"""Drawn is twice the time of the shortest episode, so that its end is seen on a large scale."""


@dataclass(frozen=True)
class Shown:
    """A method on the task that is forgotten."""

    name: str
    title: str
    result: SubmissionResult  # of its group
    task: int  # its position in the group, from 0
    run: int  # the run of the drawings
    episodes: tuple[Episode, ...]  # right after its training, and at the end
    frames: int = 0  # how many frames of each are drawn

    @property
    def scores(self) -> list[list[float]]:
        """The task's score by run and stage, from stage 0."""
        return self.result.detail.scores(self.task) or []

    @property
    def stages(self) -> list[Markup]:
        """What was trained in each stage, from the first."""
        return [variation(task, self.result.tasks) for task in self.result.tasks]

    @property
    def changes(self) -> tuple[float, float]:
        """Its score at the end minus that right after its training: over all runs, and of the one drawn."""
        run = self.scores[self.result.runs.index(self.run)]
        return self.result.detail.changes[self.task].mean or 0.0, run[-1] - run[self.task + 1]

    @property
    def means(self) -> list[float]:
        """The mean score of the task over runs, by stage."""
        return [stage[self.task].mean or 0.0 for stage in self.result.stages]

    @property
    def pictures(self) -> list[Markup]:
        """A drawing of the beginning of each episode, both on one scale."""
        beginnings = []
        for each in self.episodes:
            rows = each.coordinates[: self.frames]
            clip = replace(each.clip, frames=len(rows), motion=motion_of(rows, each.poses.unit))
            beginnings.append(replace(each, clip=clip))
        return stroboscopes(beginnings)

    @property
    def seconds(self) -> float:
        """How much of each episode is drawn."""
        poses = self.episodes[0].poses
        return self.frames * poses.steps_per_frame / (poses.steps_per_second or 1.0)

    def line(self, others: Sequence["Shown"]) -> Markup:
        """The score of the task after every stage: a line per run, the mean bold, on the scale of all."""
        means = self.means
        x = svg.Scale(0, len(means) - 1, *X)
        y = svg.scale_around((score for each in others for run in each.scores for score in run), *Y)
        body = []
        for level, name in ((0.0, "floor 0"), (1.0, "expert 1")):
            body.append(svg.stroke(x.start, y.at(level), x.end, y.at(level), "level"))
            body.append(svg.text("tick side", x.start - 6, y.at(level) + 3.5, name))
        for kind, line in [*(("thin", run) for run in self.scores), ("bold", means)]:
            body.append(f'<polyline class="{kind}" points="{svg.points(enumerate(line), x, y)}"/>')
        body.append(svg.disc("mean learning", x.at(self.task + 1), y.at(means[self.task + 1]), 4.5))
        body.append(svg.disc("mean", x.end, y.at(means[-1]), 5))
        for stage in range(len(means)):
            kind = "tick key" if stage == self.task + 1 else "tick"
            body.append(svg.text(kind, x.at(stage), y.start + 15, str(stage)))
        shown = ", ".join(f"stage {stage}: {fixed(value)}" for stage, value in enumerate(means))
        return svg.picture("stages", 320, 112, f"Mean score on this task. {shown}", "".join(body))


def forgetting(cards: Sequence[Scorecard], folders: Mapping[str, Path], best: str) -> tuple[Shown, ...]:
    """The reference agent and another method on the task of the core where they differ most; or nothing.

    They differ in how much is lost: in the mean over runs and in the run that is drawn, of which the smaller
    difference counts. Poses that are not those of the scored runs are not shown.
    """
    by_name = {card.name: card for card in cards}
    if not {REFERENCE, best} <= {*by_name} & {*folders} or best == REFERENCE:
        return ()
    first, second = (_shown(by_name[name], load_submission(folders[name])) for name in (REFERENCE, best))
    differences = {
        key: min(map(sub, second[key].changes, first[key].changes)) for key in first if key in second
    }
    most, key = max(((value, key) for key, value in differences.items()), default=(0.0, ("", 0)))
    chosen = (first[key], second[key]) if most > 0 else ()
    shortest = min((episode.clip.frames for each in chosen for episode in each.episodes), default=0)
    return tuple(replace(each, frames=BEGINNING * shortest) for each in chosen)


def _shown(card: Scorecard, poses: Mapping[str, Poses]) -> dict[tuple[str, int], Shown]:
    """Every task of the core that is not the last of its group and has drawings, by group and position."""
    found = {}
    for name, log in core_logs(card).items():
        result, drawn = SubmissionResult(name, SEQUENTIAL, log), poses.get(name)
        if drawn is None or not drawn.shows(result.runs, result.stage_matrices):
            continue
        for at, row in enumerate(drawn.tasks):
            episodes = watched(row)
            if len(episodes) == 2 and log.scores(at):
                found[name, at] = Shown(card.name, card.title, result, at, drawn.run, episodes)
    return found


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """The first page, the page of the core, and the list of groups."""
    board, listed, known = site.scored.core, site.groups, site.references.tasks
    view = None
    if board:
        of_core = [task for each in listed if each.id in board.groups for task in each.tasks if task in known]
        experts = {task: expert for task in of_core if (expert := known[task].expert)}
        provisional = {task: each.provisional for task, each in experts.items() if each.provisional}
        cards = {card.name: card for card in site.submissions}
        view = Overview(board, cards, site.scored.boards, provisional)
    best = view.ranked[0].name if view and view.ranked else ""
    values = {
        "view": view,
        "board": board,
        "shown": forgetting(site.submissions, render.folders, best),
        "lists": LISTS,
        "columns": COLUMNS,
        "submissions": len(site.submissions),
        "simulator": render.simulator,
        "groups": listed,
        "landscapes": [
            first for each in listed if (first := next(filter(render.landscapes.rows, each.boards), None))
        ],
    }
    for page in ("index.html", "groups.html", "core.html"):
        yield page, render(page, page, **values)
