"""The forward pass of a plain policy, with the same bits on every processor.

docs/rollout-log.md#arithmetic specifies it. An addition, multiplication or division of float64 has one result
everywhere. Libraries and processors differ in the order of sums, fused multiply-adds and tanh: so the order
is stated, nothing is fused (numba fuses only with ``fastmath``), and the exponential function is defined
here. A row of a batch is computed by itself, so that its action does not depend on the others.
"""

import math

import numpy as np
from numpy.typing import NDArray

from gym_extensions.files import compiled
from gym_extensions.submissions.policies.mlp_arrays import ACTIVATIONS, LEAK

Array = NDArray[np.float64]

LINEAR, TANH, RELU, LEAKY_RELU, ELU, SILU = range(len(ACTIVATIONS))
LARGEST = 40.0
"""Arguments of the exponential function are clipped to ± this: tanh is then 1 and elu −1."""
LOG2_E = 1.4426950408889634
LN2_HIGH, LN2_LOW = 0.6931471803691238, 1.9082149292705877e-10
"""Their sum is ln 2; the first has 32 bits, so that its multiples by small integers are exact."""
C = tuple(1.0 / math.factorial(power) for power in range(14))
"""Of the Taylor polynomial of the exponential function."""
EXPONENT = 2.0**52 + 1023.0
"""k + ``EXPONENT`` has k + 1023, the exponent of 2ᵏ, in its lowest bits."""


@compiled
def exponential(values: Array, scales: Array) -> None:
    """Replaces ``values`` (n,) by their exponential functions; ``scales`` (n,) is scratch memory."""
    for j in range(values.size):
        x = values[j]
        x = -LARGEST if x < -LARGEST else x
        x = LARGEST if x > LARGEST else x
        k = math.floor(x * LOG2_E + 0.5)
        r = (x - k * LN2_HIGH) - k * LN2_LOW
        p = C[13]
        for n in range(12, -1, -1):
            p = p * r + C[n]
        values[j] = p
        scales[j] = k + EXPONENT
    bits = scales.view(np.int64)
    for j in range(values.size):
        bits[j] = bits[j] << 52
    for j in range(values.size):
        values[j] = values[j] * scales[j]


@compiled
def activate(values: Array, kind: int) -> None:
    """Replaces ``values`` (n,) by an activation of them. A value that is no number stays none."""
    n = values.size
    if kind == LINEAR:
        return
    e = np.empty(n)
    if kind in (TANH, ELU, SILU):
        for j in range(n):
            x = values[j]
            e[j] = x if kind == ELU else 2.0 * abs(x if kind == TANH else 0.5 * x)
        exponential(e, np.empty(n))
    for j in range(n):
        x = values[j]
        if kind == RELU:
            values[j] = 0.0 if x < 0.0 else x
        elif kind == LEAKY_RELU:
            values[j] = LEAK * x if x < 0.0 else x
        elif kind == ELU:
            values[j] = e[j] - 1.0 if x < 0.0 else x
        else:
            t = 1.0 - 2.0 / (e[j] + 1.0)
            t = -t if x < 0.0 else t
            values[j] = t if kind == TANH else x * (0.5 * t + 0.5)


@compiled
def dense(inputs: Array, weights: Array, biases: Array) -> Array:
    """The outputs (n, o) of a layer: to each bias, the inputs are added one after another.

    Four inputs are read at once, because that is faster; the order of the additions stays.
    """
    n, m = inputs.shape
    outputs = np.empty((n, biases.size))
    for row in range(n):
        out, seen = outputs[row], inputs[row]
        out[:] = biases
        i = 0
        while i + 3 < m:
            a, b, c, d = seen[i], seen[i + 1], seen[i + 2], seen[i + 3]
            for j in range(out.size):
                total = out[j] + a * weights[i, j]
                total = total + b * weights[i + 1, j]
                total = total + c * weights[i + 2, j]
                out[j] = total + d * weights[i + 3, j]
            i += 4
        while i < m:
            for j in range(out.size):
                out[j] = out[j] + seen[i] * weights[i, j]
            i += 1
    return outputs


@compiled
def forward(  # noqa: PLR0917
    observations: Array,
    normalization: Array,
    bound: float,
    sizes: NDArray[np.int64],
    parameters: Array,
    activation: int,
    output_activation: int,
) -> tuple[Array, Array]:
    """The outputs of a network for observations (n, o), and the inputs of its last layer.

    Args:
        observations: (n, o).
        normalization: (2, o), what is subtracted and then what is divided by.
        bound: normalized observations are clipped to ± this.
        sizes: of the observations and of the outputs of every layer.
        parameters: of every layer the weights (inputs, outputs), then the biases.
        activation, output_activation: of the hidden layers, and of the last one.
    """
    rows, columns = observations.shape
    hidden = np.empty((rows, columns))
    for row in range(rows):
        for i in range(columns):
            x = (observations[row, i] - normalization[0, i]) / normalization[1, i]
            x = -bound if x < -bound else x
            hidden[row, i] = bound if x > bound else x
    before, at = hidden, 0
    for layer in range(1, len(sizes)):
        inputs, outputs = sizes[layer - 1], sizes[layer]
        end = at + inputs * outputs
        weights, biases = parameters[at:end].reshape((inputs, outputs)), parameters[end : end + outputs]
        before, hidden, at = hidden, dense(hidden, weights, biases), end + outputs
        activate(hidden.reshape(-1), activation if layer < len(sizes) - 1 else output_activation)
    return hidden, before
