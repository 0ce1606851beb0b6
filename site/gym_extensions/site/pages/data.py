"""The data behind every page: one JSON per entry, board and group, an index, and the JSON Schemas."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions.scoring.leaderboard.model import BoardsDocument
from gym_extensions.scoring.output.schema import schema_texts
from gym_extensions.scoring.scorecard.model import ReferenceValue, Scorecard, ScorecardDocument
from gym_extensions.site.addresses import board_data, board_path, entry_data, entry_path, group_data
from gym_extensions.site.api import GroupDocument, Index, IndexBoard, IndexEntry, schemas
from gym_extensions.site.leaderboard import Leaderboard
from gym_extensions.site.page import Draft, File, Page, Render
from gym_extensions.site.tables.board_csv import board_csv
from gym_extensions.site.views.board import Board
from gym_extensions.site.views.group import Group, groups

PATH = "data.html"


def publish_entry(entry: Scorecard, render: Render) -> Iterator[File]:
    """The scorecard of a submission, as ``score --json`` prints it."""
    document = ScorecardDocument(references=render.site.references, submissions=(entry,))
    yield entry_data(entry.name), Draft(render.inputs, document.to_json)


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """The page that lists the data, the index, boards, groups and schemas."""
    members = groups(site.boards, site.entrants, site.references)
    boards = {board.id: _index_board(board) for board in site.boards}
    yield PATH, render("data.html", PATH)
    entries = tuple(
        IndexEntry(entry.name, entry.title, entry.trust, entry_data(entry.name), entry_path(entry.name))
        for entry in site.entries
    )
    paths = {group.id: group_data(group.id) for group in members}
    index = Index(references=site.references, entries=entries, boards=tuple(boards.values()), groups=paths)
    yield "api/index.json", index.to_json()
    scored = {(row.group, row.protocol, row.budget, row.task_conditioned): row for row in site.scored.boards}
    for board in site.boards:
        document = scored[board.group, board.protocol, board.budget, board.task_conditioned]
        yield board_data(board.id), BoardsDocument(boards=(document,)).to_json()
        yield board_data(board.id, "csv"), board_csv(board)
    for group in members:
        yield group_data(group.id), _group(group, site, boards).to_json()
    for name, text in {**schema_texts(), **schemas()}.items():
        yield f"schemas/{name}", text


def _index_board(board: Board) -> IndexBoard:
    return IndexBoard(
        board.id,
        board.group,
        board.protocol,
        board.budget,
        board.task_conditioned,
        len(board.rows),
        board_data(board.id),
        board_path(board.id),
    )


def _group(group: Group, site: Leaderboard, boards: dict[str, IndexBoard]) -> GroupDocument:
    measured = {
        row.task: ReferenceValue(row.measured.floor, row.measured.ceiling, row.measured.is_unsolved)
        for row in group.tasks
        if row.measured
    }
    used = next(
        (trial.detail.reference for board in group.boards for trial in board.trials if trial.detail), {}
    )
    return GroupDocument(
        id=group.id,
        references=site.references,
        tasks=tuple(row.task for row in group.tasks),
        groups=group.members,
        reference=used or measured,
        boards=tuple(boards[board.id] for board in group.boards),
    )


PAGE = Page(title="Data", order=60, path=PATH, publish=publish, publish_entry=publish_entry, in_footer=True)
