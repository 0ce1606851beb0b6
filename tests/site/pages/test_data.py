"""The data of the site: one document per submission, board and group, an index, and their schemas."""

import csv
import io
import json
from typing import Any

import msgspec
import pytest
from jsonschema import Draft202012Validator

from gym_extensions.references import load_references
from gym_extensions.scoring.group_score import ReferenceValue
from gym_extensions.scoring.scorecard import ScorecardDocument

from ..browser import files, typed
from ..conftest import scores_of

BOARD = "hopper-gravity-v0-sequential-100k"


@pytest.fixture
def written(document: dict[str, Any]) -> dict[str, str]:
    """Every file of the site."""
    return dict(files(document))


def test_the_document_of_a_submission_is_its_scorecard(
    document: dict[str, Any], written: dict[str, str]
) -> None:
    whole = typed(document)
    for card in whole.submissions:
        submission = ScorecardDocument.from_json(written[f"api/submissions/{card.name}.json"])
        assert submission == ScorecardDocument(references=whole.references, submissions=(card,))


def test_a_summary_has_the_scores_of_a_submission_and_nothing_else(written: dict[str, str]) -> None:
    whole = json.loads(written["api/submissions/keeper.json"])["submissions"][0]
    small = json.loads(written["api/summaries/keeper.json"])
    score = whole["groups"]["hopper-gravity-v0"]["sequential"]["metrics"]["final_performance"]
    shown = small["groups"]["hopper-gravity-v0"]["sequential"]
    assert shown["metrics"]["final_performance"] == {name: score[name] for name in ("mean", "low", "high")}
    assert shown["runs"] == 2
    assert "asymptotic_transfer" not in shown["metrics"], "it has no value"
    assert small["path"] == "api/submissions/keeper.json"
    assert len(written["api/summaries/keeper.json"]) < len(written["api/submissions/keeper.json"]) / 3


def test_the_index_leads_to_every_document_and_page(written: dict[str, str]) -> None:
    index = json.loads(written["api/index.json"])
    paths = [row[key] for row in index["submissions"] for key in ("path", "page", "summary")]
    paths += [row[key] for row in index["boards"] for key in ("path", "page")]
    assert {*paths, index["core"], *index["groups"].values()} <= set(written)
    assert len(paths) > 15
    assert len(index["groups"]) > 30


def test_every_document_satisfies_its_published_schema(written: dict[str, str]) -> None:
    kinds = {"submissions": "scorecard", "summaries": "summary", "boards": "boards", "groups": "group"}
    for folder, name in {**kinds, "index.json": "index"}.items():
        schema = Draft202012Validator(json.loads(written[f"schemas/{name}.json"]))
        paths = [path for path in written if path.startswith(f"api/{folder}") and path.endswith(".json")]
        assert paths
        for path in paths:
            schema.validate(json.loads(written[path]))


def test_the_csv_of_a_board_has_a_row_per_submission(document: dict[str, Any]) -> None:
    document["submissions"][0]["title"] = "=HYPERLINK(1)"
    rows = list(csv.DictReader(io.StringIO(dict(files(document))[f"api/boards/{BOARD}.csv"])))
    assert [row["name"] for row in rows] == ["agile", "keeper", "zero"]
    metrics = scores_of(document)["metrics"]
    assert float(rows[0]["forgetting"]) == metrics["forgetting"]["mean"]
    assert (rows[0]["title"], rows[0]["ranked"], rows[1]["ranked"]) == ("'=HYPERLINK(1)", "True", "False")


def test_the_document_of_a_group_that_nobody_entered_has_floors_and_experts(document: dict[str, Any]) -> None:
    current = load_references()
    document["references"] = {"version": current.version, "sha256": current.digest}
    written = dict(files(document))
    for name, is_open in {"striker": True, "pusher": False}.items():
        found = json.loads(written[f"api/groups/{name}-v0.json"])["reference"]
        for task, reference in found.items():
            assert reference == msgspec.to_builtins(ReferenceValue.of(current.tasks[task]))
            assert reference["open"] is is_open
