"""The JSON Schemas of the published documents, and the tables of the documentation that describe them.

``make docs`` writes the tables between the lines ``<!-- table: NAME -->`` and ``<!-- end -->`` of docs/*.md.
"""

from __future__ import annotations

import dataclasses
import inspect
import json
import re
import sys
from pathlib import Path
from typing import Any, get_args

import msgspec

from gym_extensions.catalog import variations
from gym_extensions.catalog.bodies import BODIES
from gym_extensions.catalog.protocol import REPORTS
from gym_extensions.documents import DIALECT, json_schema
from gym_extensions.metrics.formulas import METRICS, NEEDS
from gym_extensions.scoring.ranking.boards import BoardsDocument, Comparison
from gym_extensions.scoring.scorecard import ScorecardDocument
from gym_extensions.submissions.layout import MANIFEST
from gym_extensions.submissions.manifest import Manifest
from gym_extensions.submissions.poses import Poses
from gym_extensions.submissions.problem import Scope
from gym_extensions.submissions.rules import RULES

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


DOCUMENTS = (ScorecardDocument, BoardsDocument, Comparison)
BLOCK = re.compile(r"<!-- table: (?P<name>[^>]+) -->\n.*?<!-- end -->", re.DOTALL)


def _metrics(protocol: str) -> str:
    rows = ["| metric | formula | better | also needs | also known as |\n|---|---|---|---|---|"]
    for each in METRICS[protocol]:
        needs, better = (
            ", ".join(NEEDS[name] for name in each.needs if name in NEEDS),
            each.better or "not ranked",
        )
        rows.append(f"| `{each.name}` {each.title} | {each.formula} | {better} | {needs} | {each.known_as} |")
    return "\n".join(rows)


def _keys(definition: dict[str, Any], definitions: dict[str, Any]) -> str:
    """The table of an object's keys. A key without a description has the first paragraph of its type's."""

    def description(field: dict[str, Any]) -> str:
        if "description" in field or "$ref" not in field:
            return str(field.get("description", ""))
        text = str(definitions[field["$ref"].rpartition("/")[2]]["description"])
        text = " ".join(text.partition("\n\n")[0].split())
        return text[:1].lower() + text[1:].rstrip(".")

    rows = [f"| `{name}` | {description(field)} |" for name, field in definition["properties"].items()]
    return "\n".join(["| key | value |\n|---|---|", *rows])


def _rules() -> str:
    ordered = sorted(RULES.values(), key=lambda rule: get_args(Scope).index(rule.scope))
    return "\n".join(
        ["| rule | text |\n|---|---|", *(f"| `{rule.name}` | {rule.text} |" for rule in ordered)]
    )


def _variations() -> str:
    rows = ["| `kind` | arguments | what it does | bodies |\n|---|---|---|---|"]
    for kind in (kind for name, kind in variations.KINDS.items() if name in variations.__all__):
        arguments = ", ".join(
            f"`{each.name}`" + ("" if each.default is dataclasses.MISSING else f" = {each.default}")
            for each in dataclasses.fields(kind)
        )
        summary = " ".join((inspect.getdoc(kind) or "").partition("\n\n")[0].replace("``", "`").split())
        bodies = [name for name, body in BODIES.items() if kind.fits(body)]
        others = [name for name in BODIES if name not in bodies]
        fitting = f"all but {' and '.join(others)}" if len(others) < 3 else ", ".join(bodies)
        rows.append(f"| `{kind.__name__}` | {arguments.replace('False', 'false')} | {summary} | {fitting} |")
    return "\n".join(rows)


def tables() -> dict[str, str]:
    """Every generated table by its name."""
    texts = {"rules": _rules(), "variations": _variations()} | {
        f"metrics {protocol}": _metrics(protocol) for protocol in METRICS
    }
    for document in DOCUMENTS:
        definitions = json_schema(document)["$defs"]
        texts |= {f"keys {name}": _keys(part, definitions) for name, part in definitions.items()}
    return texts


def updated(page: str) -> str:
    """The page with its tables updated. Raises KeyError for a table that does not exist."""
    texts = tables()
    return BLOCK.sub(
        lambda block: f"<!-- table: {block['name']} -->\n{texts[block['name']]}\n<!-- end -->", page
    )


def main(folder: str) -> None:
    """Writes the tables of every page in a folder."""
    for path in sorted(Path(folder).glob("*.md")):
        path.write_text(updated(path.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])
