"""Writes the published documents as JSON from their types, and reads them back strictly."""

import json
from dataclasses import fields
from inspect import cleandoc
from pathlib import Path
from typing import Any, Self, TypeVar

import msgspec

from gym_extensions.errors import BenchError
from gym_extensions.files import write_text

DIALECT = "https://json-schema.org/draft/2020-12/schema"
Document = TypeVar("Document")


def about(description: str) -> msgspec.Meta:
    """The description of a field, for the JSON Schema and the tables of docs/scorecard.md."""
    return msgspec.Meta(description=description)


def filled(document: type[Document], source: object, **own: object) -> Document:
    """A dataclass with these values of its own, and those of the source for all other fields."""
    names = (field.name for field in fields(document) if field.name not in own)  # type: ignore[arg-type]
    return document(**own, **{name: getattr(source, name) for name in names})


class JsonDocument:
    """Base of the dataclasses that are written as a JSON document of their own.

    They and all dataclasses in them have ``slots=True``: without slots, msgspec leaves out of a document the
    fields that were absent where it was read.
    """

    __slots__ = ()

    def to_json(self) -> str:
        """The document as JSON with sorted keys, floats by ``repr``, indentation and one newline at the end.

        Raises ``ValueError`` for a number that is not finite.
        """
        values = msgspec.to_builtins(self)
        text = json.dumps(values, sort_keys=True, ensure_ascii=False, allow_nan=False)
        return msgspec.json.format(text, indent=1) + "\n"

    def write(self, path: Path) -> Path:
        """Writes the document, whole or not at all, and returns the path."""
        write_text(path, self.to_json())
        return path

    @classmethod
    def from_json(cls, text: str | bytes) -> Self:
        """The document of a JSON text. Keys that this version does not know are ignored.

        Raises:
            msgspec.ValidationError: a value has another type or is missing; the message names its path.
            msgspec.DecodeError: the text is not JSON. Both are kinds of ValueError.
        """
        return msgspec.json.decode(text, type=cls)

    @classmethod
    def load(cls, path: Path, code: str, command: str) -> Self | None:
        """The document of a file, or None if the file does not exist.

        Raises:
            BenchError: of this code: the file, which ``command`` writes, cannot be read or is another one.
        """
        try:
            return cls.from_json(path.read_bytes())
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            hint = f"Write it again with `{command}`."
            raise BenchError(code, f"It cannot be read: {error}.", str(path), hint) from error


def json_schema(document: type[JsonDocument]) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a document, with every key required and no other allowed."""
    schema = msgspec.json.schema(document)
    for part in schema["$defs"].values():
        for field in part["properties"].values():
            field.pop("default", None)
        part |= {"required": sorted(part["properties"]), "additionalProperties": False}
        part["description"] = cleandoc(part.get("description", ""))  # as Python 3.13 does
    return {"$schema": DIALECT, **schema}
