"""What 0 and 1 mean on every task: floors and ceilings with agent, budget, runs and standard error."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import File, Page, Render
from gym_extensions.site.tasks.task import by_base
from gym_extensions.site.views.reference import measured

PATH = "references.html"


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """One page with a table per base body; bodies without a reference are in one sentence."""
    known = measured(site.references)
    rows = {
        base: [(task.id, known[task.id]) for task in tasks if task.id in known]
        for base, tasks in by_base().items()
    }
    bases = {base: row for base, row in rows.items() if row}
    missing = [base for base, row in rows.items() if not row]
    yield PATH, render("references.html", PATH, bases=bases, missing=missing)


PAGE = Page(title="References", order=50, path=PATH, publish=publish, in_footer=True)
