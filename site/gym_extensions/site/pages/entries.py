"""The pages of an entry, and the list of all entries."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from gym_extensions.rollouts.review import REPORTED
from gym_extensions.scoring.poses import load_entry
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site import paths
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.entry_results import separate_groups
from gym_extensions.site.output import encoded
from gym_extensions.site.pages import core, exports
from gym_extensions.site.pages.landscapes import TITLES
from gym_extensions.site.pages.page import Draft, File, Render
from gym_extensions.site.play.watch import watches


def publish_entry(entry: Scorecard, render: Render) -> Iterator[File]:
    """The page of an entry, those of its groups if there are several, and the poses that they play."""
    path = paths.entry_path(entry.name)
    folder = render.folders.get(entry.name)
    poses = load_entry(folder) if folder else {}
    panels = watches(entry, poses)
    landscapes = render.landscapes.views(entry)
    inputs = render.inputs[entry.name] + encoded(poses) + b"".join(v.inputs for v in landscapes.values())
    shown = {"entry": entry, "watches": panels, "landscapes": landscapes, "landscape_titles": TITLES}
    yield path, Draft(inputs, partial(render, "submission.html", path, core=core, exports=exports, **shown))
    for group in separate_groups(entry):
        page = paths.results_path(entry.name, group)
        yield page, Draft(inputs, partial(render, "results.html", page, group=group, **shown))
    for group, view in landscapes.items():
        if view.landscape is not None:
            yield paths.entry_file(entry.name, f"landscape-{group}.json"), view.landscape.to_json()
    for panel in panels.values():
        yield panel.path, panel.script


ON_A_BOARD = "On a board"
OFF_BOARDS = "Not on a board: a budget that is only for tests, or no scored group"
PUBLISHED = "Reported elsewhere: published results without logs, shown as printed and not ranked"
REFUSED = "Refused: they break a rule, and are on no board until all problems are fixed"
STATUS = (ON_A_BOARD, OFF_BOARDS, PUBLISHED, REFUSED)


def publish_list(site: Leaderboard, render: Render) -> Iterator[File]:
    """All submissions by status and name, refused ones and published tables included."""
    on_boards = {row.entry.name for board in site.boards for row in board.rows}
    by_status: dict[str, list[Scorecard]] = {status: [] for status in STATUS}
    for entry in site.entries:
        by_status[_status(entry, on_boards)].append(entry)
    yield "entries.html", render("entries.html", "entries.html", by_status=by_status)


def _status(entry: Scorecard, on_boards: set[str]) -> str:
    if entry.problems:
        return REFUSED
    if entry.level == REPORTED:
        return PUBLISHED
    return ON_A_BOARD if entry.name in on_boards else OFF_BOARDS
