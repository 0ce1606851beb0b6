"""One page per submission: its facts, scores and returns; those of several groups have pages of their own."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import msgspec

from gym_extensions.scoring.scorecard.model import Scorecard
from gym_extensions.site.addresses import entry_path, results_path
from gym_extensions.site.page import Draft, File, Page, Render
from gym_extensions.site.views.trial import separate_groups


def publish_entry(entry: Scorecard, render: Render) -> Iterator[File]:
    """The page of a submission; that of a refused one lists its problems."""
    path = entry_path(entry.name)
    inputs = msgspec.json.encode(entry)
    yield path, Draft(inputs, lambda: render("submission.html", path, entry=entry))
    for group in separate_groups(entry):
        page = results_path(entry.name, group)
        yield page, Draft(inputs, partial(render, "results.html", page, entry=entry, group=group))


PAGE = Page(title="Submissions", order=10, publish_entry=publish_entry)
