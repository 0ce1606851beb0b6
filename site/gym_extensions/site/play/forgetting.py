"""What forgetting looks like: one task under one method, right after it was learned and at the end."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from operator import sub
from pathlib import Path
from urllib.parse import urlencode

from markupsafe import Markup

from gym_extensions.catalog.tasks import TASKS
from gym_extensions.scoring.ranking.core_board import REFERENCE
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.suites import core_logs
from gym_extensions.site.charts import svg
from gym_extensions.site.play.stroboscopes import stroboscopes
from gym_extensions.site.play.watch import Episode, watched
from gym_extensions.site.submission_results import SEQUENTIAL, SubmissionResult
from gym_extensions.site.text import fixed, split_version, variation
from gym_extensions.submissions.poses import Poses, load_submission, motion_of

X, Y = (52.0, 306.0), (92.0, 10.0)
"""Left and right, bottom and top of the scores by stage."""
BEGINNING = 2
"""Drawn is twice the time of the shortest episode, so that its end is seen on a large scale."""


@dataclass(frozen=True)
class Shown:
    """A method on the task."""

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
        changes = [run[-1] - run[self.task + 1] for run in self.scores]
        return sum(changes) / len(changes), changes[self.result.runs.index(self.run)]

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

    @property
    def play(self) -> str:
        """The path of the page Play with this run of the method, after the stage that trained the task."""
        task = split_version(self.result.tasks[self.task])[0]
        chosen = {"submission": self.name, "run": self.run, "stage": self.task + 1}
        return f"play.html#?{urlencode({'group': self.result.group, 'task': task} | chosen)}"

    def line(self, others: Sequence["Shown"]) -> Markup:
        """The score of the task after every stage: a line per run, the mean bold, on the scale of all."""
        means = self.means
        x = svg.Scale(0, len(means) - 1, *X)
        y = svg.scale_around((score for each in others for run in each.scores for score in run), *Y)
        left, up = x.at(self.task + 1), y.at(means[self.task + 1])
        body = []
        for level, name in ((0.0, "floor 0"), (1.0, "expert 1")):
            body.append(svg.stroke(x.start, y.at(level), x.end, y.at(level), "level"))
            body.append(svg.text("tick side", x.start - 6, y.at(level) + 3.5, name))
        for kind, line in [*(("thin", run) for run in self.scores), ("bold", means)]:
            body.append(f'<polyline class="{kind}" points="{svg.points(enumerate(line), x, y)}"/>')
        body.append(f'<circle class="mean learning" cx="{svg.px(left)}" cy="{svg.px(up)}" r="4.5"/>')
        body.append(f'<circle class="mean" cx="{svg.px(x.end)}" cy="{svg.px(y.at(means[-1]))}" r="5"/>')
        for stage in range(len(means)):
            kind = "tick key" if stage == self.task + 1 else "tick"
            body.append(svg.text(kind, x.at(stage), y.start + 15, str(stage)))
        shown = ", ".join(f"stage {stage}: {fixed(value)}" for stage, value in enumerate(means))
        return svg.picture("stages", "320", "112", f"Mean score on this task. {shown}", "".join(body))


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
            if len(episodes) == 2 and row.task in TASKS and log.scores(at):
                found[name, at] = Shown(card.name, card.title, result, at, drawn.run, episodes)
    return found
