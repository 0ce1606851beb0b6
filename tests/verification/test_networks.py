"""Entries whose policies are ONNX networks: recorded, checked and verified."""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("torch")
pytest.importorskip("onnx", reason="needs the extra onnx")
pytest.importorskip("onnxruntime", reason="needs the extra onnx")


from gym_extensions.catalog.groups import group
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies.files import content_sha256, network_files, read_arrays
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.review import read_review
from gym_extensions.rollouts.run import PolicyFile, read_run
from gym_extensions.verification import episodes
from gym_extensions.verification.verify import repetition, runs_of
from gym_extensions.versions import version

from ..rollouts.policies.networks import endless
from .entries import change_document, verify

PAGE = Path(__file__).parents[2] / "docs" / "policies.md"


@pytest.fixture(scope="session")
def documented(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The entry of the documented program."""
    folder = tmp_path_factory.mktemp("documented")
    *_, code = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert len(code.splitlines()) <= 15
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        exec(code.replace("range(100 ", "range(2 "), {})
    return folder / "mine"


@pytest.fixture
def entry(documented: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(documented, tmp_path / "mine", ignore=shutil.ignore_patterns(".progress")))


def test_the_documented_module_of_pytorch_becomes_a_verified_entry(entry: Path) -> None:
    files = sorted(path.name for path in (entry / "hopper-wall/sequential").iterdir())
    assert files == ["run0.csv", "run0.json", *(f"run0.stage{stage}.onnx" for stage in range(3))]
    assert read(entry, policies=True).problems == ()
    assert verify(entry, "--write") == 0
    (record,) = read_review(entry).verifications
    assert (record.passed, record.repeated) == (True, record.episodes)
    assert record.runtime == f"onnxruntime {version('onnxruntime')}"
    document = read_run(entry / "hopper-wall/sequential/run0.json")
    assert document.packages["onnxruntime"] == version("onnxruntime")


@pytest.mark.parametrize(("factor", "is_repeated"), [(1.0005, True), (1.002, False)])
def test_a_return_of_a_network_is_repeated_within_a_tolerance(
    entry: Path, factor: float, is_repeated: bool
) -> None:
    (run,) = runs_of(read(entry, merge_runs=False)).values()
    outcomes = tuple(
        tuple(each._replace(return_=each.return_ * factor) for each in part) for part in run.logged.values()
    )
    found = repetition(run, run.prescribed, episodes.Played(outcomes, runtime="onnxruntime"))
    assert found.repeated == (found.episodes if is_repeated else 0)
    assert repetition(run, run.prescribed, episodes.Played(outcomes)).repeated == 0


def replace_networks(entry: Path, data: bytes) -> None:
    """Writes another network for every stage, and states the digest."""
    for path in network_files(entry, "hopper-wall", "sequential", 0):
        path.write_bytes(data)
    digest = content_sha256(read_arrays(entry, group("hopper-wall"), "sequential", 0))
    change_document(
        entry / "hopper-wall/sequential/run0.json", policies=PolicyFile(sha256=digest, size=3 * len(data))
    )


def test_a_network_with_an_operator_that_is_not_allowed_is_a_problem_of_its_stage(entry: Path) -> None:
    (first, *_) = network_files(entry, "hopper-wall", "sequential", 0)
    replace_networks(entry, first.read_bytes().replace(b"Gemm", b"Gimm"))
    (problem, *_) = read(entry, policies=True).problems
    assert problem.rule == "malformed-policy"
    assert problem.where.endswith("run0.stage0.onnx")
    assert "stage0: The operator 'Gimm' is not allowed." in problem.message
    assert verify(entry) == 1


@pytest.mark.parametrize(
    ("damage", "rule", "where"),
    [
        (lambda first, second, _: shutil.copy(first, second), "exchanged-policies", ".json, policies"),
        (lambda first, second, _: second.unlink(), "different-policies", ".stage1.onnx"),
        (lambda *files: [file.unlink() for file in files], "different-policies", ".json, policies"),
        (lambda first, *_: first.write_bytes(b"version https://git-lfs"), "exchanged-policies", "LFS"),
    ],
    ids=["exchanged", "one missing", "all missing", "pointers"],
)
def test_what_is_wrong_with_the_files_of_networks_is_found_to_score_and_at_the_gate(
    entry: Path, damage: Callable[..., object], rule: str, where: str
) -> None:
    damage(*network_files(entry, "hopper-wall", "sequential", 0))
    (problem,) = read(entry).problems
    assert (problem.rule, problem in read(entry, policies=True).problems) == (rule, True)
    assert where in f"{problem.where} {problem.hint}"
    assert "npz" not in problem.where


def test_a_network_that_never_ends_is_not_verified(entry: Path, capsys: pytest.CaptureFixture[str]) -> None:
    replace_networks(entry, endless(21, 3))
    assert verify(entry) == 1
    out = capsys.readouterr().out
    assert "1 run." in out
    assert "A step took more than 5 seconds." in out
    assert "p =" not in out


def test_where_the_runtime_is_missing_nothing_is_decided(
    entry: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    found = read(entry, merge_runs=False)
    (run,) = runs_of(found).values()
    request = run.request(found, entry, run.prescribed[:1])
    with pytest.raises(BenchError, match=r"gym-extensions\[onnx\]"):
        episodes.played(request, group("hopper-wall"))
