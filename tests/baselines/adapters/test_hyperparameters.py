"""Hyperparameters that the manifest cannot store become text, the same in every process."""

from __future__ import annotations

import functools
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines.adapters.sb3_agent import to_manifest_value


@pytest.mark.parametrize("value", ["relu", 3, 0.5, True, [400, 300], []])
def test_a_plain_value_is_unchanged(value: Any) -> None:
    assert to_manifest_value(value) == value


def test_a_tuple_becomes_a_list() -> None:
    assert to_manifest_value((8, "step")) == [8, "step"]


class Relu:
    """A class, such as a network's activation function."""


def linear(progress: float) -> float:
    return progress / 2


TEXTS = [
    (None, "None"),
    (float("inf"), "inf"),
    ({"net_arch": [400, 300]}, "{'net_arch': [400, 300]}"),
    ({"net_arch": {"pi": [64], "vf": (32,)}}, "{'net_arch': {'pi': [64], 'vf': [32]}}"),
    ({"activation_fn": Relu}, "{'activation_fn': Relu}"),
    (Relu(), "Relu"),
    (linear, "linear"),
    (np.array([0.5, 1.0]), "[0.5, 1.0]"),
    (np.float32(0.5), "0.5"),
    ([[1, 2], [3]], "[[1, 2], [3]]"),
    ({"b", "a"}, "{'a', 'b'}"),
    (functools.partial(linear, progress=1), "functools.partial(<function linear>, progress=1)"),
]


@pytest.mark.parametrize(("value", "text"), TEXTS, ids=[text for _, text in TEXTS])
def test_any_other_value_becomes_text(value: Any, text: str) -> None:
    assert to_manifest_value(value) == text


def test_text_is_cut_at_the_limit_of_the_manifest() -> None:
    text = to_manifest_value(list(range(5000)))
    assert isinstance(text, str)
    assert len(text) == 4000
    assert text.startswith("[0, 1, 2")


CODE = """
from gym_extensions.baselines.adapters.sb3_agent import to_manifest_value

class Plain: pass

def schedule(name): return (lambda rate: rate if name in {"adam", "sgd", "rmsprop"} else 0.0)

print(to_manifest_value({"schedule": schedule("sgd"), "plain": Plain(), "names": {"a", "b", "c"}}))
"""


def test_every_process_writes_the_same_text(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(CODE)
    texts = [
        subprocess.run(
            [sys.executable, *arguments], cwd=tmp_path, capture_output=True, text=True, check=True
        ).stdout
        for arguments in (["mine.py"], ["-c", "import mine"])
    ]
    expected = "{'schedule': schedule.<locals>.<lambda>, 'plain': Plain, 'names': {'a', 'b', 'c'}}\n"
    assert texts == [expected, expected]
