"""The kinds of pages, in the order of the menu: which files each of them writes, and from what.

``PAGES`` lists them. A page that is made from all entries has ``publish``, one per entry ``publish_entry``.
"""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from markupsafe import Markup

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import BUDGETS, FULL_ENTRY_RUNS
from gym_extensions.catalog.sheets import sheet
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.rollouts.review import REPORTED
from gym_extensions.scoring.output.schema import schema_texts
from gym_extensions.scoring.output.tables import board_frame, csv_text, to_csv
from gym_extensions.scoring.poses import load_entry
from gym_extensions.scoring.ranking.boards import BoardsDocument
from gym_extensions.scoring.scorecard import ReferenceValue, Scorecard, ScorecardDocument
from gym_extensions.site import api, exports, speed
from gym_extensions.site.boards import Frame, Leaderboard
from gym_extensions.site.changes import changelog, entry_events, feed, releases
from gym_extensions.site.groups import Group, groups
from gym_extensions.site.landscapes import Landscapes
from gym_extensions.site.motion import watches
from gym_extensions.site.mujoco_wasm import VERSION, Simulator
from gym_extensions.site.output import encoded
from gym_extensions.site.play import offer
from gym_extensions.site.records import TaskPolicies
from gym_extensions.site.tables import PAGE_ROWS, entry_pages, parts
from gym_extensions.site.tasks import (
    TaskView,
    best_entries,
    by_base,
    map_file,
    map_picture,
    measured,
    pictures,
)
from gym_extensions.site.templating import environment
from gym_extensions.site.text import is_verified
from gym_extensions.site.trial import EXAMPLE, separate_groups

MAX_EVENTS = 100
"""Events on the page of changes."""
MAX_COMPARED = 40
"""Boards that the page of comparisons links to."""


@dataclass(frozen=True)
class Render:
    """Fills the templates with the menu and what every page shows.

    Args:
        site: what every page shows.
        pages: all kinds of pages.
        inputs: the digest of the scorecard of the entry whose pages are written; empty for shared pages.
        folder: the folder of that entry, where it is known.
        folders: the folders of all entries by name, where they are known.
        simulator: MuJoCo for the browser, if the site has it.
        landscapes: those of all entries whose folders are known.
    """

    site: Frame
    pages: tuple[Page, ...]
    inputs: bytes = b""
    folder: Path | None = None
    folders: Mapping[str, Path] = field(default_factory=dict)
    simulator: Simulator | None = None
    landscapes: Landscapes = field(default_factory=Landscapes)

    def __call__(self, template: str, path: str, **values: object) -> str:
        """The text of the page at ``path``."""
        relative = posixpath.relpath(".", posixpath.dirname(path) or ".")
        linked = [page for page in self.pages if page.path]
        return (
            environment()
            .get_template(template)
            .render(
                site=self.site,
                menu=[page for page in linked if not page.in_footer],
                footer=[page for page in linked if page.in_footer],
                has_task_pages=TASK_PAGES in self.pages,
                path=path,
                root=Markup("" if relative == "." else f"{relative}/"),
                **values,
            )
        )


@dataclass(frozen=True)
class Draft:
    """A file that is written only if its inputs changed.

    Args:
        inputs: everything that the text depends on besides the code, the menu and the references.
        write: returns the text.
    """

    inputs: bytes
    write: Callable[[], str]


File = tuple[str, str | bytes | Draft]
"""A path and its content."""


@dataclass(frozen=True)
class Page:
    """A kind of page.

    Args:
        title: its name in the menu.
        path: the path that the menu links to; without it the page is not in the menu.
        publish: yields the files that are made from all entries. It gets entries without logs, so that many
            fit in memory.
        publish_entry: yields the files of one entry, from its whole scorecard.
        in_footer: whether the footer links to it instead of the menu.
    """

    title: str
    path: str = ""
    publish: Callable[[Leaderboard, Render], Iterator[File]] | None = None
    publish_entry: Callable[[Scorecard, Render], Iterator[File]] | None = None
    in_footer: bool = False


def _overview(site: Leaderboard, render: Render) -> Iterator[File]:
    """Which method is best on the core, a figure of it, and where everything else is."""
    scored = [entry for entry in site.entries if not entry.problems and entry.level != REPORTED]
    values = {
        "entries": len(scored),
        "verified": sum(is_verified(entry) for entry in scored),
        "reported": sum(entry.level == REPORTED for entry in site.entries),
        "refused": sum(bool(entry.problems) for entry in site.entries),
        "groups": groups(site.boards, site.entrants, site.references),
        "tasks_published": len(TASKS),
        "records": sum(map(len, site.records.values())),
        "board": site.scored.core,
    }
    yield "index.html", render("index.html", "index.html", **values)
    yield "core.html", render("core.html", "core.html", board=site.scored.core)


