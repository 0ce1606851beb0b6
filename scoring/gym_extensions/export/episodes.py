"""Evaluation episodes as a dataset: CSV files, the card of Hugging Face, and Croissant metadata.

Croissant is the format of https://mlcommons.org/croissant, version 1.0.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import Any

from gym_extensions.files import write_text
from gym_extensions.results.frames import EPISODE_DTYPES, episodes
from gym_extensions.rollouts.run import file_sha256
from gym_extensions.versions import version

NAME = "gym-extensions"
LICENSE, LICENSE_URL = "mit", "https://spdx.org/licenses/MIT.html"
TAGS = ("reinforcement-learning", "continual-learning", "gymnasium", "mujoco")


def front_matter(values: dict[str, Any]) -> str:
    """The metadata at the head of a card. JSON is YAML."""
    lines = (f"{key}: {json.dumps(value, ensure_ascii=False)}" for key, value in values.items())
    return "\n".join(["---", *lines, "---", ""])


DESCRIPTIONS = {
    "submission": "name of the submission",
    "group": "id of the group of tasks",
    "protocol": "sequential, single or joint",
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
TYPES = {"str": "sc:Text", "int64": "sc:Integer", "float64": "sc:Float", "bool": "sc:Boolean"}
TYPES["boolean"] = "sc:Text"
"""Booleans with empty cells are texts."""


def write_dataset(target: Path, entries: Sequence[Path], groups: set[str]) -> None:
    """Writes the evaluation episodes, a CSV file per entry, with a card and Croissant metadata."""
    files: dict[str, str] = {}
    count = 0
    for path in entries:
        frame = episodes(path)
        frame = frame[frame["group"].isin(groups)]
        name = f"data/{path.resolve().name}.csv"
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        frame.to_csv(target / name, index=False, lineterminator="\n")
        files[name] = file_sha256(target / name)
        count += len(frame)
    metadata = croissant(files)
    write_text(target / "croissant.json", json.dumps(metadata, indent=1, ensure_ascii=False) + "\n")
    configs = [{"config_name": "default", "data_files": "data/*.csv"}]
    head = {"license": LICENSE, "tags": list(TAGS), "configs": configs}
    names = ", ".join(Path(path).stem for path in files)
    columns = "\n".join(f"| `{name}` | {text} |" for name, text in DESCRIPTIONS.items())
    text = f"""
# Evaluation episodes of gym-extensions

{count:,} episodes, one per row, of {names}. `croissant.json` describes the files.

| column | value |
|---|---|
{columns}
"""
    write_text(target / "README.md", front_matter(head) + text)


TERMS = (
    *("citeAs", "column", "equivalentProperty", "extract", "field", "fileObject", "fileProperty", "fileSet"),
    *("format", "includes", "isLiveDataset", "jsonPath", "key", "md5", "parentField", "path", "recordSet"),
    *("references", "regex", "repeated", "replace", "samplingRate", "separator", "source", "subField"),
    "transform",
)
"""The terms of Croissant. Its validator asks for all of them in the context, used or not."""


def croissant(files: dict[str, str]) -> dict[str, Any]:
    """The Croissant 1.0 metadata of the CSV files of episodes, given their SHA-256 by path."""
    schema = "https://schema.org/"
    context: dict[str, Any] = {"@language": "en", "@vocab": schema, "sc": schema}
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


def _fields(record: str, path: str) -> list[dict[str, Any]]:
    return [
        {
            "@type": "cr:Field",
            "@id": f"{record}/{column}",
            "name": column,
            "description": DESCRIPTIONS[column],
            "dataType": TYPES[dtype],
            "source": {"fileObject": {"@id": path}, "extract": {"column": column}},
        }
        for column, dtype in EPISODE_DTYPES.items()
    ]
