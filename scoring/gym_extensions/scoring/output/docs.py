"""Tables of the documentation, generated from the metrics' table and from the documents' types.

``make docs`` writes them between the lines ``<!-- table: NAME -->`` and ``<!-- end -->`` of docs/*.md.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from gym_extensions.scoring.documents import json_schema
from gym_extensions.scoring.leaderboard.model import BoardsDocument, Comparison
from gym_extensions.scoring.metrics.definitions import METRICS
from gym_extensions.scoring.metrics.metric import Metric
from gym_extensions.scoring.scorecard.model import ScorecardDocument

DOCUMENTS = (ScorecardDocument, BoardsDocument, Comparison)
BLOCK = re.compile(r"<!-- table: (?P<name>[^>]+) -->\n.*?<!-- end -->", re.DOTALL)


def _metric(metric: Metric) -> str:
    needs = ", ".join(f"`{name}.csv`" for name in metric.needs)
    better = metric.better or "not ranked"
    return f"| `{metric.name}` {metric.title} | {metric.formula} | {better} | {needs} | {metric.known_as} |"


def _metrics(protocol: str) -> str:
    head = "| metric | formula | better | also needs | also known as |\n|---|---|---|---|---|"
    return "\n".join([head, *map(_metric, METRICS[protocol])])


def _keys(definition: dict[str, Any], definitions: dict[str, Any]) -> str:
    """The table of an object's keys. A key without a description has that of its type."""

    def description(field: dict[str, Any]) -> str:
        if "$ref" not in field:
            return str(field.get("description", ""))
        text = str(definitions[field["$ref"].rpartition("/")[2]]["description"])
        return text[:1].lower() + text[1:].rstrip(".")

    rows = [f"| `{name}` | {description(field)} |" for name, field in definition["properties"].items()]
    return "\n".join(["| key | value |\n|---|---|", *rows])


def tables() -> dict[str, str]:
    """Every generated table by its name."""
    texts = {f"metrics {protocol}": _metrics(protocol) for protocol in METRICS}
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
