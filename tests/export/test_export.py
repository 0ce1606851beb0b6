"""`gym-extensions export`: what other projects get, in a new folder, whole or not at all."""

import hashlib
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.export import cli, hugging_face
from gym_extensions.references import experts
from gym_extensions.results.frames import EPISODE_DTYPES
from gym_extensions.scoring.pipeline import make_scorer
from gym_extensions.submissions.review import Decision, Review, write_review

SUBMISSION = Path(__file__).resolve().parents[2] / "submissions" / "trpo"
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


def test_a_decision_is_stated(make_submission: Callable[..., Path], tmp_path: Path) -> None:
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
    assert [field["name"] for field in records["field"]] == list(EPISODE_DTYPES)
    assert content.splitlines()[0].decode().split(",") == list(EPISODE_DTYPES)


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
