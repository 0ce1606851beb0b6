"""A folder as a data set: a card with a table of columns, and Croissant 1.0 metadata of its files.

https://docs.mlcommons.org/croissant
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from types import MappingProxyType

from gym_extensions.files import write_text
from gym_extensions.submissions.run import file_sha256
from gym_extensions.versions import version

NAME = "gym-extensions"
LICENSE, LICENSE_URL = "mit", "https://spdx.org/licenses/MIT.html"
TAGS = ("reinforcement-learning", "continual-learning", "gymnasium", "mujoco")
CITATION = "@software{gym_extensions, title = {gym-extensions}, author = {{The gym-extensions authors}}}"
TYPES = {"str": "Text", "boolean": "Text", "bool": "Boolean", "int64": "Integer", "Int64": "Integer"}
TYPES |= {"float64": "Float", "object": "Float"}
"""Types of schema.org by dtype. Booleans with empty cells (``boolean``) are texts, objects are lists."""
FORMATS = {".csv": "text/csv", ".parquet": "application/x-parquet"}
TERMS = (
    *("citeAs", "column", "equivalentProperty", "extract", "field", "fileObject", "fileProperty", "fileSet"),
    *("format", "includes", "isLiveDataset", "jsonPath", "key", "md5", "parentField", "path", "recordSet"),
    *("references", "regex", "repeated", "replace", "samplingRate", "separator", "source", "subField"),
    "transform",
)
"""The terms of Croissant. Its validator asks for all of them in the context, used or not."""
Column = tuple[str, str, str]
"""Name, dtype and description."""


@dataclass(frozen=True)
class Table:
    """A file of a data set by its path in the folder, and its columns."""

    path: str
    columns: Sequence[Column]

    def text(self) -> str:
        """The columns as a table in Markdown."""
        rows = (f"| `{name}` | {value} |" for name, _, value in self.columns)
        return "\n".join(["| column | value |", "|---|---|", *rows])


def front_matter(**values: object) -> str:
    """The metadata at the head of a card, with license and tags. JSON is YAML."""
    known = {"license": LICENSE, "tags": list(TAGS)} | values
    lines = (f"{key}: {json.dumps(value, ensure_ascii=False)}" for key, value in known.items())
    return "\n".join(["---", *lines, "---", ""])


def write_metadata(
    folder: Path,
    name: str,
    description: str,
    tables: Sequence[Table],
    responsible: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Writes ``croissant.json`` of the files in a folder.

    ``responsible`` are texts by property of the vocabulary for responsible AI, RAI 1.0
    (https://docs.mlcommons.org/croissant/docs/croissant-rai-spec.html).
    """
    schema, home = "https://schema.org/", "http://mlcommons.org/croissant"
    context: dict[str, object] = {"@language": "en", "@vocab": schema, "sc": schema, "cr": f"{home}/"}
    context |= {"dct": "http://purl.org/dc/terms/", "rai": f"{home}/RAI/", "conformsTo": "dct:conformsTo"}
    context |= {term: f"cr:{term}" for term in TERMS}
    context |= {term: {"@id": f"cr:{term}", "@type": "@json"} for term in ("data", "examples")}
    context["dataType"] = {"@id": "cr:dataType", "@type": "@vocab"}
    metadata = {
        "@context": context,
        "@type": "sc:Dataset",
        "name": name,
        "description": description,
        "conformsTo": [f"{home}/1.0", f"{home}/RAI/1.0"] if responsible else f"{home}/1.0",
        "license": LICENSE_URL,
        "citeAs": CITATION,
        "version": version(NAME).partition(".dev")[0],
        "datePublished": date.today().isoformat(),
        **{f"rai:{key}": text for key, text in responsible.items()},
        "distribution": [
            {
                "@type": "cr:FileObject",
                "@id": table.path,
                "name": table.path,
                "contentUrl": table.path,
                "encodingFormat": FORMATS[Path(table.path).suffix],
                "sha256": file_sha256(folder / table.path),
            }
            for table in tables
        ],
        "recordSet": [
            {"@type": "cr:RecordSet", "@id": record, "name": record, "field": _fields(record, table)}
            for table in tables
            for record in [Path(table.path).stem]
        ],
    }
    write_text(folder / "croissant.json", json.dumps(metadata, indent=1, ensure_ascii=False) + "\n")


def _fields(record: str, table: Table) -> list[dict[str, object]]:
    return [
        {
            "@type": "cr:Field",
            "@id": f"{record}/{column}",
            "name": column,
            "description": text,
            "dataType": f"sc:{TYPES[dtype]}",
            "source": {"fileObject": {"@id": table.path}, "extract": {"column": column}},
            **({"repeated": True} if dtype == "object" else {}),
        }
        for column, dtype, text in table.columns
    ]
