"""The JSON Schemas of the submission manifest, the scorecards and the boards, from their types."""

from __future__ import annotations

import json
from typing import Any

from gym_extensions.catalog.published import TABLES
from gym_extensions.rollouts import manifest
from gym_extensions.rollouts import manifest_values as values
from gym_extensions.scoring.documents import DIALECT, json_schema
from gym_extensions.scoring.leaderboard.model import BoardsDocument
from gym_extensions.scoring.poses.model import Poses
from gym_extensions.scoring.scorecard.model import ScorecardDocument

Schema = dict[str, Any]

KINDS: dict[str, Schema] = {
    values.TEXT: {"type": "string"},
    values.COUNT: {"type": "integer", "minimum": 0, "maximum": 2**53 - 1},
    values.FLAG: {"type": "boolean"},
    values.URL: {"type": "string", "pattern": "^(https?://.+)?$"},
    values.NAMES: {
        "type": "array",
        "maxItems": values.SHORT,
        "items": {"type": "string", "minLength": 1},
    },
    values.DIGEST: {"type": "string", "pattern": "^([0-9a-f]{64})?$"},
}
"""The schema of each kind of manifest value."""

SCALARS: list[Schema] = [
    {"type": "string", "maxLength": values.LONG},
    {"type": "number"},
    {"type": "boolean"},
]
HYPERPARAMETERS: Schema = {
    "type": "object",
    "additionalProperties": {
        "anyOf": [*SCALARS, {"type": "array", "maxItems": values.SHORT, "items": {"anyOf": SCALARS}}]
    },
}

VERSIONS: Schema = {
    "type": "object",
    "additionalProperties": KINDS[values.TEXT] | {"maxLength": values.SHORT},
}
FREE: dict[str, Schema] = {manifest.HYPERPARAMETERS: HYPERPARAMETERS, manifest.PACKAGES: VERSIONS}
"""The schemas of the sections with free keys."""


def _field(field: values.Key) -> Schema:
    schema = dict(KINDS[field.kind])
    if schema["type"] == "string":
        schema["maxLength"] = field.max_length
    return schema | ({"enum": list(field.choices)} if field.choices else {})


def _section(fields: dict[str, values.Key]) -> Schema:
    return {
        "type": "object",
        "properties": {name: _field(field) for name, field in fields.items()},
        "required": sorted(name for name, field in fields.items() if field.required),
        "additionalProperties": False,
    }


def submission_schema() -> Schema:
    """The schema of submission.toml read as JSON, in which sections are objects."""
    top, *names = manifest.SECTIONS
    schema = _section(manifest.SECTIONS[top])
    schema["properties"]["reported"]["enum"] = list(TABLES)
    for name in names:
        schema["properties"][name] = FREE.get(name) or _section(manifest.SECTIONS[name])
    required = [name for name in names if name not in manifest.OPTIONAL_SECTIONS]
    always = [name for name in required if name not in manifest.OPTIONAL_IF_REPORTED]
    schema["required"] += always
    with_logs = {"required": list(manifest.OPTIONAL_IF_REPORTED)}
    condition = {"if": {"not": {"required": ["reported"]}}, "then": with_logs}
    return {"$schema": DIALECT, "title": "submission.toml", **schema, **condition}


def schemas() -> dict[str, Schema]:
    """Every published schema by its file's name."""
    return {
        "submission.json": submission_schema(),
        "scorecard.json": json_schema(ScorecardDocument),
        "boards.json": json_schema(BoardsDocument),
        "poses.json": json_schema(Poses),
    }


def schema_texts() -> dict[str, str]:
    """Every published schema as JSON by its file's name."""
    return {
        name: json.dumps(schema, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
        for name, schema in schemas().items()
    }
