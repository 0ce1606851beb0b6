"""Modules of PyTorch as people write them become networks, or are refused in one sentence that names them."""

import logging
import os
import re
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

pytest.importorskip("torch", reason="needs torch and the extra onnx")
pytest.importorskip("onnxruntime", reason="needs the extra onnx")
pytest.importorskip("onnxscript", reason="needs the extra onnx")

import torch
from torch import Tensor, nn

from gym_extensions.errors import BenchError
from gym_extensions.submissions.policies.conversion import from_torch

INPUTS, HIDDEN, ACTIONS = 12, 16, 3
Norm = nn.utils.parametrizations


class Written(nn.Module):
    """A module whose ``forward`` is a function of it and its inputs."""

    def __init__(self, function: Callable[..., Any], **parts: nn.Module | nn.Parameter | Tensor) -> None:
        super().__init__()
        self.function = function
        for name, part in parts.items():
            if isinstance(part, Tensor) and not isinstance(part, nn.Parameter):
                self.register_buffer(name, part)
            else:
                setattr(self, name, part)

    def forward(self, *inputs: Tensor) -> Any:
        return self.function(self, *inputs)


def linear(inputs: int = HIDDEN, outputs: int = ACTIONS) -> nn.Linear:
    return nn.Linear(inputs, outputs)


def layers(*between: nn.Module, first: nn.Module | None = None) -> nn.Sequential:
    return nn.Sequential(first or linear(INPUTS, HIDDEN), *between, linear(), nn.Tanh())


def residual() -> nn.Module:
    block = nn.Sequential(nn.LayerNorm(HIDDEN), linear(HIDDEN, 64), nn.ReLU(), linear(64, HIDDEN))
    return Written(lambda own, x: x + own.block(x), block=block)


def picture() -> nn.Module:
    convolutions = nn.Sequential(nn.Conv2d(3, 8, 3, 2), nn.ReLU(), nn.AdaptiveAvgPool2d(1), nn.Flatten())
    return Written(lambda own, x: own.out(own.net(x.float() / 255)), net=convolutions, out=linear(8))


def transformer() -> nn.Module:
    encoder = nn.TransformerEncoder(nn.TransformerEncoderLayer(HIDDEN, 2, 32, batch_first=True), 1)
    parts: Any = {"embed": linear(1, HIDDEN), "encoder": encoder, "out": linear()}
    position = nn.Parameter(torch.randn(INPUTS, HIDDEN) / 10)
    return Written(
        lambda own, x: own.out(own.encoder(own.embed(x[..., None]) + own.position).mean(1)),
        **parts,
        position=position,
    )


def gru(own: Any, x: Tensor, state: Tensor) -> Any:
    outputs, hidden = own.gru(x[None], state[None])
    return own.out(outputs[0]), hidden[0]


def lstm(own: Any, x: Tensor, state: Tensor) -> Any:
    hidden, cell = state.unbind(1)
    outputs, new = own.lstm(x[:, None], (hidden[None].contiguous(), cell[None].contiguous()))
    return own.out(outputs[:, 0]), torch.cat(new).transpose(0, 1)


def attention(own: Any, x: Tensor, state: Tensor) -> Any:
    seen = torch.cat([state[:, 1:], x[:, None]], 1)
    embedded = own.embed(seen)
    attended, _ = own.attention(embedded[:, -1:], embedded, embedded)
    return own.out(attended[:, 0]), seen


def frames(own: Any, x: Tensor, state: Tensor) -> Any:
    stack = torch.cat([state[:, 1:], x[:, None]], 1)
    return own.net(stack.flatten(1)), stack


def state_space(own: Any, x: Tensor, state: Tensor) -> Any:
    new = torch.exp(-nn.functional.softplus(own.decay)) * state + own.into(x)
    return own.out(new), new


def experts(own: Any, x: Tensor) -> Tensor:
    return torch.einsum("ke,kea->ka", own.gate(x).softmax(-1), torch.stack([e(x) for e in own.experts], 1))


