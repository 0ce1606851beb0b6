"""The pages of tasks, with what 1 is, the best results and the expert; the page References."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property

from markupsafe import Markup

from gym_extensions import references
from gym_extensions.catalog import descriptions, fingerprints, groups, tasks, variations
from gym_extensions.catalog.tasks import TASKS, Task
from gym_extensions.references import MeasuredReference, experts, load_references, trained_alone
from gym_extensions.scoring.ranking.boards import TaskBest
from gym_extensions.scoring.scorecard import ReferencesInfo
from gym_extensions.site import paths
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.charts.task_pictures import map_file, map_picture, pictures, task_picture
from gym_extensions.site.pages.page import TASK_LIST, File, Render
from gym_extensions.site.play.assets import play_link
from gym_extensions.site.play.watch import Watch, WatchedTask, watched_task
from gym_extensions.site.text import grouped, inline
from gym_extensions.submissions.layout import POSES
from gym_extensions.submissions.poses import PolicyPoses, TaskPoses


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """The list of tasks, then a page per published task."""
    yield TASK_LIST, render("tasks.html", TASK_LIST, bases=tasks.tasks_by_base())
    references, best = measured(site.references), site.scored.best
    for task in TASKS.values():
        path = paths.task_path(task.id)
        view = TaskView(task, references.get(task.id), best.get(task.id, ()))
        facts = {
            "description": descriptions.description(task.id),
            "fingerprint": fingerprints.published(task.id),
            "versions": tasks.versions(task),
        }
        values = {"task": view, "runs": alone(task.id), "play": play_link(task), **facts}
        yield path, render("task.html", path, **values)
        if view.watch is not None:
            yield view.watch.path, view.watch.script


def publish_references(site: Leaderboard, render: Render) -> Iterator[File]:
    """What 0 and 1 mean: a table per base body; bodies without a reference are in one sentence."""
    known = measured(site.references)
    tables = {
        base: [(task.id, known[task.id], alone(task.id)) for task in members if task.id in known]
        for base, members in tasks.tasks_by_base().items()
    }
    bases = {base: rows for base, rows in tables.items() if rows}
    missing = [base for base, rows in tables.items() if not rows]
    yield "references.html", render("references.html", "references.html", bases=bases, missing=missing)


def publish_pictures(_site: Leaderboard, _render: Render) -> Iterator[File]:
    """Every picture file of the package, and a drawn map per course."""
    for file in pictures().values():
        yield f"pictures/{file.name}", file.read_bytes()
    maps = {map_picture(task): task.id for task in reversed(TASKS.values())}
    for name, task_id in sorted(maps.items()):
        facts = descriptions.description(task_id)
        if name and facts is not None:
            yield f"pictures/{name}", map_file(facts)


@cache
def measured(info: ReferencesInfo) -> Mapping[str, MeasuredReference]:
    """Floor and expert by task id, of this benchmark version; empty if the digest of its file is another."""
    if not info.sha256 or load_references(info.version).digest != info.sha256:
        return {}
    return references.measured(info.version)


def alone(task_id: str) -> tuple[float, ...]:
    """The mean return of each run of the reference agent on a task alone."""
    found = trained_alone().get(task_id)
    return tuple(run.mean for run in found.runs) if found else ()


@dataclass(frozen=True)
class TaskView:
    """A task as its page shows it, with its best submissions, the best one first."""

    task: Task
    measured: MeasuredReference | None
    best: tuple[TaskBest, ...]

    @property
    def base(self) -> Task | None:
        """The task of the base body without variations; None for that task itself and for maps."""
        if not self.task.variations or self.task.body.family == "navigation":
            return None
        return tasks.task(self.task.base)

    @property
    def picture(self) -> str:
        """The path of its picture; empty without one."""
        return task_picture(self.task.id)

    @property
    def base_picture(self) -> str:
        """The path of the base body's picture; empty if it is the same."""
        picture = task_picture(self.base.id) if self.base else ""
        return "" if picture == self.picture else picture

    @property
    def gravity(self) -> float | None:
        """Its gravity relative to that of the base body; None if gravity does not differ."""
        factors = [each.factor for each in self.task.variations if isinstance(each, variations.Gravity)]
        return factors[0] if factors else None

    @property
    def facts(self) -> tuple[tuple[str, Markup], ...]:
        """Reward, start, end, time limit, success and source, in words."""
        prose, success = self.task.body.prose, self.task.body.success
        facts = (
            ("Reward per step", prose.reward),
            ("Start", prose.start),
            ("End", prose.end),
            ("Time limit", f"{grouped(self.task.max_steps)} steps."),
            ("Success", success.text if success else "Not defined."),
            ("Source", prose.source),
        )
        return tuple((name, inline(text)) for name, text in facts)

    @cached_property
    def shown(self) -> TaskPoses | None:
        """The poses of the expert; None if there are none of its policy."""
        path = experts.DATA / POSES / f"{self.task.bare_name}.json"
        poses = PolicyPoses.load(path, "bad-poses", "python -m tools.experts poses")
        if poses is not None and poses.policy == experts.card(self.task).policy:
            return poses.poses
        return None

    @cached_property
    def watch(self) -> Watch | None:
        """The panel; None without poses."""
        found = watched_task(self.shown, "The expert") if self.shown else None
        if found is None or not found.episodes:
            return None
        path = paths.task_path(self.task.id).removesuffix(".html") + "-poses.js"
        return Watch("watch-policies", path, 0, (WatchedTask(self.task.id, found.episodes),))

    @property
    def groups(self) -> tuple[tuple[str, int, int], ...]:
        """Id of each group that it belongs to, its position there, and the number of tasks."""
        return tuple(
            (group.id, group.task_ids.index(self.task.id) + 1, len(group.tasks))
            for group in groups.GROUPS.values()
            if self.task.id in group.task_ids
        )
