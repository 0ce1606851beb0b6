"""The published JSON Schemas accept the committed submissions and refuse broken documents."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator, ValidationError

from gym_extensions.scoring.leaderboard.board import boards
from gym_extensions.scoring.output.schema import schema_texts, schemas
from gym_extensions.scoring.pipeline.score import score_folders
from gym_extensions.scoring.scorecard.model import ScorecardDocument

ROOT = Path(__file__).parents[3]
SUBMISSIONS = sorted(path.parent for path in ROOT.glob("submissions/*/submission.toml"))
Json = dict[str, Any]


SCORED = [path for path in SUBMISSIONS if path.name in ("henderson2017-trpo", "multi-head", "random", "trpo")]
"""Entries with and without every protocol, joint runs, policies and rows; scoring all takes seconds."""


def check(name: str, document: Json) -> None:
    """Raises ValidationError where a document does not follow its schema."""
    Draft202012Validator(schemas()[name]).validate(document)


@pytest.fixture(scope="module")
def document() -> ScorecardDocument:
    return score_folders(SCORED)


@pytest.fixture(scope="module")
def scorecards(document: ScorecardDocument) -> Json:
    parsed: Json = json.loads(document.to_json())
    return parsed


@pytest.fixture(scope="module")
def boards_json(document: ScorecardDocument) -> Json:
    parsed: Json = json.loads(boards(document.submissions).to_json())
    return parsed


def manifest(folder: Path) -> Json:
    return tomllib.loads((folder / "submission.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", list(schemas()))
def test_a_schema_is_a_valid_schema(name: str) -> None:
    Draft202012Validator.check_schema(schemas()[name])
    assert json.loads(schema_texts()[name]) == schemas()[name]


@pytest.mark.parametrize("folder", SUBMISSIONS, ids=lambda folder: folder.name)
def test_the_committed_manifests_follow_the_schema(folder: Path) -> None:
    check("submission.json", manifest(folder))


def test_the_scorecards_of_the_committed_submissions_follow_the_schema(scorecards: Json) -> None:
    assert len(scorecards["submissions"]) == len(SCORED) == 4
    check("scorecard.json", scorecards)


def test_the_boards_of_the_committed_submissions_follow_the_schema(boards_json: Json) -> None:
    assert boards_json["boards"]
    check("boards.json", boards_json)


POSES = sorted(ROOT.glob("scoring/poses/*/*.json"))


def test_the_committed_poses_follow_the_schema() -> None:
    assert POSES
    for file in POSES:
        check("poses.json", json.loads(file.read_text(encoding="utf-8")))


@pytest.mark.parametrize(("key", "value"), [("run", "0"), ("format", 2), ("frames", 60)])
def test_broken_poses_are_refused(key: str, value: object) -> None:
    broken = json.loads(POSES[0].read_text(encoding="utf-8")) | {key: value}
    with pytest.raises(ValidationError):
        check("poses.json", broken)


def remove_title(manifest: Json) -> None:
    del manifest["title"]


def misspell_key(manifest: Json) -> None:
    manifest["protocol"]["algoritm"] = manifest["protocol"].pop("algorithm")


def unknown_budget(manifest: Json) -> None:
    manifest["protocol"]["budget"] = "2M"


def negative_count(manifest: Json) -> None:
    manifest["memory"]["stored_steps"] = -1


def count_that_is_true(manifest: Json) -> None:
    manifest["memory"]["stored_steps"] = True


def no_memory(manifest: Json) -> None:
    del manifest["memory"]


def file_address(manifest: Json) -> None:
    manifest["code"]["url"] = "file:///etc"


def nested_hyperparameter(manifest: Json) -> None:
    manifest["hyperparameters"] = {"layers": [[100]]}


@pytest.mark.parametrize(
    "change",
    [
        remove_title,
        misspell_key,
        unknown_budget,
        negative_count,
        count_that_is_true,
        no_memory,
        file_address,
        nested_hyperparameter,
    ],
)
def test_a_broken_manifest_is_refused(change: Callable[[Json], None]) -> None:
    broken = manifest(ROOT / "submissions" / "trpo-2017")
    change(broken)
    with pytest.raises(ValidationError):
        check("submission.json", broken)


def test_a_reported_manifest_may_lack_what_only_logs_need() -> None:
    reported = manifest(ROOT / "submissions" / "henderson2017-trpo")
    assert not {"tuning", "memory", "versions"} & set(reported)
    with pytest.raises(ValidationError, match="'tuning' is a required property"):
        check("submission.json", {key: value for key, value in reported.items() if key != "reported"})


@pytest.mark.parametrize("key", ["name", "why", "extra"])
def test_a_broken_scorecard_is_refused(scorecards: Json, key: str) -> None:
    broken = deepcopy(scorecards)
    card = next(card for card in broken["submissions"] if card["name"] == "random")
    metric = card["groups"]["hopper-gravity-v0"]["sequential"]["metrics"]["forgetting"]
    if key == "name":
        card["name"] = 7
    elif key == "why":
        del metric["why"]
    else:
        metric["extra"] = 1.0
    with pytest.raises(ValidationError, match=f"'{key}'|7 is not of type"):
        check("scorecard.json", broken)


def test_a_broken_board_is_refused(boards_json: Json) -> None:
    broken = deepcopy(boards_json)
    broken["boards"][0]["rows"][0]["metrics"]["final_performance"]["rank"] = [1]
    with pytest.raises(ValidationError):
        check("boards.json", broken)
