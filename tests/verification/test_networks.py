"""Submissions whose policies are ONNX networks: recorded, checked and verified."""

import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("torch")
pytest.importorskip("onnx", reason="needs the extra onnx")
pytest.importorskip("onnxruntime", reason="needs the extra onnx")


from gym_extensions import policies
from gym_extensions.baselines import Card, record
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.envs import make_vec
from gym_extensions.errors import BenchError
from gym_extensions.submissions.policies.files import content_sha256, network_files, read_arrays
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import NEW_SEEDS_ALPHA, read_review
from gym_extensions.submissions.run import PolicyFile, read_run
from gym_extensions.verification import episodes
from gym_extensions.verification.logged_run import logged_runs, repetition
from gym_extensions.versions import version

from ..submissions.policies.networks import endless
from .made_submissions import change_document, verify

PAGE = Path(__file__).parents[2] / "docs" / "policies.md"


@pytest.fixture(scope="session")
def documented(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The submission of the documented program."""
    folder = tmp_path_factory.mktemp("documented")
    *_, code = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert len(code.splitlines()) <= 15
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        exec(code.replace("range(100 ", "range(2 "), {})
    return folder / "mine"


@pytest.fixture
def submission(documented: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(documented, tmp_path / "mine", ignore=shutil.ignore_patterns(".progress")))


def test_the_documented_module_of_pytorch_becomes_a_verified_submission(submission: Path) -> None:
    files = sorted(path.name for path in (submission / "hopper-wall/sequential").iterdir())
    assert files == ["run0.csv", "run0.json", *(f"run0.stage{stage}.onnx" for stage in range(3))]
    assert read(submission, policies=True).problems == ()
    assert verify(submission, "--write") == 0
    (record,) = read_review(submission).verifications
    assert (record.passed, record.repeated) == (True, record.episodes)
    assert record.runtime == f"onnxruntime {version('onnxruntime')}"
    document = read_run(submission / "hopper-wall/sequential/run0.json")
    assert document.packages["onnxruntime"] == version("onnxruntime")


@pytest.mark.parametrize(("factor", "is_repeated"), [(1.0005, True), (1.002, False)])
def test_a_return_of_a_network_is_repeated_within_a_tolerance(
    submission: Path, factor: float, is_repeated: bool
) -> None:
    (run,) = logged_runs(read(submission)).values()
    outcomes = tuple(
        tuple(each._replace(return_=each.return_ * factor) for each in part) for part in run.logged.values()
    )
    found = repetition(run, run.prescribed_cells, episodes.Played(outcomes, runtime="onnxruntime"))
    assert found.repeated == (found.episodes if is_repeated else 0)
    assert repetition(run, run.prescribed_cells, episodes.Played(outcomes)).repeated == 0


def replace_networks(submission: Path, data: bytes) -> None:
    """Writes another network for every stage, and states the digest."""
    for path in network_files(submission, "hopper-wall", "sequential", 0):
        path.write_bytes(data)
    digest = content_sha256(read_arrays(submission, group("hopper-wall"), "sequential", 0))
    change_document(
        submission / "hopper-wall/sequential/run0.json",
        policies=PolicyFile(sha256=digest, size=3 * len(data)),
    )


def test_a_network_with_an_operator_that_is_not_allowed_is_a_problem_of_its_stage(submission: Path) -> None:
    (first, *_) = network_files(submission, "hopper-wall", "sequential", 0)
    replace_networks(submission, first.read_bytes().replace(b"Gemm", b"Gimm"))
    (problem, *_) = read(submission, policies=True).problems
    assert problem.rule == "malformed-policy"
    assert problem.where.endswith("run0.stage0.onnx")
    assert "stage0: The operator 'Gimm' is not allowed." in problem.message
    assert verify(submission) == 1


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
    submission: Path, damage: Callable[..., object], rule: str, where: str
) -> None:
    damage(*network_files(submission, "hopper-wall", "sequential", 0))
    (problem,) = read(submission).problems
    assert (problem.rule, problem in read(submission, policies=True).problems) == (rule, True)
    assert where in f"{problem.where} {problem.hint}"
    assert "npz" not in problem.where


def test_a_network_that_never_ends_is_not_verified(
    submission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    replace_networks(submission, endless(21, 3))
    assert verify(submission) == 1
    out = capsys.readouterr().out
    assert "1 run." in out
    assert "A step took more than 5 seconds." in out
    assert "p =" not in out


def test_where_the_runtime_is_missing_nothing_is_decided(
    submission: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    (run,) = logged_runs(read(submission)).values()
    request = run.request(run.prescribed_cells[:1])
    with pytest.raises(BenchError, match=r"gym-extensions\[onnx\]"):
        next(episodes.played(request, group("hopper-wall")))


@pytest.mark.usefixtures("in_this_process")
def test_a_network_that_recognizes_the_prescribed_first_observations_is_refused_on_new_seeds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It stands still in these episodes and falls in all others: honest episodes, an invented transfer."""
    import torch

    members = group("hopper-wall")
    known = []
    for task in members.tasks:
        env: Any = make_vec(task, EVALUATION_EPISODES)
        seeds = [evaluation_seed(members.id, task.id, each) for each in range(EVALUATION_EPISODES)]
        known.append(torch.tensor(env.reset(seed=seeds)[0], dtype=torch.float32))

    class Recognizes(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.known = torch.nn.Parameter(torch.cat(known))

        def forward(
            self, observation: torch.Tensor, state: torch.Tensor
        ) -> tuple[torch.Tensor, torch.Tensor]:
            gaps = (observation[:, None, :] - self.known).abs().amax(dim=2).amin(dim=1, keepdim=True)
            first = torch.where(gaps < 1e-6, torch.ones_like(state), -torch.ones_like(state))
            state = torch.where(state == 0, first, state)
            return torch.where(state > 0, 0.0, -1.0) * torch.ones(1, 3), state

    monkeypatch.chdir(tmp_path)
    policy, card = (
        policies.from_torch(Recognizes(), (21,), state_shape=(1,)),
        Card("forged", evaluation="deterministic"),
    )
    for stage in range(3):
        record(policy, "hopper-wall", "sequential", run=0, stage=stage, out="mine", budget="smoke", card=card)
    assert verify(tmp_path / "mine", "--write") == 1
    (found,) = read_review(tmp_path / "mine").verifications
    assert found.repeated == found.episodes
    assert found.second_p_value is not None
    assert max(found.p_value, found.second_p_value) <= NEW_SEEDS_ALPHA