def _groups(site: Leaderboard, render: Render) -> Iterator[File]:
    """A page for each group and suite with its boards, and the table of all rows of every board."""
    for group in groups(site.boards, site.entrants, site.references):
        path = api.group_path(group.id)
        rows = [(row.entry, row.entrant.inputs) for board in group.boards for row in board.rows]
        shared = repr((group.tasks, group.paper, [board.id for board in group.boards])).encode()
        landscapes = {board.id: render.landscapes.rows(board) for board in group.boards}
        shares = [values for pairs in landscapes.values() for _, values in pairs]
        write = partial(render, "group.html", path, group=group, landscapes=landscapes)
        yield path, Draft(shared + encoded((rows, shares)), write)
    for board in site.boards:
        for part in parts(board.rows, PAGE_ROWS, partial(api.board_path, board.id)):
            path = part.path(part.number)
            yield path, render("board.html", path, board=board, part=part)


def _tasks(site: Leaderboard, render: Render) -> Iterator[File]:
    """The list of tasks, then a page per published task."""
    yield "tasks.html", render("tasks.html", "tasks.html", bases=by_base())
    references, best = measured(site.references), best_entries(site.boards)
    for task in TASKS.values():
        path = api.task_path(task.id)
        view = TaskView(task, references.get(task.id), best.get(task.id, ()))
        policies = TaskPolicies(task, site.records.get(task.id, ()))
        write = partial(render, "task.html", path, task=view, policies=policies)
        yield path, Draft(view.inputs + policies.inputs, write)
        if policies.watch is not None:
            yield policies.watch.path, policies.watch.script


def _submission(entry: Scorecard, render: Render) -> Iterator[File]:
    """The page of a submission, those of its groups if there are several, and the poses that they play."""
    path = api.entry_path(entry.name)
    poses = load_entry(render.folder) if render.folder else {}
    panels = watches(entry, poses)
    landscapes = render.landscapes.views(entry)
    inputs = render.inputs + encoded(poses) + b"".join(view.inputs for view in landscapes.values())
    shown = {"entry": entry, "watches": panels, "landscapes": landscapes}
    yield path, Draft(inputs, partial(render, "submission.html", path, **shown))
    for group in separate_groups(entry):
        page = api.results_path(entry.name, group)
        yield page, Draft(inputs, partial(render, "results.html", page, group=group, **shown))
    for group, view in landscapes.items():
        if view.landscape is not None:
            yield api.entry_file(entry.name, f"landscape-{group}.json"), view.landscape.to_json()
    for panel in panels.values():
        yield panel.path, panel.script


def _entries(site: Leaderboard, render: Render) -> Iterator[File]:
    """All submissions, refused ones and published tables included: 200 per page, by status and name."""
    for part in entry_pages(site.entries, site.boards):
        path = part.path(part.number)
        yield path, render("entries.html", path, part=part)


def _compare(site: Leaderboard, render: Render) -> Iterator[File]:
    """Two menus of entries and what separates them; without script, links to the boards."""
    boards = [board for board in site.boards if board.leader and len(board.rows) > 1]
    yield "compare.html", render("compare.html", "compare.html", boards=boards[:MAX_COMPARED])
    yield api.COMPARED, api.compared(site)


def _play(site: Leaderboard, render: Render) -> Iterator[File]:
    """The page on which MuJoCo runs in the browser, and its files; without the simulator it says so."""
    leaders = [board.leader.row.card.name for board in site.boards if board.leader]
    watch = api.entry_path(leaders[0]) if leaders else "entries.html"
    play = offer(site, render.folders, render.simulator) if render.simulator else None
    size = sum(map(len, render.simulator.files().values())) / 1e6 if render.simulator else 0.0
    values = {"play": play, "watch": watch, "size": size, "version": VERSION}
    yield "play.html", render("play.html", "play.html", **values)
    yield from play.files.items() if play else ()


def _metrics(site: Leaderboard, render: Render) -> Iterator[File]:
    """The definition of every number, with an anchor per metric."""
    used = {board.budget for board in site.boards}
    yield "metrics.html", render("metrics.html", "metrics.html", used_budgets=used, example=EXAMPLE)


def _submit(_site: Leaderboard, render: Render) -> Iterator[File]:
    """How to submit results, in short; docs/submit.md has the details."""
    on_boards = [budget.name for budget in BUDGETS.values() if budget.on_boards]
    yield "submit.html", render("submit.html", "submit.html", budgets=on_boards, runs=FULL_ENTRY_RUNS)


def _references(site: Leaderboard, render: Render) -> Iterator[File]:
    """What 0 and 1 mean: a table per base body; bodies without a reference are in one sentence."""
    known = measured(site.references)
    tables = {
        base: [(task.id, known[task.id]) for task in tasks if task.id in known]
        for base, tasks in by_base().items()
    }
    bases = {base: rows for base, rows in tables.items() if rows}
    missing = [base for base, rows in tables.items() if not rows]
    yield "references.html", render("references.html", "references.html", bases=bases, missing=missing)