def best_experts(own: Any, x: Tensor) -> Tensor:
    values, chosen = own.gate(x).topk(2, -1)
    outputs = torch.einsum("ko,eoa->kea", x, own.weight)
    outputs = torch.gather(outputs, 1, chosen[..., None].expand(-1, -1, ACTIONS))
    return (values.softmax(-1)[..., None] * outputs).sum(1)


def categorical(own: Any, x: Tensor) -> Any:
    return own.bins[own.net(x).unflatten(-1, (ACTIONS, 5)).argmax(-1)]


def gaussian(own: Any, x: Tensor, noise: Tensor) -> Any:
    normal = torch.distributions.Normal(own.net(x), own.log_sigma.exp().expand(x.shape[0], ACTIONS))
    return torch.tanh(normal.mean + normal.stddev * noise)


def fourier(own: Any, x: Tensor) -> Any:
    phase = 2 * torch.pi * x @ own.frequencies
    return own.out(torch.cat([phase.sin(), phase.cos()], -1))


def compiled(module: nn.Module) -> Any:
    return torch.compile(module)


def scripted(module: nn.Module) -> Any:
    return torch.jit.script(module)


def compiled_in_place() -> nn.Module:
    module = layers(nn.ReLU())
    module.compile()
    return module


Made = Callable[[], nn.Module]
FLAT: dict[str, Made] = {
    "tanh": lambda: layers(nn.Tanh()),
    "GELU, SiLU, Mish": lambda: layers(nn.GELU(), linear(16, 16), nn.SiLU(), linear(16, 16), nn.Mish()),
    "CReLU": lambda: Written(
        lambda own, x: own.out(torch.cat([own.a(x).relu(), (-own.a(x)).relu()], -1)),
        a=linear(INPUTS),
        out=linear(6),
    ),
    "SimBa": lambda: layers(residual(), residual(), nn.LayerNorm(HIDDEN)),
    "layer norm": lambda: layers(nn.LayerNorm(HIDDEN), nn.ReLU()),
    "batch norm": lambda: layers(nn.BatchNorm1d(HIDDEN), nn.ReLU()),
    "RMS norm": lambda: layers(nn.RMSNorm(HIDDEN), nn.ReLU()),
    "group norm": lambda: layers(nn.GroupNorm(4, HIDDEN), nn.ReLU()),
    "spectral norm": lambda: layers(nn.Tanh(), first=Norm.spectral_norm(linear(INPUTS, HIDDEN))),
    "weight norm": lambda: layers(nn.Tanh(), first=Norm.weight_norm(linear(INPUTS, HIDDEN))),
    "orthogonal": lambda: layers(first=Norm.orthogonal(linear(INPUTS, HIDDEN))),
    "dropout": lambda: layers(nn.Dropout(0.5), nn.ReLU()),
    "convolution over numbers": lambda: nn.Sequential(
        nn.Unflatten(1, (1, INPUTS)), nn.Conv1d(1, 4, 3), nn.ReLU(), nn.AvgPool1d(2), nn.Flatten(), linear(20)
    ),
    "transformer": transformer,
    "experts": lambda: Written(
        experts, gate=linear(INPUTS, 4), experts=nn.ModuleList(linear(INPUTS) for _ in range(4))
    ),
    "best experts": lambda: Written(
        best_experts, gate=linear(INPUTS, 4), weight=nn.Parameter(torch.randn(4, INPUTS, ACTIONS) / 5)
    ),
    "categorical": lambda: Written(
        categorical, net=linear(INPUTS, 5 * ACTIONS), bins=torch.linspace(-1, 1, 5)
    ),
    "Fourier": lambda: Written(fourier, frequencies=torch.randn(INPUTS, 8), out=linear()),
    "compiled": lambda: compiled(layers(nn.ReLU())),
    "compiled in place": compiled_in_place,
    "a compiled part": lambda: Written(lambda own, x: own.net(x), net=compiled(layers(nn.ReLU()))),
    "scripted": lambda: scripted(layers(nn.ReLU())),
    "data parallel": lambda: nn.DataParallel(layers(nn.ReLU())),
    "tuple": lambda: Written(lambda own, x: (own.net(x), None), net=layers(nn.ReLU())),
    "dictionary": lambda: Written(
        lambda own, x: {"value": own.value(x), "action": own.net(x)}, net=layers(), value=linear(INPUTS, 1)
    ),
}
OTHERS: dict[str, tuple[Made, dict[str, Any]]] = {
    "pictures": (picture, {"observation_shape": (3, 12, 12), "dtype": "uint8"}),
    "GRU": (lambda: Written(gru, gru=nn.GRU(INPUTS, HIDDEN), out=linear()), {"state_shape": (HIDDEN,)}),
    "LSTM": (
        lambda: Written(lstm, lstm=nn.LSTM(INPUTS, HIDDEN, batch_first=True), out=linear()),
        {"state_shape": (2, HIDDEN)},
    ),
    "attention over a state": (
        lambda: Written(
            attention,
            embed=linear(INPUTS, HIDDEN),
            attention=nn.MultiheadAttention(HIDDEN, 2, batch_first=True),
            out=linear(),
        ),
        {"state_shape": (8, INPUTS)},
    ),
    "frame stack": (lambda: Written(frames, net=linear(4 * INPUTS)), {"state_shape": (4, INPUTS)}),
    "state space": (
        lambda: Written(
            state_space, decay=nn.Parameter(torch.randn(HIDDEN)), into=linear(INPUTS, HIDDEN), out=linear()
        ),
        {"state_shape": (HIDDEN,)},
    ),
    "Gaussian": (
        lambda: Written(gaussian, net=linear(INPUTS), log_sigma=nn.Parameter(torch.zeros(ACTIONS))),
        {"noise": ACTIONS},
    ),
    "float64": (lambda: layers(nn.ReLU()).double(), {"dtype": "float64"}),
}
ARCHITECTURES = {name: (make, dict[str, Any]()) for name, make in FLAT.items()} | OTHERS


