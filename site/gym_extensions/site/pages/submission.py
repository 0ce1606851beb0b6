"""One page per submission: its facts, scores and returns."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.addresses import entry_path
from gym_extensions.site.page import Draft, File, Page, Render


def publish_entry(entry: Scorecard, render: Render) -> Iterator[File]:
    """The page of a submission; that of a refused one lists its problems."""
    path = entry_path(entry.name)
    inputs = msgspec.json.encode(entry)
    yield path, Draft(inputs, lambda: render("submission.html", path, entry=entry))


PAGE = Page(title="Submissions", order=10, publish_entry=publish_entry)
