"""The paths of pages and data, and the documents of ``api/`` that are not the scorer's.

A path depends on a name alone, so that a new entry moves no page. Paths are relative to the root of the site.
"""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import dataclass
from typing import Annotated, Literal

from gym_extensions.rollouts.review import Level
from gym_extensions.scoring.documents import JsonDocument, about, json_schema
from gym_extensions.scoring.scorecard import ReferencesInfo, ReferenceValue, Scorecard
from gym_extensions.site.boards import Board, Leaderboard

MAX_SLUG = 80


def slug(name: str) -> str:
    """A file name without suffix, safe in file systems and URLs: ``[a-z0-9_-]``, at most 93 characters.

    Different names have different slugs, even where case is ignored: a name that has to change gets its
    digest behind an underscore, which no unchanged name contains.
    """
    plain = re.sub(r"[^a-z0-9-]+", "-", name.lower()).strip("-")[:MAX_SLUG]
    if plain == name:
        return plain
    return f"{plain}_{hashlib.sha256(name.encode('utf-8', 'surrogatepass')).hexdigest()[:12]}"


def entry_path(name: str) -> str:
    """The page of a submission, by the name of its folder."""
    return f"submissions/{slug(name)}.html"


def results_path(name: str, group_id: str) -> str:
    """The results of a submission on one group, where they are not on its own page."""
    return f"submissions/{slug(name)}/{slug(group_id)}.html"


def group_path(group_id: str) -> str:
    """The page of a group or suite, for example ``groups/hopper-gravity-v0.html``."""
    return f"groups/{slug(group_id)}.html"


def task_path(task_id: str) -> str:
    """The page of a task, for example ``tasks/hopperwall-v0.html``. The namespace is not part of it."""
    return f"tasks/{slug(task_id.rsplit('/', maxsplit=1)[-1].lower())}.html"


def board_path(board_id: str, page: int = 1) -> str:
    """A page of the table of all rows of a board, from 1."""
    return f"boards/{slug(board_id.lower())}{f'-{page}' if page > 1 else ''}.html"


def board_tab(board: Board) -> str:
    """The board on the page of its group."""
    return f"{group_path(board.group)}#{board.id}"


def entry_data(name: str) -> str:
    """The scorecard of a submission."""
    return f"api/entries/{slug(name)}.json"


def board_data(board_id: str, suffix: str = "json") -> str:
    """A board as JSON, its table as ``csv``, or the differences of its entries as ``pairs.js``."""
    return f"api/boards/{slug(board_id.lower())}.{suffix}"


CORE_DATA = "api/core.json"
"""The core board."""


COMPARED = "api/compare.js"
"""What the page Compare loads: entries, the boards that they are on, and the pairs of the core."""


def compared(site: Leaderboard) -> str:
    """The content of that file, a script, because pages that are opened as files cannot read JSON."""
    boards = [
        {
            "group": board.group,
            "label": f"{board.protocol}, {board.budget}{', task label' if board.task_conditioned else ''}",
            "page": board_tab(board),
            "pairs": board_data(board.id, "pairs.js"),
            "id": board.id,
            "entries": [row.entry.name for row in board.rows],
        }
        for board in site.boards
        if len(board.rows) > 1
    ]
    board = site.scored.core
    pairs = {
        metric: [[p.first, p.second, p.mean, p.low, p.high, p.p_value, p.verdict, p.look] for p in found]
        for metric, found in (board.pairs if board else {}).items()
    }
    names = {name for each in boards for name in each["entries"]}
    titles = {entry.name: entry.title for entry in site.entries if entry.name in names}
    groups = {
        entry.name: {group: [value.mean, value.low, value.high] for group, value in entry.groups.items()}
        for entry in (board.rows if board else ())
    }
    document = {"titles": titles, "boards": boards, "core": pairs, "groups": groups}
    return f"compareIndex({json.dumps(document, separators=(',', ':'))});\n"


def group_data(group_id: str) -> str:
    """A group or suite with its tasks and boards."""
    return f"api/groups/{slug(group_id)}.json"


def entry_file(name: str, file: str) -> str:
    """A file that belongs to the page of a submission, by the names of its folder and of the file."""
    return f"submissions/{slug(name)}/{file}"


@dataclass(frozen=True, slots=True)
class IndexEntry:
    """A submission."""

    name: Annotated[str, about("name of its folder")]
    title: Annotated[str, about("its title")]
    level: Annotated[Level | None, about("its level; null if it was refused")]
    path: Annotated[str, about("path of its scorecard, a document of schemas/scorecard.json")]
    page: Annotated[str, about("path of its page")]


@dataclass(frozen=True, slots=True)
class IndexBoard:
    """A board."""

    id: Annotated[str, about("its name")]
    group: Annotated[str, about("group id or suite name")]
    protocol: Annotated[str, about("`sequential`, `single`, `joint` or `cumulative`")]
    budget: Annotated[str, about("name of the budget")]
    task_conditioned: Annotated[bool, about("whether its agents observe the task in evaluation")]
    entries: Annotated[int, about("number of its entries")]
    path: Annotated[str, about("path of the board, a document of schemas/boards.json with one board")]
    page: Annotated[str, about("path of its page")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Index(JsonDocument):
    """What ``api/`` contains. Paths are relative to the root of the site."""

    format: Annotated[Literal[1], about("1")] = 1
    references: ReferencesInfo
    entries: Annotated[tuple[IndexEntry, ...], about("submissions, sorted by name")]
    boards: Annotated[tuple[IndexBoard, ...], about("boards")]
    core: Annotated[str, about("path of the core board, a document of schemas/boards.json")]
    groups: Annotated[dict[str, str], about("path of each group's or suite's document, by its id")]


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupDocument(JsonDocument):
    """A group or suite."""

    format: Annotated[Literal[1], about("1")] = 1
    id: Annotated[str, about("group id or suite name")]
    references: ReferencesInfo
    tasks: Annotated[tuple[str, ...], about("task ids in training order; empty for a suite")]
    groups: Annotated[tuple[str, ...], about("group ids of a suite; empty for a group")]
    reference: Annotated[dict[str, ReferenceValue], about("floor and expert by task id")]
    boards: Annotated[tuple[IndexBoard, ...], about("its boards")]


def schemas() -> dict[str, str]:
    """The JSON Schemas of these documents by file name."""
    documents = {"index.json": Index, "group.json": GroupDocument}
    return {
        name: json.dumps(json_schema(document), indent=1, sort_keys=True, ensure_ascii=False) + "\n"
        for name, document in documents.items()
    }


def index_entry(card: Scorecard) -> IndexEntry:
    """A submission in the index."""
    return IndexEntry(card.name, card.title, card.level, entry_data(card.name), entry_path(card.name))


def index_board(board: Board) -> IndexBoard:
    """A board in the index."""
    facts = (board.group, board.protocol, board.budget, board.task_conditioned)
    return IndexBoard(board.id, *facts, len(board.rows), board_data(board.id), board_path(board.id))