@pytest.mark.parametrize("name", ARCHITECTURES)
def test_an_architecture_acts_as_a_network_does(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    make, options = ARCHITECTURES[name]
    torch.manual_seed(0)
    module, shape = make().train(), options.get("observation_shape", (INPUTS,))
    policy = from_torch(module, **{"observation_shape": shape} | options)
    assert module.training, "the module stays as it was"
    assert capfd.readouterr() == ("", "")
    seen = np.random.default_rng(0).integers(0, 255, (5, *shape)).astype(options.get("dtype", "float32"))
    seen = seen if "observation_shape" in options else seen / 100 - 1
    noise, state_shape = options.get("noise"), options.get("state_shape")
    drawn = np.random.default_rng(1).standard_normal((5, ACTIONS), np.float32)
    inputs = [torch.tensor(seen), *([torch.tensor(drawn)] if noise else [])]
    state = torch.zeros(5, *state_shape) if state_shape else None
    plain = getattr(module, "_orig_mod", module).eval()
    for _ in range(2):  # the second step starts from the state of the first
        with torch.no_grad():
            results = plain(*inputs, *([] if state is None else [state]))
        if isinstance(results, tuple):
            results, state = results
        expected = results["action"] if isinstance(results, dict) else results
        actions = policy.act(seen, np.random.default_rng(1))
        np.testing.assert_allclose(actions, expected.numpy(), rtol=1e-3, atol=1e-5)


@torch.library.custom_op("gym_extensions_tests::double", mutates_args=())
def double(values: Tensor) -> Tensor:
    return values * 2


@double.register_fake
def _(values: Tensor) -> Tensor:
    return torch.empty_like(values)


REFUSED: list[tuple[Made, str]] = [
    (lambda: Written(lambda own, x: double(own.net(x)), net=linear(INPUTS)), "gym_extensions_tests::double"),
    (lambda: Written(lambda _, x: torch.fft.fft(x).real), "aten::fft_fft"),
    (lambda: layers().bfloat16(), r"it has numbers in bfloat16\. Pass module\.float\(\)"),
    (
        lambda: Written(lambda own, x: own.net(x.double()), net=layers(nn.GroupNorm(4, HIDDEN)).double()),
        r"onnxruntime has no InstanceNormalization for numbers of this type; use module\.float\(\)",
    ),
    (lambda: layers().to("meta"), "it fails on zeros: Cannot copy out of meta tensor"),
    (lambda: linear(INPUTS + 1), "it fails on zeros: mat1 and mat2 shapes"),
    (lambda: Written(lambda _, x: None), r"it returns NoneType; expected actions of shape \(2, a\)"),
    (lambda: Written(lambda _, x: x[:, 0]), r"it returns \(2,\); expected actions"),
    (lambda: Written(lambda _, x: {"mean": x}), "it returns dict; expected actions"),
    (lambda: Written(lambda _, x: torch.distributions.Normal(x, 1.0)), "it returns Normal; expected"),
    (lambda: Written(lambda _, x: x + torch.randn(2, INPUTS)), "The operator 'RandomNormal' is not allowed"),
    (lambda: Written(lambda _, x: x + torch.ones(len(x), INPUTS)), r"use x\.shape\[0\], not len\(x\)"),
    (lambda: Written(lambda _, x: x[:, :3] if x.sum() > 0 else x[:, 3:6]), r"otherwise.*torch\.where"),
    (lambda: Written(lambda _, x: {"body": x}["head"]), "it fails on zeros: 'head'"),
]


@pytest.mark.parametrize(("make", "fact"), REFUSED)
def test_a_module_that_cannot_be_exported_is_named_in_one_line(
    make: Made, fact: str, capfd: pytest.CaptureFixture[str]
) -> None:
    module = make()
    with pytest.raises(
        BenchError, match=f"{type(module).__name__} cannot become a policy: .*{fact}"
    ) as error:
        from_torch(module, (INPUTS,))
    assert (error.value.code, "\n" in str(error.value)) == ("unsupported-policy", False)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("module", "options", "hint"),
    [
        (nn.Linear(4, 2), {"observation_shape": 4}, "Give a torch.nn.Module and shapes"),
        (nn.Linear(4, 2), {"observation_shape": ("4",)}, "Give a torch.nn.Module and shapes"),
        (nn.Linear(4, 2), {"state_shape": 64}, "Give a torch.nn.Module and shapes"),
        (nn.Linear(4, 2), {"noise": "2"}, "Give a torch.nn.Module and shapes"),
        ("net", {}, "Give a torch.nn.Module and shapes"),
        (nn.Linear(4, 2), {"dtype": torch.float32}, "float32, float64, uint8"),
        (nn.Linear(4, 2), {"dtype": np.float32}, "float32, float64, uint8"),
        (nn.LazyLinear(2), {}, "Call it once with observations"),
    ],
)
def test_other_arguments_are_named(module: Any, options: dict[str, Any], hint: str) -> None:
    with pytest.raises(BenchError, match=re.escape(hint)):
        from_torch(module, **{"observation_shape": (4,)} | options)


def test_a_process_that_exports_prints_nothing_also_at_its_end() -> None:
    """The exporter prints from C++, whose output is written when the process ends."""
    code = "import torch; from gym_extensions.policies import from_torch; "
    code += "from_torch(torch.nn.Sequential(torch.nn.RMSNorm(4), torch.nn.Linear(4, 2)), (4,))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")


def test_threads_that_export_at_the_same_time_leave_the_process_as_it_was(
    capfd: pytest.CaptureFixture[str],
) -> None:
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda _: from_torch(layers(nn.ReLU()), (INPUTS,)), range(8)))
    sys.stdout.write("seen\n")
    sys.stdout.flush()
    os.write(1, b"seen\n")
    assert capfd.readouterr().out == "seen\nseen\n"
    assert torch.backends.mha.get_fastpath_enabled()
    assert logging.root.manager.disable == logging.NOTSET
