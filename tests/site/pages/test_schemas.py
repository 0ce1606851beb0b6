"""The published JSON Schemas."""

import json
import tomllib
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator, ValidationError

from gym_extensions.scoring.pipeline import score_folders
from gym_extensions.scoring.ranking.group_board import boards
from gym_extensions.scoring.scorecard import ScorecardDocument
from gym_extensions.site.pages.data import schema_texts

ROOT = Path(__file__).parents[3]
SUBMISSIONS = sorted(path.parent for path in ROOT.glob("submissions/*/submission.toml"))
Json = dict[str, Any]
SCHEMAS: dict[str, Json] = {name: json.loads(text) for name, text in schema_texts().items()}


SCORED = [path for path in SUBMISSIONS if path.name in ("henderson2017-trpo", "multi-head")]
"""Submissions with and without every protocol, joint runs, policies and rows; scoring all takes seconds."""


def check(name: str, document: Json) -> None:
    """Raises ValidationError where a document does not follow its schema."""
    Draft202012Validator(SCHEMAS[name]).validate(document)


@pytest.fixture(scope="module")
def document() -> ScorecardDocument:
    return score_folders(SCORED)


@pytest.fixture(scope="module")
def scorecards(document: ScorecardDocument) -> Json:
    parsed: Json = json.loads(document.to_json())
    return parsed


def manifest(folder: Path) -> Json:
    return tomllib.loads((folder / "submission.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("schema", SCHEMAS.values(), ids=SCHEMAS)
def test_a_schema_is_a_valid_schema(schema: Json) -> None:
    Draft202012Validator.check_schema(schema)


@pytest.mark.committed
@pytest.mark.parametrize("folder", SUBMISSIONS, ids=lambda folder: folder.name)
def test_the_committed_manifests_follow_the_schema(folder: Path) -> None:
    check("submission.json", manifest(folder))


@pytest.mark.committed
def test_scorecards_and_boards_of_committed_submissions_follow_the_schemas(
    document: ScorecardDocument, scorecards: Json
) -> None:
    assert len(scorecards["submissions"]) == len(SCORED) == 2
    check("scorecard.json", scorecards)
    boards_json = json.loads(boards(document.submissions).to_json())
    assert boards_json["boards"]
    check("boards.json", boards_json)


BROKEN: dict[str, Callable[[Json], object]] = {
    "no title": lambda manifest: manifest.pop("title"),
    "misspelled key": lambda manifest: manifest["protocol"].update(algoritm="trpo"),
    "unknown budget": lambda manifest: manifest["protocol"].update(budget="2M"),
    "negative count": lambda manifest: manifest["tuning"].update(steps=-1),
    "count that is true": lambda manifest: manifest["tuning"].update(steps=True),
    "no tuning": lambda manifest: manifest.pop("tuning"),
    "address of a file": lambda manifest: manifest["code"].update(url="file:///etc"),
    "nested hyperparameter": lambda manifest: manifest["hyperparameters"].update(layers=[[100]]),
}


@pytest.mark.committed
@pytest.mark.parametrize("change", BROKEN)
def test_a_broken_manifest_is_refused(change: str) -> None:
    broken = manifest(ROOT / "submissions" / "trpo-2017")
    BROKEN[change](broken)
    with pytest.raises(ValidationError):
        check("submission.json", broken)


@pytest.mark.committed
def test_a_reported_manifest_may_lack_what_only_logs_need() -> None:
    reported = manifest(ROOT / "submissions" / "henderson2017-trpo")
    assert "tuning" not in reported
    with pytest.raises(ValidationError, match="'tuning' is a required property"):
        check("submission.json", {key: value for key, value in reported.items() if key != "reported"})


@pytest.mark.committed
@pytest.mark.parametrize("key", ["name", "why", "extra"])
def test_a_broken_scorecard_is_refused(scorecards: Json, key: str) -> None:
    broken = deepcopy(scorecards)
    card = next(card for card in broken["submissions"] if card["name"] == "multi-head")
    metric = card["groups"]["hopper-gravity-v0"]["sequential"]["metrics"]["forgetting"]
    if key == "name":
        card["name"] = 7
    elif key == "why":
        del metric["why"]
    else:
        metric["extra"] = 1.0
    with pytest.raises(ValidationError, match=f"'{key}'|7 is not of type"):
        check("scorecard.json", broken)
