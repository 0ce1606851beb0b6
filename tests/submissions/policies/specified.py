"""docs/rollout-log.md#arithmetic as plain loops over Python's floats, independent of the package."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np


def exp(x: float) -> float:
    x = -40.0 if x < -40.0 else 40.0 if x > 40.0 else x
    k = math.floor(x * 1.4426950408889634 + 0.5)
    r = (x - k * 0.6931471803691238) - k * 1.9082149292705877e-10
    p = 1 / math.factorial(13)
    for n in reversed(range(13)):
        p = p * r + 1 / math.factorial(n)
    return p * 2.0**k


def f(name: str, x: float) -> float:
    if name == "relu":
        return 0.0 if x < 0 else x
    if name == "leaky_relu":
        return 0.01 * x if x < 0 else x
    if name == "elu":
        return exp(x) - 1.0 if x < 0 else x
    if name == "tanh":
        t = 1.0 - 2.0 / (exp(2.0 * abs(x)) + 1.0)
        return -t if x < 0 else t
    return x * (0.5 * f("tanh", 0.5 * x) + 0.5) if name == "silu" else x


def specified_action(arrays: Mapping[str, Any], observation: Any, task: int = 0) -> list[float]:
    """The action of a deterministic policy for an observation, before it is clipped."""

    def row(name: str, dimensions: int) -> Any:
        values = arrays.get(name)
        if values is None:
            return None
        values = values if values.ndim == dimensions else values[min(task, len(values) - 1)]
        return values.astype(bool if name.startswith("mask") else float).tolist()

    names = {
        key: bytes(arrays[key]).decode()
        for key in ("activation", "output_activation", "squash", "observation_dtype")
    }
    h = np.asarray(observation, names["observation_dtype"]).ravel().astype(float).tolist()
    if (mean := row("observation_mean", 1)) is not None:
        h = [(x - m) / s for x, m, s in zip(h, mean, row("observation_scale", 1), strict=True)]
    if "observation_clip" in arrays:
        c = float(arrays["observation_clip"])
        h = [-c if x < -c else c if x > c else x for x in h]
    layers = sum(name.startswith("weight_") for name in arrays)
    offset = arrays["action_offset"].astype(float).tolist()
    scale = arrays["action_scale"].astype(float).tolist()
    for layer in range(layers):
        weight, mask, total = row(f"weight_{layer}", 2), row(f"mask_{layer}", 2), row(f"bias_{layer}", 1)
        for i, x in enumerate(h):
            for j in range(len(total)):
                total[j] = total[j] + x * (weight[i][j] if mask is None or mask[i][j] else 0.0)
        name = names["activation"] if layer < layers - 1 else names["output_activation"]
        h = [f(name, x) for x in total]
    mean = h if layers else [0.0] * len(offset)
    return [o + s * f(names["squash"], y) for o, s, y in zip(offset, scale, mean, strict=True)]
