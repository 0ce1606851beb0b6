"""The JSON Schemas of the published documents."""

from __future__ import annotations

import json
from typing import Any

import msgspec

from gym_extensions.catalog.protocol import REPORTS
from gym_extensions.documents import DIALECT, json_schema
from gym_extensions.scoring.ranking.boards import BoardsDocument
from gym_extensions.scoring.scorecard import ScorecardDocument
from gym_extensions.submissions.layout import MANIFEST
from gym_extensions.submissions.manifest import Manifest
from gym_extensions.submissions.poses import Poses

Schema = dict[str, Any]


def submission_schema() -> Schema:
    """The schema of submission.toml read as JSON, in which sections are objects."""
    schema = msgspec.json.schema(Manifest)
    parts = schema["$defs"]
    for part in parts.values():
        part["additionalProperties"] = False
    parts["Observes"]["required"] = sorted(parts["Observes"]["properties"])
    manifest = parts["Manifest"]
    manifest["properties"]["reported"]["enum"] = list(REPORTS)
    manifest["required"] = sorted({*manifest["required"], "format"})
    manifest |= {"if": {"not": {"required": ["reported"]}}, "then": {"required": ["tuning"]}}
    return {"$schema": DIALECT, "title": MANIFEST, **schema}


def schema_texts(**others: type) -> dict[str, str]:
    """Every published schema, and those of other documents by their names, as JSON by its file's name."""
    documents = {"scorecard": ScorecardDocument, "boards": BoardsDocument, "poses": Poses} | others
    schemas = {"submission.json": submission_schema()}
    schemas |= {f"{name}.json": json_schema(document) for name, document in documents.items()}
    return {
        name: json.dumps(schema, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
        for name, schema in schemas.items()
    }
