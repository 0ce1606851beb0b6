"""The published JSON Schemas."""

import json
import tomllib
from collections.abc import Callable
from inspect import cleandoc
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator, ValidationError

from gym_extensions.scoring.pipeline import score_folders
from gym_extensions.scoring.ranking.group_board import boards
from gym_extensions.site.pages.data import schema_texts

SUBMISSIONS = Path(__file__).parents[3] / "submissions"
Json = dict[str, Any]
SCHEMAS: dict[str, Json] = {name: json.loads(text) for name, text in schema_texts().items()}


def check(name: str, document: Json) -> None:
    """Raises ValidationError where a document does not follow its schema."""
    Draft202012Validator(SCHEMAS[name]).validate(document)


def manifest(name: str) -> Json:
    return tomllib.loads((SUBMISSIONS / name / "submission.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("schema", SCHEMAS.values(), ids=SCHEMAS)
def test_a_schema_is_a_valid_schema(schema: Json) -> None:
    Draft202012Validator.check_schema(schema)


@pytest.mark.parametrize("schema", SCHEMAS.values(), ids=SCHEMAS)
def test_a_schema_is_the_same_in_versions_of_python_that_indent_docstrings_or_not(schema: Json) -> None:
    texts = [part["description"] for part in schema["$defs"].values()]
    assert texts == list(map(cleandoc, texts))


@pytest.mark.committed
@pytest.mark.parametrize("name", sorted(path.parent.name for path in SUBMISSIONS.glob("*/submission.toml")))
def test_the_committed_manifests_follow_the_schema(name: str) -> None:
    check("submission.json", manifest(name))


@pytest.mark.committed
def test_scorecards_and_boards_of_committed_submissions_follow_the_schemas() -> None:
    """With and without every protocol, joint runs, policies and rows; scoring all takes seconds."""
    document = score_folders([SUBMISSIONS / name for name in ("henderson2017-trpo", "multi-head")])
    check("scorecard.json", json.loads(document.to_json()))
    scored = json.loads(boards(document.submissions).to_json())
    assert scored["boards"]
    check("boards.json", scored)


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
    broken = manifest("trpo-2017")
    BROKEN[change](broken)
    with pytest.raises(ValidationError):
        check("submission.json", broken)


@pytest.mark.committed
def test_a_reported_manifest_may_lack_what_only_logs_need() -> None:
    reported = manifest("henderson2017-trpo")
    assert "tuning" not in reported
    del reported["reported"]
    with pytest.raises(ValidationError, match="'tuning' is a required property"):
        check("submission.json", reported)
