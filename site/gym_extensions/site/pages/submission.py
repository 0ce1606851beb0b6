"""One page per submission: its facts, scores and returns; those of several groups have pages of their own."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from gym_extensions.scoring.poses.files import load_entry
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.addresses import entry_path, results_path
from gym_extensions.site.motion.watch import watches
from gym_extensions.site.output import encoded
from gym_extensions.site.page import Draft, File, Page, Render
from gym_extensions.site.views.trial import separate_groups


def publish_entry(entry: Scorecard, render: Render) -> Iterator[File]:
    """The page of a submission, that of a refused one with its problems; and the poses that it plays."""
    path = entry_path(entry.name)
    poses = load_entry(render.site.poses, entry.name)
    panels = watches(entry, poses)
    inputs = render.inputs + encoded(poses)
    yield path, Draft(inputs, lambda: render("submission.html", path, entry=entry, watches=panels))
    for group in separate_groups(entry):
        page = results_path(entry.name, group)
        values = {"entry": entry, "group": group, "watches": panels}
        yield page, Draft(inputs, partial(render, "results.html", page, **values))
    for panel in panels.values():
        yield panel.path, panel.script


PAGE = Page(title="Submissions", order=10, publish_entry=publish_entry)
