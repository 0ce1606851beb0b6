"""`gym-extensions export`: what other projects get, in a new folder, whole or not at all."""

import hashlib
import json
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pandas as pd
import pytest

from gym_extensions import policies
from gym_extensions.errors import BenchError
from gym_extensions.export import cli, hugging_face, zoo as zoo_export
from gym_extensions.references import experts
from gym_extensions.results.frames import dtypes_of, episodes
from gym_extensions.scoring.pipeline import make_scorer
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.review import Decision, Review, write_review
from gym_extensions.submissions.run import read_run, write_run

SUBMISSION = Path(__file__).resolve().parents[2] / "submissions" / "trpo"
LAYERS = {"weights": "weight", "biases": "bias"}
GROUP, GROUP_ID = "hopper-wall", "hopper-wall-v0"


@pytest.fixture(scope="module")
def repositories(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder for Hugging Face of one group, and of the experts."""
    out = tmp_path_factory.mktemp("export") / "hf"
    assert cli.main(["hugging-face", str(SUBMISSION), "--group", GROUP, "--experts", "--out", str(out)]) == 0
    return out


@pytest.mark.committed
def test_a_model_card_has_its_metadata_and_the_code_that_loads_a_policy(repositories: Path) -> None:
    card = (repositories / "models" / "trpo" / "README.md").read_text("utf-8")
    lines = card.split("---")[1].strip().splitlines()
    head = {key: json.loads(value) for key, _, value in (line.partition(": ") for line in lines)}
    assert head["library_name"] == "gym-extensions"
    assert "runN.npz" in card
    assert ".onnx" not in card, "the submission has plain arrays alone"
    [index] = head["model-index"]
    assert {result["dataset"]["name"] for result in index["results"]} == {GROUP_ID}
    code = card.split("```python\n")[1].split("```")[0] + "print(policy.num_actions)"
    here = repositories / "models" / "trpo"
    assert subprocess.check_output([sys.executable, "-c", code], cwd=here, text=True).strip() == "3"


def test_a_decision_is_stated(make_submission: Callable[..., Path]) -> None:
    submission = make_submission(groups=(GROUP,))
    decision = Decision(action="withdrawn", by="M.", date="2026-01-02", reason="An error.")
    write_review(submission, Review(decisions=[decision]))
    doubt = "withdrawn from all boards on 2026-01-02: An error."
    card = make_scorer()(submission)
    assert f"**This submission was {doubt}**" in hugging_face.model_card(
        card, [(GROUP, "sequential", 0)], set()
    )


@pytest.mark.committed
def test_the_experts_are_copied_with_their_cards(repositories: Path) -> None:
    folder = repositories / "models" / "experts"
    assert {path.stem for path in folder.glob("*.npz")} == set(experts.names())
    assert experts.card("Hopper", folder) == experts.card("Hopper")


@pytest.mark.committed
def test_croissant_describes_every_file_and_column(repositories: Path) -> None:
    folder = repositories / "datasets" / "episodes"
    metadata = json.loads((folder / "croissant.json").read_text("utf-8"))
    [file] = metadata["distribution"]
    content = (folder / file["contentUrl"]).read_bytes()
    assert file["sha256"] == hashlib.sha256(content).hexdigest()
    [records] = metadata["recordSet"]
    assert [field["name"] for field in records["field"]] == list(dtypes_of(episodes))
    assert content.splitlines()[0].decode().split(",") == list(dtypes_of(episodes))


@pytest.mark.committed
def test_croissants_own_validator_accepts_the_metadata(repositories: Path) -> None:
    mlcroissant = pytest.importorskip("mlcroissant")
    dataset = mlcroissant.Dataset(repositories / "datasets" / "episodes" / "croissant.json")
    assert not dataset.metadata.issues.errors | dataset.metadata.issues.warnings


def test_an_existing_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["hugging-face", str(SUBMISSION), "--out", str(tmp_path)]) == 2
    assert str(tmp_path) in capsys.readouterr().err


@pytest.mark.committed
def test_a_failure_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(folder: Path, *_: Any) -> int:
        (folder / "half").write_text("written")
        raise OSError("no space")

    monkeypatch.setattr(hugging_face, "write_repositories", fail)
    with pytest.raises(OSError, match="no space"):
        cli.main(["hugging-face", str(SUBMISSION), "--out", str(tmp_path / "out")])
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def zoo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The data set of the policies of one group."""
    pytest.importorskip("pyarrow")
    out = tmp_path_factory.mktemp("zoo") / "zoo"
    stored = [str(SUBMISSION.parent / name) for name in ("ppo-packnet-tuned", "sac")]
    assert cli.main(["zoo", *stored, "--group", "hopper-gravity", "--out", str(out)]) == 0
    return out


@pytest.mark.committed
def test_the_weights_of_the_zoo_make_its_policies_again(zoo: Path) -> None:
    frame = pd.read_parquet(zoo / "policies.parquet")
    weights = pd.read_parquet(zoo / "weights.parquet").set_index("sha256")["values"]
    assert set(frame["weights"]) == set(weights.index)
    observations = np.random.default_rng(0).normal(size=(3, 11))
    for name, stage in (("ppo-packnet-tuned", 5), ("sac", 3)):
        found = frame.query(
            "submission == @name and protocol == 'sequential' and stage == @stage and run == 4"
        )
        (row,) = found.to_dict("records")
        network, vector = json.loads(row["network"]), weights[row["weights"]]
        assert hashlib.sha256(vector.tobytes()).hexdigest() == row["weights"]
        shapes = network.pop("shapes")
        parts = np.split(vector, np.cumsum([math.prod(shape) for shape in shapes.values()])[:-1])
        named = {key: part.reshape(shape) for (key, shape), part in zip(shapes.items(), parts, strict=True)}
        layers = {each: tuple(named.pop(f"{kind}_{i}") for i in range(3)) for each, kind in LAYERS.items()}
        fields: dict[str, Any] = network | named | layers
        again = Policy(**fields)
        policy = policies.load(SUBMISSION.parent / name, "hopper-gravity", run=4, stage=stage)
        assert again.act(observations, task=2) == pytest.approx(policy.act(observations, task=2), abs=1e-6)


@pytest.mark.committed
def test_every_run_of_the_zoo_is_in_one_split_and_every_return_is_a_row(zoo: Path) -> None:
    frame, returns = (pd.read_parquet(zoo / f"{name}.parquet") for name in ("policies", "returns"))
    runs = frame.groupby(["run"])["split"].unique().map(list).to_dict()
    assert [runs[run] for run in range(5)] == [["train"]] * 3 + [["validation"], ["test"]]
    keys = ["submission", "protocol", "run", "stage"]
    listed = frame.set_index(keys)["returns"].map(list).to_dict()
    assert returns.groupby(keys)["return"].apply(list).to_dict() == listed
    assert len(returns) == 5 * len(frame)


@pytest.mark.committed
def test_the_zoo_has_a_card_and_croissant_with_fields_for_responsible_ai(zoo: Path) -> None:
    metadata = json.loads((zoo / "croissant.json").read_text("utf-8"))
    assert {"rai:dataUseCases", "rai:dataLimitations", "rai:dataBiases"} < metadata.keys()
    card = (zoo / "README.md").read_text("utf-8")
    for table in metadata["distribution"]:
        frame = pd.read_parquet(zoo / table["contentUrl"])
        (records,) = (each for each in metadata["recordSet"] if f"{each['name']}.parquet" == table["name"])
        assert [field["name"] for field in records["field"]] == list(frame)
        assert all(f"| `{name}` |" in card for name in frame)
    assert metadata["rai:dataLimitations"] in card
    mlcroissant = pytest.importorskip("mlcroissant")
    dataset = mlcroissant.Dataset(zoo / "croissant.json")
    assert not dataset.metadata.issues.errors | dataset.metadata.issues.warnings


def test_without_pyarrow_the_zoo_says_what_to_install(
    make_submission: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(BenchError, match=r"gym-extensions\[parquet\]"):
        zoo_export.write_zoo(tmp_path, [make_submission()])


def test_policies_that_lie_elsewhere_are_in_the_zoo_of_the_core_without_weights(
    make_submission: Callable[..., Path], tmp_path: Path
) -> None:
    pytest.importorskip("pyarrow")
    submission = make_submission(protocols=("sequential",), runs=(0,))
    path = submission / "hopper-gravity/sequential/run0.json"
    path.with_suffix(".npz").unlink()
    document = read_run(path)
    assert document.policies is not None
    there = msgspec.structs.replace(document.policies, url="https://example.org/run0.npz")
    write_run(path, msgspec.structs.replace(document, policies=there))
    (tmp_path / "zoo").mkdir()
    zoo_export.write_zoo(tmp_path / "zoo", [submission], ["core"])
    assert pd.read_parquet(tmp_path / "zoo/policies.parquet")["weights"].tolist() == [""] * 6
    assert pd.read_parquet(tmp_path / "zoo/weights.parquet").empty


def test_without_policies_there_is_no_zoo(make_submission: Callable[..., Path], tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    with pytest.raises(BenchError, match="There are no policies"):
        zoo_export.write_zoo(tmp_path, [make_submission(name="other", policy=None)])
