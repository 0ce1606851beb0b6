"""Metadata of a data set of episodes in Croissant 1.0 (https://mlcommons.org/croissant)."""

from datetime import date
from pathlib import Path

from gym_extensions.results.frames import EPISODE_DTYPES
from gym_extensions.versions import version

NAME = "gym-extensions"
CITATION = "@software{gym_extensions, title = {gym-extensions}, author = {{The gym-extensions authors}}}"
LICENSE_URL = "https://spdx.org/licenses/MIT.html"
DESCRIPTIONS = {
    "submission": "name of the submission",
    "group": "id of the group of tasks",
    "protocol": "sequential, single, joint or cumulative",
    "run": "training seed",
    "stage": "number of tasks trained so far",
    "task": "id of the evaluated task",
    "episode": "number of the episode in its run, stage and task",
    "seed": "reset seed",
    "length": "environment steps",
    "return": "undiscounted sum of rewards",
    "terminated": "whether the task ended the episode",
    "success": "whether the episode succeeded; empty where the task defines no success",
    "fingerprint": "fingerprint of the task",
}
TYPES = {"str": "Text", "boolean": "Text", "int64": "Integer", "float64": "Float", "bool": "Boolean"}
"""Types of schema.org by dtype; booleans with empty cells (``boolean``) are texts."""

TERMS = (
    *("citeAs", "column", "equivalentProperty", "extract", "field", "fileObject", "fileProperty", "fileSet"),
    *("format", "includes", "isLiveDataset", "jsonPath", "key", "md5", "parentField", "path", "recordSet"),
    *("references", "regex", "repeated", "replace", "samplingRate", "separator", "source", "subField"),
    "transform",
)
"""The terms of Croissant. Its validator asks for all of them in the context, used or not."""


def croissant(files: dict[str, str]) -> dict[str, object]:
    """The Croissant 1.0 metadata of the CSV files of episodes, given their SHA-256 by path."""
    schema = "https://schema.org/"
    context: dict[str, object] = {"@language": "en", "@vocab": schema, "sc": schema}
    context |= {"cr": "http://mlcommons.org/croissant/", "dct": "http://purl.org/dc/terms/"}
    context |= {"rai": "http://mlcommons.org/croissant/RAI/", "conformsTo": "dct:conformsTo"}
    context |= {term: f"cr:{term}" for term in TERMS}
    context |= {term: {"@id": f"cr:{term}", "@type": "@json"} for term in ("data", "examples")}
    context["dataType"] = {"@id": "cr:dataType", "@type": "@vocab"}
    return {
        "@context": context,
        "@type": "sc:Dataset",
        "name": "gym-extensions-episodes",
        "description": "Evaluation episodes of continual-learning agents on gym-extensions.",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "license": LICENSE_URL,
        "citeAs": CITATION,
        "version": version(NAME).partition(".dev")[0],
        "datePublished": date.today().isoformat(),
        "distribution": [
            {
                "@type": "cr:FileObject",
                "@id": path,
                "name": path,
                "contentUrl": path,
                "encodingFormat": "text/csv",
                "sha256": digest,
            }
            for path, digest in files.items()
        ],
        "recordSet": [
            {"@type": "cr:RecordSet", "@id": record, "name": record, "field": _fields(record, path)}
            for path in files
            for record in [Path(path).stem]
        ],
    }


def _fields(record: str, path: str) -> list[dict[str, object]]:
    return [
        {
            "@type": "cr:Field",
            "@id": f"{record}/{column}",
            "name": column,
            "description": DESCRIPTIONS[column],
            "dataType": f"sc:{TYPES[dtype]}",
            "source": {"fileObject": {"@id": path}, "extract": {"column": column}},
        }
        for column, dtype in EPISODE_DTYPES.items()
    ]
