"""The pages of tasks, with what 1 is, the best results and the expert; the page References."""

from collections.abc import Iterator

from gym_extensions.catalog import descriptions, fingerprints, groups, tasks, variations
from gym_extensions.references import experts, trained_alone
from gym_extensions.site import board_views, paths, text
from gym_extensions.site.charts.task_pictures import map_file, map_picture, pictures
from gym_extensions.site.pages.page import TASK_LIST, File, Render
from gym_extensions.site.play import assets, watch
from gym_extensions.submissions.layout import POSES
from gym_extensions.submissions.poses import PolicyPoses


def publish(site: board_views.Leaderboard, render: Render) -> Iterator[File]:
    """The list of tasks, then a page per published task."""
    yield TASK_LIST, render("tasks.html", TASK_LIST, bases=tasks.tasks_by_base())
    references, best = site.references.tasks, site.scored.best
    for task in tasks.TASKS.values():
        path, panel, success = paths.task_path(task.id), expert_panel(task), task.body.success
        is_varied = task.variations and task.body.family != "navigation"
        values = {
            "task": task,
            "base": tasks.task(task.base) if is_varied else None,  # the body without variations
            "gravity": [each.factor for each in task.variations if isinstance(each, variations.Gravity)],
            "facts": {
                "Reward per step": task.body.prose.reward,
                "Start": task.body.prose.start,
                "End": task.body.prose.end,
                "Time limit": f"{text.grouped(task.max_steps)} steps.",
                "Success": success.sentence if success else "Not defined.",
                "Source": task.body.prose.source,
            },
            "reference": references.get(task.id),
            "runs": alone(task.id),
            "best": best.get(task.id, ()),
            "groups": [group for group in groups.GROUPS.values() if task.id in group.task_ids],
            "panel": panel,
            "play": assets.play_link(task) if render.simulator else "",
            "description": descriptions.descriptions().get(task.id),
            "fingerprint": fingerprints.published(task.id),
            "versions": tasks.versions(task),
        }
        yield path, render("task.html", path, **values)
        if panel is not None:
            yield panel.path, panel.script


def publish_references(site: board_views.Leaderboard, render: Render) -> Iterator[File]:
    """What 0 and 1 mean: a table per base body; bodies without a reference are in one sentence."""
    known = site.references.tasks
    tables = {
        base: [(task.id, known[task.id], alone(task.id)) for task in members if task.id in known]
        for base, members in tasks.tasks_by_base().items()
    }
    bases = {base: rows for base, rows in tables.items() if rows}
    missing = [base for base, rows in tables.items() if not rows]
    yield "references.html", render("references.html", "references.html", bases=bases, missing=missing)


def publish_pictures(_site: board_views.Leaderboard, _render: Render) -> Iterator[File]:
    """Every picture file of the package, and a drawn map per course."""
    for file in pictures().values():
        yield f"pictures/{file.name}", file.read_bytes()
    maps = {map_picture(task): task.id for task in reversed(tasks.TASKS.values())}
    for name, task_id in sorted(maps.items()):
        facts = descriptions.descriptions().get(task_id)
        if name and facts is not None:
            yield f"pictures/{name}", map_file(facts)


def alone(task_id: str) -> tuple[float, ...]:
    """The mean return of each run of the reference agent on a task alone."""
    found = trained_alone().get(task_id)
    return tuple(run.mean for run in found.runs) if found else ()


def expert_panel(task: tasks.Task) -> watch.Watch | None:
    """The panel with an episode of the expert; None if there are no poses of its policy."""
    file = experts.DATA / POSES / f"{task.bare_name}.json"
    poses = PolicyPoses.load(file, "bad-poses", "python -m tools.experts poses")
    if poses is None or poses.policy != experts.card(task).policy:
        return None
    path = paths.task_path(task.id).replace(".html", "-poses.js")
    episodes = watch.watched(poses.poses, "The expert")
    return watch.Watch("watch-policies", path, 0, (episodes,)) if episodes else None
