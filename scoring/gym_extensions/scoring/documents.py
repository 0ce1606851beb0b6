"""Writes the published documents as JSON from their types, and reads them back strictly."""

from __future__ import annotations

import json
from typing import Any, Self

import msgspec

DIALECT = "https://json-schema.org/draft/2020-12/schema"
INDENT = 1


def about(description: str) -> msgspec.Meta:
    """The description of a field, for the JSON Schema and the tables of docs/scorecard.md."""
    return msgspec.Meta(description=description)


class JsonDocument:
    """Base of the dataclasses that are written as a JSON document of their own.

    They and all dataclasses in them have ``slots=True``: without slots, msgspec leaves out of a document the
    fields that were absent where it was read.
    """

    __slots__ = ()

    def to_json(self) -> str:
        """The document as JSON with sorted keys, floats by ``repr``, indentation and one newline at the end.

        Raises:
            ValueError: a number is not finite.
        """
        values = msgspec.to_builtins(self)
        # msgspec writes null for NaN and infinity; json refuses them.
        compact = json.dumps(values, sort_keys=True, ensure_ascii=False, allow_nan=False)
        return msgspec.json.format(compact, indent=INDENT) + "\n"

    @classmethod
    def from_json(cls, text: str | bytes) -> Self:
        """The document of a JSON text.

        Keys that this version does not know are ignored.

        Raises:
            msgspec.ValidationError: a value has another type or is missing; the message names its path.
            msgspec.DecodeError: the text is not JSON. Both are kinds of ValueError.
        """
        return msgspec.json.decode(text, type=cls)


def json_schema(document: type[JsonDocument]) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a document, with every key required and no other allowed."""
    schema = msgspec.json.schema(document)
    for part in schema["$defs"].values():
        for field in part["properties"].values():
            field.pop("default", None)
        part |= {"required": sorted(part["properties"]), "additionalProperties": False}
    return {"$schema": DIALECT, **schema}
