"""One page per submission: its facts, scores and returns, and the scripts with the poses that it plays."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import Page, Render
from gym_extensions.site.views.trial import group_trials
from gym_extensions.site.views.watch import watch


def publish(site: Leaderboard, render: Render) -> Iterator[tuple[str, str]]:
    """A page per submission; that of a refused one lists its problems."""
    for entry in site.entries:
        path = site.addresses[entry.name]
        yield path, render("submission.html", path, entry=entry)
        for trial in group_trials(entry):
            panel = watch(trial, site.poses.get((entry.name, trial.group)), path)
            if panel is not None:
                yield panel.path, panel.script


PAGE = Page(title="Submissions", order=10, publish=publish)
