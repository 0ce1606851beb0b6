"""Loading the policies of submissions, and converting them."""

from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest

from gym_extensions import policies
from gym_extensions.errors import BenchError
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.run import read_run, write_run

RUN = "hopper-gravity/sequential/run0.json"


@pytest.fixture
def submission(make_submission: Callable[..., Path]) -> Path:
    return make_submission(runs=(0,))


def test_a_policy_is_loaded_by_run_and_stage_by_default_the_last_one_or_by_task(submission: Path) -> None:
    policy = policies.load(submission, "hopper-gravity", run=0, stage=2)
    last = policies.load(str(submission), "hopper-gravity")
    assert policy.act(np.zeros(11), np.random.default_rng(0)).shape == (3,)
    assert last.act(np.zeros((4, 11)), np.random.default_rng(0)).shape == (4, 3)
    single = policies.load(submission, "hopper-gravity", task="HopperGravityHalf", protocol="single")
    assert single.num_actions == 3


def test_an_address_needs_the_digest_of_its_file(submission: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(submission.parent / "cache"))
    url = submission.joinpath(RUN).with_suffix(".npz").as_uri()
    stated = read_run(submission / RUN).policies
    assert stated is not None
    assert policies.load(url, "hopper-gravity", stage=1, sha256=stated.sha256).num_actions == 3
    with pytest.raises(BenchError, match="needs a digest"):
        policies.load(url, "hopper-gravity")
    with pytest.raises(BenchError, match="have the digest"):
        policies.load(url, "hopper-gravity", sha256="0" * 64)


def test_policies_that_lie_elsewhere_are_fetched(submission: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(submission.parent / "cache"))
    document = read_run(submission / RUN)
    assert document.policies is not None
    file = submission.joinpath(RUN).with_suffix(".npz").rename(submission.parent / "elsewhere.npz")
    there = msgspec.structs.replace(document.policies, url=file.as_uri())
    write_run(submission / RUN, msgspec.structs.replace(document, policies=there))
    assert policies.load(submission, "hopper-gravity").num_actions == 3


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"run": 7}, "has no run 7"),
        ({"stage": 9}, "stages are 0 to 5"),
        ({"task": "Hopper"}, "a stage and no task"),
        ({"protocol": "single", "task": "Hoper"}, "Did you mean 'Hopper'"),
        ({"protocol": "sequence"}, "Did you mean 'sequential'"),
    ],
)
def test_what_does_not_exist_is_named(submission: Path, arguments: dict[str, object], named: str) -> None:
    with pytest.raises(BenchError, match=named):
        policies.load(submission, "hopper-gravity", **arguments)  # type: ignore[arg-type]


def made(activation: str, dtype: str, rows: bool) -> Policy:
    """A Gaussian policy that uses every part of the format, with arrays per task or without."""
    rng, lead = np.random.default_rng(0), (2,) if rows else ()

    def draw(*shape: int) -> np.ndarray:
        return rng.normal(0, 0.5, (*lead, *shape)).astype(dtype)

    return Policy(
        action_offset=rng.normal(size=2),
        action_scale=np.array([0.5, 2.0]),
        weights=(draw(4, 5), draw(5, 2)),
        biases=(draw(5), draw(2)),
        masks=(draw(4, 5) > 0, None),
        activation=activation,
        output_activation="tanh",
        squash="tanh",
        head="gaussian",
        log_sigma=draw(2),
        log_sigma_weight=draw(5, 2),
        log_sigma_clip=np.array([-1.0, 0.5]),
        observation_dtype="float64",
        observation_mean=draw(4),
        observation_scale=np.exp(draw(4)),
        observation_clip=1.5,
    )


@pytest.mark.parametrize("rows", [False, True], ids=["shared", "per task"])
@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("activation", ["linear", "tanh", "relu", "leaky_relu", "elu", "silu"])
def test_pytorch_and_onnx_act_as_numpy_does(activation: str, dtype: str, rows: bool) -> None:
    torch = pytest.importorskip("torch")
    pytest.importorskip("onnxruntime", reason="needs the extra onnx")
    policy, task = made(activation, dtype, rows), int(rows)
    observations = np.random.default_rng(1).normal(size=(6, 4))
    expected = policy.act(observations, np.random.default_rng(2), task)
    network = policies.OnnxPolicy(policy.to_onnx(task=task))
    np.testing.assert_allclose(network.act(observations, np.random.default_rng(2)), expected, rtol=1e-4)
    noise = np.random.default_rng(2).standard_normal((6, 2))
    actions = policy.to_torch(task)(torch.tensor(observations), torch.tensor(noise))
    np.testing.assert_allclose(actions.detach().numpy(), expected, rtol=1e-4)


def test_a_network_is_written_and_read(tmp_path: Path) -> None:
    pytest.importorskip("torch")
    pytest.importorskip("onnxruntime", reason="needs the extra onnx")
    made("relu", "float32", rows=False).to_onnx(tmp_path / "policy.onnx")
    policy = policies.OnnxPolicy.load(tmp_path / "policy.onnx")
    assert (policy.num_inputs, policy.num_actions, policy.head) == (4, 2, "gaussian")
    (tmp_path / "other.onnx").write_bytes(b"no network")
    for name, fact in (("missing", "cannot be read"), ("other", "not an ONNX model")):
        with pytest.raises(BenchError, match=f"{name}.onnx: .*{fact}"):
            policies.OnnxPolicy.load(tmp_path / f"{name}.onnx")


def test_a_policy_without_layers_is_not_converted(submission: Path) -> None:
    pytest.importorskip("torch")
    policy = policies.load(submission, "hopper-gravity")
    assert isinstance(policy, Policy)
    with pytest.raises(BenchError, match="The policy is uniform"):
        policy.to_torch()
