"""One page per submission: its facts, scores and returns, and the scripts with the poses that it plays."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from gym_extensions.scoring.poses.files import load_entry
from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.addresses import entry_path
from gym_extensions.site.motion.watch import watches
from gym_extensions.site.page import Draft, File, Page, Render


def publish_entry(entry: Scorecard, render: Render) -> Iterator[File]:
    """The page of a submission; that of a refused one lists its problems."""
    path = entry_path(entry.name)
    poses = load_entry(render.site.poses, entry.name)
    panels = watches(entry, poses)
    inputs = msgspec.json.encode((entry, poses))
    yield path, Draft(inputs, lambda: render("submission.html", path, entry=entry, watches=panels))
    for panel in panels.values():
        yield panel.path, panel.script


PAGE = Page(title="Submissions", order=10, publish_entry=publish_entry)
