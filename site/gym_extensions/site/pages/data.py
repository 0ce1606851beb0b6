"""The page Data, and the documents of ``api/``: those of the scorer, an index, and one per group."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from inspect import cleandoc
from typing import Annotated, Literal

import msgspec

from gym_extensions.catalog.protocol import REPORTS
from gym_extensions.documents import DIALECT, JsonDocument, about, filled, json_schema
from gym_extensions.metrics.values import Estimate
from gym_extensions.scoring.group_score import ReferenceValue
from gym_extensions.scoring.output.board_frames import board_frame, to_csv
from gym_extensions.scoring.ranking.boards import BoardsDocument
from gym_extensions.scoring.scorecard import ReferencesInfo, Scorecard, ScorecardDocument
from gym_extensions.site import board_views, paths
from gym_extensions.site.pages.page import File, Render
from gym_extensions.submissions import layout, poses, review
from gym_extensions.submissions.manifest import Manifest


@dataclass(frozen=True, slots=True)
class IndexRow:
    """A submission."""

    name: Annotated[str, about("name of its folder")]
    title: Annotated[str, about("its title")]
    level: Annotated[review.Level | None, about("its level; null if it was refused")]
    path: Annotated[str, about("path of its scorecard, a document of schemas/scorecard.json")]
    summary: Annotated[str, about("path of its scores alone, a document of schemas/summary.json")]
    page: Annotated[str, about("path of its page")]


@dataclass(frozen=True, slots=True)
class SmallScore:
    """Scores on a group or suite."""

    budget: Annotated[str, about("name of the budget")]
    runs: Annotated[int, about("number of runs; 0 for a suite")]
    metrics: Annotated[dict[str, Estimate], about("every metric with a value, by name")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary(JsonDocument):
    """The scores of a submission, without runs, curves and matrices, which its scorecard has."""

    format: Annotated[Literal[1], about("1")] = 1
    references: ReferencesInfo
    name: Annotated[str, about("name of its folder")]
    title: Annotated[str, about("its title")]
    level: Annotated[review.Level | None, about("its level; null if it was refused")]
    accepted: Annotated[str, about("date of its acceptance, YYYY-MM-DD; empty without one")]
    core: Annotated[dict[str, Estimate], about("every metric of the core with a value, by name")]
    groups: Annotated[dict[str, dict[str, SmallScore]], about("scores by group or suite and protocol")]
    path: Annotated[str, about("path of its scorecard")]


@dataclass(frozen=True, slots=True)
class IndexBoard:
    """A board."""

    id: Annotated[str, about("its name")]
    group: Annotated[str, about("group id or suite name")]
    protocol: Annotated[str, about("`sequential`, `single` or another one")]
    budget: Annotated[str, about("name of the budget")]
    task_conditioned: Annotated[bool, about("whether its agents observe the task in evaluation")]
    submissions: Annotated[int, about("number of its submissions")]
    path: Annotated[str, about("path of the board, a document of schemas/boards.json with one board")]
    page: Annotated[str, about("path of its page")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Index(JsonDocument):
    """What ``api/`` contains. Paths are relative to the root of the site."""

    format: Annotated[Literal[1], about("1")] = 1
    references: ReferencesInfo
    submissions: Annotated[tuple[IndexRow, ...], about("submissions, sorted by name")]
    boards: Annotated[tuple[IndexBoard, ...], about("boards")]
    core: Annotated[str, about("path of the core board, a document of schemas/boards.json")]
    best: Annotated[str, about("path of the best submissions by task, a document of schemas/boards.json")]
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


def publish_submission(submission: Scorecard, render: Render) -> Iterator[File]:
    """The scorecard of a submission, as ``score --json`` prints it, and its scores alone."""
    info = ReferencesInfo.of(render.references)
    path = paths.submission_data(submission.name)
    yield path, ScorecardDocument(references=info, submissions=(submission,)).to_json()

    def known(metrics: Mapping[str, Estimate]) -> dict[str, Estimate]:
        """The metrics with a value, with their intervals alone."""
        found = {name: each for name, each in metrics.items() if each.mean is not None}
        return {name: Estimate(each.mean, each.low, each.high) for name, each in found.items()}

    on_groups: dict[str, dict[str, SmallScore]] = {}
    for name, protocol, score in submission.scores():
        runs = len(getattr(score, "runs", ()))
        on_groups.setdefault(name, {})[protocol] = SmallScore(score.budget, runs, known(score.metrics))
    core = known(submission.core.metrics) if submission.core else {}
    own = {"format": 1, "references": info, "core": core, "groups": on_groups, "path": path}
    yield paths.summary_data(submission.name), filled(Summary, submission, **own).to_json()


def publish(site: board_views.Leaderboard, render: Render) -> Iterator[File]:
    """The page that lists the data, the index, boards, groups and schemas."""
    info, known = ReferencesInfo.of(site.references), site.references.tasks
    submissions, boards = list[IndexRow](), dict[str, IndexBoard]()
    for card in site.submissions:
        path, page = paths.submission_data(card.name), paths.submission_path(card.name)
        small = paths.summary_data(card.name)
        submissions.append(IndexRow(card.name, card.title, card.level, path, small, page))
    for board in site.boards:
        facts = (board.group, board.protocol, board.budget, board.task_conditioned, len(board.rows))
        path, page = paths.board_data(board.id), paths.board_path(board.id)
        boards[board.id] = IndexBoard(board.id, *facts, path, page)
    yield "data.html", render("data.html", "data.html")
    index = Index(
        references=info,
        submissions=tuple(submissions),
        boards=tuple(boards.values()),
        core=paths.CORE_DATA,
        best=paths.BEST_DATA,
        groups={group.id: paths.group_data(group.id) for group in site.groups},
    )
    yield paths.INDEX_DATA, index.to_json()
    yield paths.CORE_DATA, BoardsDocument(core=site.scored.core, boards=()).to_json()
    yield paths.BEST_DATA, BoardsDocument(boards=(), best=site.scored.best).to_json()
    for board in site.boards:
        yield paths.board_data(board.id), BoardsDocument(boards=(board.scored,)).to_json()
        yield paths.board_data(board.id, "csv"), to_csv(board_frame(board.scored))
    for group in site.groups:
        document = GroupDocument(
            id=group.id,
            references=info,
            tasks=group.tasks,
            groups=group.members,
            reference={task: ReferenceValue.of(known.get(task)) for task in group.tasks},
            boards=tuple(boards[board.id] for board in group.boards),
        )
        yield paths.group_data(group.id), document.to_json()
    for name, text in schema_texts().items():
        yield f"schemas/{name}", text


DOCUMENTS: dict[str, type[JsonDocument]] = {
    "scorecard": ScorecardDocument,
    "summary": Summary,
    "boards": BoardsDocument,
    "poses": poses.Poses,
    "index": Index,
    "group": GroupDocument,
}
"""The published documents by the name of their schema."""


def schema_texts() -> dict[str, str]:
    """The JSON Schema of every document, and of submission.toml read as JSON, by its file's name."""
    schemas = {"submission": msgspec.json.schema(Manifest)}
    parts = schemas["submission"]["$defs"]
    for part in parts.values():
        part |= {"additionalProperties": False, "description": cleandoc(part.get("description", ""))}
    parts["Observes"]["required"] = sorted(parts["Observes"]["properties"])
    manifest = parts["Manifest"]
    manifest["properties"]["reported"]["enum"] = list(REPORTS)
    manifest["required"] = sorted({*manifest["required"], "format"})
    manifest |= {"if": {"not": {"required": ["reported"]}}, "then": {"required": ["tuning"]}}
    schemas["submission"] |= {"$schema": DIALECT, "title": layout.MANIFEST}
    schemas |= {name: json_schema(document) for name, document in DOCUMENTS.items()}
    return {
        f"{name}.json": json.dumps(schema, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
        for name, schema in schemas.items()
    }
