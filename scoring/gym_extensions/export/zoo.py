"""The policy zoo: every stored policy with its returns, diagnostics and weights, as a data set in Parquet."""

import hashlib
import json
import tomllib
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd

from gym_extensions.catalog.groups import GROUPS, TaskGroup, group
from gym_extensions.errors import BenchError
from gym_extensions.export import datasets
from gym_extensions.files import write_text
from gym_extensions.results import frames, policies
from gym_extensions.scoring.pipeline import find_submissions, make_scorer
from gym_extensions.submissions.policies import files, mlp, mlp_arrays
from gym_extensions.submissions.submission import runs_folder

TEXTS = Path(__file__).with_name("zoo.toml")
NAMES = ("activation", "output_activation", "squash", "head")
VALUES = "values"
"""The column of the weights."""
Network = tuple[str, str, mlp_arrays.Array | None]
"""Of a policy: its network as JSON, the digest of its weights, and these, (n,); empty of ONNX."""
SPLITS = ("train", "train", "train", "validation", "test")
"""By the number of the run modulo 5, so that equal seeds of different methods are in one split."""


def write_zoo(folder: Path, submissions: Sequence[Path], groups: Sequence[str] = ()) -> list[str]:
    """Writes the tables ``policies``, ``returns`` and ``weights``, a card and Croissant metadata.

    All groups are exported if none is named. Returns the names of the tables' files.

    Raises:
        BenchError: pyarrow is missing, a path or group does not exist, a submission has problems, or there
            are no policies.
    """
    if find_spec("pyarrow") is None:
        hint = "Install it with: pip install 'gym-extensions[parquet]'"
        raise BenchError("missing-extra", "Parquet files need pyarrow.", hint=hint)
    texts, only = tomllib.loads(TEXTS.read_text("utf-8")), make_scorer(only=groups).only
    frame = policies(submissions)
    frame = frame[frame["group"].isin([group(name).id for name in only])] if groups else frame
    if frame.empty:
        raise BenchError("nothing-to-export", "There are no policies.", "", "Name submissions with policies.")
    paths = {path.name: path for path in find_submissions(submissions)}
    rows: list[Network] = []
    for (name, id_, protocol, run), part in frame.groupby(
        ["submission", "group", "protocol", "run"], sort=False
    ):
        found = networks(paths[str(name)], group(str(id_)), str(protocol), int(str(run)))
        rows += found or [("", "", None)] * len(part)
    frame = frame.assign(
        split=[SPLITS[run % len(SPLITS)] for run in frame["run"]],
        network=[network for network, _, _ in rows],
        weights=[digest for _, digest, _ in rows],
    )
    vectors = {digest: vector for _, digest, vector in rows if digest}
    weights = pd.DataFrame(vectors.items(), columns=["sha256", VALUES], dtype=object)
    texts["policies"] = [*frames.columns_of(policies), *texts["policies"]]
    contents = {"policies": frame, "returns": returns_of(frame), "weights": weights}
    tables = [datasets.Table(f"{name}.parquet", texts[name]) for name in contents]
    for table, content in zip(tables, contents.values(), strict=True):
        write_parquet(folder / table.path, content, table.columns)
    responsible = texts["responsible"]
    datasets.write_metadata(folder, "gym-extensions-zoo", texts["description"], tables, responsible)
    counts = {name: frame[name[:-1]].nunique() for name in ("submissions", "groups")}
    text = [table.text() for table in tables]
    card = texts["card"].format(policies=len(frame), columns=text, **counts, **responsible)
    configs = [{"config_name": name, "data_files": f"{name}.parquet"} for name in contents]
    write_text(folder / "README.md", datasets.front_matter(configs=configs) + card)
    return [table.path for table in tables]


def write_parquet(path: Path, frame: pd.DataFrame, columns: Sequence[datasets.Column]) -> None:
    """Writes the columns of a frame; objects are lists of float64, or of float32 as they are in arrays."""
    import pyarrow as arrow
    from pyarrow import parquet

    kinds = {
        "str": arrow.string(),
        "int64": arrow.int64(),
        "Int64": arrow.int64(),
        "float64": arrow.float64(),
    }
    is_single = VALUES in frame
    kinds["object"] = arrow.list_(arrow.float32() if is_single else arrow.float64())
    fields = [(name, kinds[dtype]) for name, dtype, _ in columns]
    arrays = [arrow.array(frame[name], kind, from_pandas=True) for name, kind in fields]
    table = arrow.Table.from_arrays(arrays, schema=arrow.schema(fields))
    # Bytes of one place together: exponents repeat, which saves a fifth.
    split = {"use_dictionary": False, "use_byte_stream_split": [f"{VALUES}.list.element"]}
    parquet.write_table(table, path, compression="zstd", **(split if is_single else {}))


def networks(submission: Path, members: TaskGroup, protocol: str, run: int) -> list[Network]:
    """The networks of the policies of a run; none if they lie elsewhere."""
    try:
        folder = runs_folder(submission, members.name, protocol)
        stored = files.read_policies(folder, members, protocol, run).values()
    except BenchError:
        return []
    found: list[Network] = []
    for policy in stored:
        if not isinstance(policy, mlp.Policy):
            found.append(("", "", None))
            continue
        arrays = {name: values for name, values in policy.arrays().items() if values.dtype.kind == "f"}
        arrays |= {f"weight_{layer}": each for layer, each in enumerate(policy.masked_weights)}
        vector = np.concatenate([values.ravel() for values in arrays.values()]).astype("<f4")
        names = {name: getattr(policy, name) for name in NAMES}
        network = json.dumps(names | {"shapes": {name: values.shape for name, values in arrays.items()}})
        found.append((network, hashlib.sha256(vector.tobytes()).hexdigest(), vector))
    return found


def returns_of(frame: pd.DataFrame) -> pd.DataFrame:
    """A row per policy and task on which it was evaluated."""
    tasks = {each.id: each.task_ids for each in GROUPS.values()}
    rows = frame.rename(columns={"task": "trained", "returns": "return", "scores": "score"})
    rows = rows.assign(task=rows["group"].map(tasks)).explode(["task", "return", "score"])
    return rows[rows["return"].notna()]
