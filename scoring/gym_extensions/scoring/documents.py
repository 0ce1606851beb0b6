"""Writes the published documents as JSON from their types, and reads them back strictly."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Self

import msgspec

from gym_extensions.errors import BenchError

DIALECT = "https://json-schema.org/draft/2020-12/schema"
INDENT = 1
NOT_AS_REPR = re.compile(rb"(?<![\d.])-?(?:\d[\d.]*e-?\d+|0\.0000\d+)")
"""A number that msgspec writes otherwise than ``repr``: 1e16 for 1e+16, 0.00001 for 1e-05."""
NOT_FINITE = re.compile(rb"\xcb[\x7f\xff][\xf0-\xff]")
"""In MessagePack, the start of NaN or infinity; some other values have it, too."""


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
        compact = _compact(self)
        if compact is None:
            values = msgspec.to_builtins(self)
            compact = json.dumps(values, sort_keys=True, ensure_ascii=False, allow_nan=False).encode()
        return msgspec.json.format(compact, indent=INDENT).decode() + "\n"

    @classmethod
    def from_json(cls, text: str | bytes) -> Self:
        """The document of a JSON text.

        Keys that this version does not know are ignored.

        Raises:
            msgspec.ValidationError: a value has another type or is missing; the message names its path.
            msgspec.DecodeError: the text is not JSON. Both are kinds of ValueError.
        """
        return msgspec.json.decode(text, type=cls)

    @classmethod
    def load(cls, path: Path, code: str, command: str) -> Self | None:
        """The document of a file, or None if the file does not exist.

        Args:
            path: the file.
            code: of the error.
            command: what writes the file, for the error message.

        Raises:
            BenchError: the file cannot be read, or its content is not a document of this type.
        """
        try:
            return cls.from_json(path.read_bytes())
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            hint = f"Write it again with `{command}`."
            raise BenchError(code, f"It cannot be read: {error}.", str(path), hint) from error


def _compact(document: JsonDocument) -> bytes | None:
    """The document by msgspec, several times as fast as by json; None where this is not possible."""
    try:
        packed = msgspec.msgpack.encode(document)
    except OverflowError:  # a whole number of more than 64 bits
        return None
    text = msgspec.json.encode(document, order="sorted")
    # msgspec writes null for NaN and infinity. Without escaped quotes, every second part is outside of texts.
    if NOT_FINITE.search(packed) or b'\\"' in text:
        return None
    parts = text.split(b'"')
    gaps = parts[::2]
    # Large boards have a million gaps, and most are the same comma.
    changed = {
        gap: NOT_AS_REPR.sub(lambda number: repr(float(number[0])).encode(), gap)
        for gap in set(gaps)
        if b"e" in gap or b"0.0000" in gap
    }
    parts[::2] = map(changed.get, gaps, gaps)
    return b'"'.join(parts)


def json_schema(document: type[JsonDocument]) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a document, with every key required and no other allowed."""
    schema = msgspec.json.schema(document)
    for part in schema["$defs"].values():
        for field in part["properties"].values():
            field.pop("default", None)
        part |= {"required": sorted(part["properties"]), "additionalProperties": False}
    return {"$schema": DIALECT, **schema}
