"""Folders for Hugging Face: policies of submissions and the experts with model cards, and episodes as a
dataset.

Each folder below ``models`` and ``datasets`` is one repository. The dataset has metadata in Croissant 1.0
(https://mlcommons.org/croissant).
"""

import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

from gym_extensions.catalog.groups import group
from gym_extensions.errors import BenchError
from gym_extensions.export import datasets
from gym_extensions.files import write_text
from gym_extensions.metrics.formulas import METRICS
from gym_extensions.references import experts
from gym_extensions.results.frames import columns_of, episodes
from gym_extensions.scoring import pipeline, scorecard
from gym_extensions.submissions.layout import DOCUMENT, LOG, NETWORK, POLICIES, run_file, scan
from gym_extensions.submissions.submission import runs_folder
from gym_extensions.versions import version

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
    cards = pipeline.valid_scorecards(submissions, pipeline.make_scorer(only=groups))
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
    written, kinds = [], set[str]()
    for id_, protocol in _protocols(card):
        name = group(id_).name
        folder = runs_folder(source, name, protocol)
        for run, suffixes in scan(folder).runs[name, protocol].items():
            if suffixes <= {DOCUMENT, LOG} or run not in card.groups[id_][protocol].runs:
                continue
            (target / name / protocol).mkdir(parents=True, exist_ok=True)
            for path in (run_file(name, protocol, run, suffix) for suffix in suffixes - {LOG}):
                shutil.copyfile(folder / path, target / path)
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
        for name, protocol, score in card.scores()
    ]
    head = datasets.front_matter(
        library_name=datasets.NAME,
        tags=[*datasets.TAGS, card.manifest.protocol.algorithm],
        **{"model-index": [{"name": card.name, "results": [each for each in results if each["metrics"]]}]},
    )
    name, protocol, run = runs[0]
    task = f', task="{group(name).tasks[0].name}"' if protocol == "single" else ""
    lines = [
        f"# {card.title}",
        *(f"**This submission was {doubt}**" for doubt in card.doubts),
        card.manifest.description,
        f"Authors: {', '.join(card.manifest.authors)}. Level: {card.level}. "
        f"Training budget: {card.manifest.protocol.budget}. "
        f"Evaluation: {card.manifest.protocol.evaluation} actions.",
        f"{' '.join(text for suffix, text in FILES.items() if suffix in kinds)} "
        f"`runN.json` says how it was trained. Runs: {len(runs)}. Metrics are normalized returns, 0 at the "
        "floor and 1 at the expert, as means over runs.",
        LOAD.format(group=name, protocol=protocol, run=run, task=task),
    ]
    return head + "\n" + "\n\n".join(lines) + "\n"


def write_experts(target: Path) -> None:
    """Writes the experts of this version, their cards, and a card of all."""
    rows = []
    target.mkdir(parents=True)
    for name in experts.names():
        card = experts.card(name)
        measured, note = card.measurement, card.provisional.replace("|", "/")
        for suffix in (".npz", ".json"):
            shutil.copyfile(experts.DATA / f"{name}{suffix}", target / f"{name}{suffix}")
        returns = f"{measured.mean:.1f} ± {measured.deviation:.1f}"
        rows.append(f"| {name} | {returns} | {measured.episodes} | {note} |")
    head = datasets.front_matter(library_name=datasets.NAME)
    text = f"""
# Experts of gym-extensions {version(datasets.NAME)}

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
    columns, count, tables = columns_of(episodes), 0, []
    (target / "data").mkdir(parents=True)
    for path in submissions:
        frame = episodes(path)
        frame = frame[frame["group"].isin(groups)]
        tables.append(datasets.Table(f"data/{path.resolve().name}.csv", columns))
        frame.to_csv(target / tables[-1].path, index=False, lineterminator="\n")
        count += len(frame)
    description = "Evaluation episodes of continual-learning agents on gym-extensions."
    datasets.write_metadata(target, "gym-extensions-episodes", description, tables)
    head = datasets.front_matter(configs=[{"config_name": "default", "data_files": "data/*.csv"}])
    names = ", ".join(Path(table.path).stem for table in tables)
    text = f"""
# Evaluation episodes of gym-extensions

{count:,} episodes, one per row, of {names}. `croissant.json` describes the files.

{tables[0].text()}
"""
    write_text(target / "README.md", head + text)