def _entry_data(entry: Scorecard, render: Render) -> Iterator[File]:
    """The scorecard of a submission, as ``score --json`` prints it."""
    document = ScorecardDocument(references=render.site.references, submissions=(entry,))
    yield api.entry_data(entry.name), Draft(render.inputs, document.to_json)


def _data(site: Leaderboard, render: Render) -> Iterator[File]:
    """The page that lists the data, the index, boards, groups and schemas."""
    members = groups(site.boards, site.entrants, site.references)
    boards = {board.id: api.index_board(board) for board in site.boards}
    yield "data.html", render("data.html", "data.html")
    index = api.Index(
        references=site.references,
        entries=tuple(map(api.index_entry, site.entries)),
        boards=tuple(boards.values()),
        core=api.CORE_DATA,
        groups={group.id: api.group_data(group.id) for group in members},
    )
    yield "api/index.json", index.to_json()
    yield api.CORE_DATA, BoardsDocument(core=site.scored.core, boards=()).to_json()
    for board in site.boards:
        yield api.board_data(board.id), BoardsDocument(boards=(board.scored,)).to_json()
        yield api.board_data(board.id, "csv"), to_csv(board_frame(board.scored))
        yield api.board_data(board.id, "pairs.js"), board.pairs
    for group in members:
        yield api.group_data(group.id), _group_document(group, site, boards).to_json()
    for name, text in {**schema_texts(), **api.schemas()}.items():
        yield f"schemas/{name}", text


def _group_document(group: Group, site: Leaderboard, boards: dict[str, api.IndexBoard]) -> api.GroupDocument:
    known = {}
    for row in group.tasks:
        if row.measured:
            expert = row.measured.expert
            known[row.task] = ReferenceValue(
                row.measured.floor.mean, expert.mean if expert else None, not expert
            )
    details = (trial.detail for board in group.boards for trial in board.trials)
    used = next((detail.reference for detail in details if detail), {})
    return api.GroupDocument(
        id=group.id,
        references=site.references,
        tasks=group.task_ids,
        groups=group.members,
        reference=used or known,
        boards=tuple(boards[board.id] for board in group.boards),
    )


def _changes(site: Leaderboard, render: Render) -> Iterator[File]:
    """What changed: entries, releases, and both as an Atom feed."""
    history, events = releases(changelog()), entry_events(site.entries)
    values = {"releases": history, "events": events[:MAX_EVENTS], "count": len(events)}
    yield "changes.html", render("changes.html", "changes.html", **values)
    yield "feed.xml", render("feed.xml", "feed.xml", items=feed(history, events))


def _about(_site: Leaderboard, render: Render) -> Iterator[File]:
    """What gym-extensions is, why, how it differs from the paper, its licence, and how to cite it."""
    values = {"tasks": len(TASKS), "groups": len(GROUPS), "citation": exports.software_bibtex()}
    yield "about.html", render("about.html", "about.html", **values)


def _speed(_site: Leaderboard, render: Render) -> Iterator[File]:
    """Measured speed, a section per measure, the last one for memory."""
    yield "speed.html", render("speed.html", "speed.html", **speed.measured())


def _pictures(_site: Leaderboard, _render: Render) -> Iterator[File]:
    """Every picture file of the package, and a drawn map per course."""
    for file in pictures().values():
        yield f"pictures/{file.name}", file.read_bytes()
    maps = {map_picture(task): task.id for task in reversed(TASKS.values())}
    for name, task_id in sorted(maps.items()):
        facts = sheet(task_id)
        if name and facts is not None:
            yield f"pictures/{name}", map_file(facts)


def _entry_exports(entry: Scorecard, render: Render) -> Iterator[File]:
    """The files that the page of an entry offers: metrics as CSV and a citation."""
    if not entry.problems:
        document = ScorecardDocument(references=render.site.references, submissions=(entry,))
        yield api.entry_file(entry.name, "metrics.csv"), Draft(render.inputs, lambda: csv_text(document))
        yield api.entry_file(entry.name, "citation.bib"), exports.bibtex(entry)


TASK_PAGES = Page("Tasks", "tasks.html", _tasks)
"""The pages of tasks; other pages link to them if the site has them."""

PAGES = (
    Page("Overview", "index.html", _overview),
    Page("Core", "core.html"),
    Page("Groups", "index.html#groups", _groups),
    TASK_PAGES,
    Page("Submissions", publish_entry=_submission),
    Page("Entries", "entries.html", _entries),
    Page("Compare", "compare.html", _compare),
    Page("Play", "play.html", _play),
    Page("Metrics", "metrics.html", _metrics),
    Page("Submit", "submit.html", _submit),
    Page("References", "references.html", _references, in_footer=True),
    Page("Data", "data.html", _data, _entry_data, in_footer=True),
    Page("Changes", "changes.html", _changes, in_footer=True),
    Page("About", "about.html", _about, in_footer=True),
    Page("Speed", "speed.html", _speed, in_footer=True),
    Page("Pictures", publish=_pictures),
    Page("Exports", publish_entry=_entry_exports),
)
"""All kinds of pages in the order of the menu."""
