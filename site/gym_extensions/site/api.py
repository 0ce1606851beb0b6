"""The documents of ``api/`` that are not the scorer's: the index, and one per group or suite."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Annotated, Literal

from gym_extensions.scoring.documents import JsonDocument, about, json_schema
from gym_extensions.scoring.scorecard.model import ReferencesInfo, ReferenceValue


@dataclass(frozen=True, slots=True)
class IndexEntry:
    """A submission."""

    name: Annotated[str, about("name of its folder")]
    title: Annotated[str, about("its title")]
    trust: Annotated[str | None, about("its level of trust; null if it was refused")]
    path: Annotated[str, about("path of its scorecard, a document of schemas/scorecard.json")]
    page: Annotated[str, about("path of its page")]


@dataclass(frozen=True, slots=True)
class IndexBoard:
    """A board."""

    id: Annotated[str, about("its name")]
    group: Annotated[str, about("group id or suite name")]
    protocol: Annotated[str, about("`sequential`, `single` or `joint`")]
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
    groups: Annotated[dict[str, str], about("path of each group's or suite's document, by its id")]


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupDocument(JsonDocument):
    """A group or suite."""

    format: Annotated[Literal[1], about("1")] = 1
    id: Annotated[str, about("group id or suite name")]
    references: ReferencesInfo
    tasks: Annotated[tuple[str, ...], about("task ids in training order; empty for a suite")]
    groups: Annotated[tuple[str, ...], about("group ids of a suite; empty for a group")]
    reference: Annotated[dict[str, ReferenceValue], about("floor and ceiling by task id")]
    boards: Annotated[tuple[IndexBoard, ...], about("its boards")]


def schemas() -> dict[str, str]:
    """The JSON Schemas of these documents by file name."""
    documents = {"index.json": Index, "group.json": GroupDocument}
    return {
        name: json.dumps(json_schema(document), indent=1, sort_keys=True, ensure_ascii=False) + "\n"
        for name, document in documents.items()
    }
