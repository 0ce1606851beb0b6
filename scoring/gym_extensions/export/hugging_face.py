"""Folders for Hugging Face: policies of submissions and the experts with model cards, and episodes as a
dataset.

Each folder below ``models`` and ``datasets`` is one repository. The dataset has metadata in Croissant 1.0
(https://mlcommons.org/croissant).
"""

import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path

from gym_extensions.catalog.groups import group
from gym_extensions.errors import BenchError
from gym_extensions.files import write_text
from gym_extensions.metrics.formulas import METRICS
from gym_extensions.references import experts
from gym_extensions.results.frames import EPISODE_DTYPES, episodes
from gym_extensions.scoring import pipeline, scorecard
from gym_extensions.scoring.output.board_frames import scores
from gym_extensions.submissions.layout import DOCUMENT, LOG, NETWORK, POLICIES, run_file, scan
from gym_extensions.submissions.run import file_sha256
from gym_extensions.versions import version

NAME = "gym-extensions"
LICENSE, LICENSE_URL = "mit", "https://spdx.org/licenses/MIT.html"
TAGS = ("reinforcement-learning", "continual-learning", "gymnasium", "mujoco")


def front_matter(values: Mapping[str, object]) -> str:
    """The metadata at the head of a card. JSON is YAML."""
    lines = (f"{key}: {json.dumps(value, ensure_ascii=False)}" for key, value in values.items())
    return "\n".join(["---", *lines, "---", ""])


FILES = {
    POLICIES: "`GROUP/PROTOCOL/runN.npz` has the policies of run N after every stage as plain arrays.",
    NETWORK: "`GROUP/PROTOCOL/runN.stageS.onnx` is the policy of run N after stage S as a network.",
}
LOAD = """```python
from gym_extensions import policies

policy = policies.load(".", "{group}", protocol="{protocol}", run={run}{task})
```"""


def write_repositories(
    folder: Path, submissions: Sequence[Path], groups: Sequence[str] = (), with_experts: bool = False
) -> list[str]:
    """Writes ``models/NAME`` for every submission with policies, ``models/experts``, and
    ``datasets/episodes``.

    All groups are exported if none is named. Returns the paths of the repositories.

    Raises:
        BenchError: a path or group does not exist, a submission has problems, or there is nothing to write.
    """
    cards = pipeline.valid_scorecards(submissions, pipeline.make_scorer(only=groups)) if submissions else {}
    written = []
    if with_experts:
        write_experts(folder / "models" / "experts")
        written.append("models/experts")
    for path, card in cards.items():
        if write_submission(folder / "models" / card.name, path, card):
            written.append(f"models/{card.name}")
    logged = [path for path, card in cards.items() if any(_protocols(card))]
    if logged:
        names = {id_ for card in cards.values() for id_, _ in _protocols(card)}
        write_dataset(folder / "datasets" / "episodes", logged, names)
        written.append("datasets/episodes")
    if not written:
        hint = "Name submissions with logs, or --experts."
        raise BenchError("nothing-to-export", "There are neither policies nor logs.", "", hint)
    return written


def _protocols(card: scorecard.Scorecard) -> Iterator[tuple[str, str]]:
    """The group ids and protocols of a scorecard that have runs."""
    for id_, protocols in card.groups.items():
        yield from ((id_, protocol) for protocol, score in protocols.items() if score.runs)


def write_submission(target: Path, source: Path, card: scorecard.Scorecard) -> bool:
    """Writes the policies, documents and card of a submission's runs; False if it has no policies."""
    files = scan(source).runs
    written, kinds = [], set[str]()
    for id_, protocol in _protocols(card):
        name = group(id_).name
        for run, suffixes in files[name, protocol].items():
            if suffixes <= {DOCUMENT, LOG}:
                continue
            (target / name / protocol).mkdir(parents=True, exist_ok=True)
            for path in (run_file(name, protocol, run, suffix) for suffix in suffixes - {LOG}):
                shutil.copyfile(source / path, target / path)
                kinds.add(Path(path).suffix)
            written.append((name, protocol, run))
    if written:
        write_text(target / "README.md", model_card(card, written, kinds))
    return bool(written)


def model_card(card: scorecard.Scorecard, runs: Sequence[tuple[str, str, int]], kinds: set[str]) -> str:
    """The card of a submission's policies, with its metrics; ``kinds``: suffixes of the runs' files."""
    assert card.manifest is not None
    results = [
        {
            "task": {"type": "reinforcement-learning", "name": f"{protocol} training"},
            "dataset": {"type": name, "name": name},
            "metrics": [
                {"type": metric.name, "name": metric.title, "value": value.mean}
                for metric in METRICS[protocol]
                if (value := score.metrics[metric.name]).mean is not None
            ],
        }
        for name, protocol, score in scores(card)
    ]
    head = {
        "license": LICENSE,
        "library_name": NAME,
        "tags": [*TAGS, card.manifest.protocol.algorithm],
        "model-index": [{"name": card.name, "results": [each for each in results if each["metrics"]]}],
    }
    name, protocol, run = runs[0]
    task = f', task="{group(name).tasks[0].name}"' if protocol == "single" else ""
    lines = [
        f"# {card.title}",
        *(f"**This submission was {doubt}**" for doubt in card.doubts),
        card.manifest.description,
        f"Authors: {', '.join(card.manifest.authors)}. Level: {card.level}. "
        f"Training budget: {card.manifest.protocol.budget} steps per task. "
        f"Evaluation: {card.manifest.protocol.evaluation} actions.",
        f"{' '.join(text for suffix, text in FILES.items() if suffix in kinds)} "
        f"`runN.json` says how they were trained: {len(runs)} runs. Metrics are normalized returns, 0 at the "
        "floor and 1 at the reference, as means over runs.",
        LOAD.format(group=name, protocol=protocol, run=run, task=task),
    ]
    return front_matter(head) + "\n" + "\n\n".join(lines) + "\n"


def write_experts(target: Path) -> None:
    """Writes the experts of this version, their cards, and a card of all."""
    rows = []
    target.mkdir(parents=True)
    for name in experts.names():
        card = experts.card(name)
        for suffix in (".npz", ".json"):
            shutil.copyfile(experts.DATA / f"{name}{suffix}", target / f"{name}{suffix}")
        measured = card.measurement
        note = card.provisional.replace("|", "/")
        returns = f"{measured.mean:.1f} ± {measured.deviation:.1f}"
        rows.append(f"| {name} | {returns} | {measured.episodes} | {note} |")
    head = front_matter({"license": LICENSE, "library_name": NAME, "tags": list(TAGS)})
    text = f"""
# Experts of gym-extensions {version(NAME)}

One deterministic policy per MuJoCo task as plain arrays, `TASK.npz`, and how it came about, `TASK.json`.

```python
from pathlib import Path
from gym_extensions.references import experts

policy = experts.load("{experts.names()[0]}", Path("."))
```

| task | return: mean ± standard deviation | episodes | provisional, because |
|---|---|---|---|
"""
    write_text(target / "README.md", head + text + "\n".join(rows) + "\n")


def write_dataset(target: Path, submissions: Sequence[Path], groups: set[str]) -> None:
    """Writes the evaluation episodes, a CSV file per submission, with a card and Croissant metadata."""
    files: dict[str, str] = {}
    count = 0
    for path in submissions:
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


CITATION = "@software{gym_extensions, title = {gym-extensions}, author = {{The gym-extensions authors}}}"
DESCRIPTIONS = {
    "submission": "name of the submission",
    "group": "id of the group of tasks",
    "protocol": "sequential, single, joint, cumulative, descending or balanced",
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
