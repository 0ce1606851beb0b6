"""The pages of an entry, and the list of all entries."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from gym_extensions.rollouts.review import REPORTED
from gym_extensions.scoring.poses import load_entry
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site import paths
from gym_extensions.site.board_views import BoardView, Leaderboard
from gym_extensions.site.entry_results import separate_groups
from gym_extensions.site.output import encoded
from gym_extensions.site.pages import core, exports
from gym_extensions.site.pages.landscapes import TITLES
from gym_extensions.site.pages.page import Draft, File, Render
from gym_extensions.site.play.watch import watches
from gym_extensions.site.tables import Part, parts


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


ENTRIES_PER_PAGE = 200
ON_A_BOARD = "On a board"
OFF_BOARDS = "Not on a board: a budget that is only for tests, or no scored group"
PUBLISHED = "Reported elsewhere: published results without logs, shown as printed and not ranked"
REFUSED = "Refused: they break a rule, and are on no board until all problems are fixed"
STATUS = (ON_A_BOARD, OFF_BOARDS, PUBLISHED, REFUSED)


def list_path(number: int) -> str:
    """The path of a page of the list of all entries."""
    return f"entries{f'-{number}' if number > 1 else ''}.html"


def publish_list(site: Leaderboard, render: Render) -> Iterator[File]:
    """All submissions, refused ones and published tables included: 200 per page, by status and name."""
    for part in entry_pages(site.entries, site.boards):
        path = part.path(part.number)
        yield path, render("entries.html", path, part=part, statuses=STATUS)


def entry_pages(entries: Sequence[Scorecard], boards: Sequence[BoardView]) -> Iterator[Part]:
    """Every page of the list: pairs of a status and an entry, sorted by status and name."""
    on_boards = {row.entry.name for board in boards for row in board.rows}
    pairs = [(_status(entry, on_boards), entry) for entry in entries]
    pairs.sort(key=lambda pair: (STATUS.index(pair[0]), pair[1].name))
    return parts(pairs, ENTRIES_PER_PAGE, list_path)


def _status(entry: Scorecard, on_boards: set[str]) -> str:
    if entry.problems:
        return REFUSED
    if entry.level == REPORTED:
        return PUBLISHED
    return ON_A_BOARD if entry.name in on_boards else OFF_BOARDS
