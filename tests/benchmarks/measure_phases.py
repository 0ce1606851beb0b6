"""Measures where the time of the reference agent goes, and the fastest that its matrix products allow.

    python tests/benchmarks/measure_phases.py --bodies HalfCheetah,Hopper,Walker2d,Humanoid --steps 100000

One JSON line per body, with processor seconds per million training steps on one thread: ``total``;
``physics``, the engine alone in the same states, as in ``make bench``; the phases of training; and
``products``, the matrix products of two phases measured alone, with operands of the same shapes. ``most`` is
physics / (physics + products): the ratio of an implementation of the same formulas in which nothing else
takes time.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import Any

import numpy as np
from test_training import engine_alone, trained, training

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.algorithms import trpo
from gym_extensions.baselines.trpo.settings import REFERENCE
from gym_extensions.baselines.trpo.value_function import ValueFunction
from gym_extensions.catalog.budgets import STANDARD_BUDGET, budget

PHASES = {
    "acting": (trpo.Trpo, "_sample"),
    "environments and physics": (None, "step"),
    "policy update": (trpo, "updated"),
    "value function's fit": (ValueFunction, "fit"),
}
"""Phases by the function that they are, and its owner; None is the training environment."""
REPEATS = 200


@contextmanager
def clocked(env: Any, seconds: dict[str, float]) -> Iterator[None]:
    """Adds the processor seconds of every phase to ``seconds``."""
    saved = []
    for phase, (owner, name) in PHASES.items():
        target = owner or env
        function = getattr(target, name)
        saved.append((target, name, function))
        setattr(target, name, _clocked(function, phase, seconds))
    try:
        yield
    finally:
        for target, name, function in saved:
            setattr(target, name, function)


def _clocked(function: Callable[..., Any], phase: str, seconds: dict[str, float]) -> Callable[..., Any]:
    def wrapped(*arguments: Any, **named: Any) -> Any:
        start = time.process_time()
        result = function(*arguments, **named)
        seconds[phase] += time.process_time() - start
        return result

    return wrapped


def layer_products(rows: int, sizes: tuple[int, ...]) -> tuple[float, float, float]:
    """Seconds of the products of a network's layers: forward, for the weights' gradient, for the inputs'."""
    rng = np.random.default_rng(0)
    forward = weights = inputs = 0.0
    for layer, (fan_in, fan_out) in enumerate(pairwise(sizes)):
        values = rng.standard_normal((rows, fan_in), np.float32)
        matrix = rng.standard_normal((fan_in, fan_out), np.float32)
        upstream = rng.standard_normal((rows, fan_out), np.float32)
        forward += _seconds(values, matrix)
        weights += _seconds(values.T, upstream)
        inputs += _seconds(upstream, matrix.T) if layer else 0.0
    return forward, weights, inputs


def _seconds(left: Array, right: Array) -> float:
    start = time.process_time()
    for _ in range(REPEATS):
        left @ right
    return (time.process_time() - start) / REPEATS


def products_per_batch(observations: int, actions: int, batch: int) -> dict[str, float]:
    """Seconds of the matrix products of one batch, by phase.

    The line search is counted with one try, and acting and the value function's predictions not at all.
    """
    value = REFERENCE.value
    minibatch = min(value.largest_minibatch, max(value.smallest_minibatch, -(-batch // value.minibatches)))
    descents = value.epochs * -(-batch // minibatch)
    fit = descents * sum(layer_products(minibatch, (observations, *value.hidden, 1)))
    forward, weights, inputs = layer_products(batch, (observations, *REFERENCE.hidden, actions))
    # A Fisher product: the derivative along a direction is one product per layer for the weights and one for
    # the layer before, then the gradient.
    fisher = REFERENCE.trust_region.iterations * (forward + 2 * inputs + weights)
    return {"policy update": fisher + forward + weights + inputs + 3 * forward, "value function's fit": fit}


def measured(body: str, steps: int) -> dict[str, Any]:
    """The line of one body."""
    standard = budget(STANDARD_BUDGET)
    agent, env = trained("trpo", body, standard, standard.num_envs, 1)
    learn = training(agent, env, steps, time.process_time)
    learn()  # caches and the first resets
    vector_steps = steps // standard.num_envs
    engine = engine_alone(agent, body, standard.num_envs, 1, vector_steps, clock=time.process_time)
    seconds = dict.fromkeys(PHASES, 0.0)
    with clocked(env, seconds):
        taken, total = learn()
    physics_taken, physics = engine()
    million = 1e6 / taken
    engine_seconds = physics * 1e6 / physics_taken
    observations, actions = env.single_observation_space.shape[0], env.single_action_space.shape[0]
    batch = standard.batch_steps
    products = {
        name: value * 1e6 / batch for name, value in products_per_batch(observations, actions, batch).items()
    }
    return {
        "body": body,
        "total": round(total * million, 1),
        "physics": round(engine_seconds, 1),
        "phases": {name: round(value * million, 1) for name, value in seconds.items()},
        "products": {name: round(value, 1) for name, value in products.items()},
        "ratio": round(engine_seconds / (total * million), 3),
        "most": round(engine_seconds / (engine_seconds + sum(products.values())), 3),
    }


def main() -> None:
    as_written = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=as_written)
    parser.add_argument("--bodies", default="HalfCheetah,Hopper")
    parser.add_argument("--steps", type=int, default=100_000)
    options = parser.parse_args()
    for body in options.bodies.split(","):
        sys.stdout.write(json.dumps(measured(body, options.steps)) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
