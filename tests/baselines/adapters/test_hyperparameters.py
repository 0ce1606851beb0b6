"""Settings that no manifest takes become texts: others for other settings, the same in every process."""

from __future__ import annotations

import functools
import subprocess
import sys

import numpy as np
import pytest

from gym_extensions.baselines.adapters.hyperparameters import as_setting

PLAIN = ["relu", 3, 0.5, True, [400, 300], []]


@pytest.mark.parametrize("value", PLAIN)
def test_what_the_manifest_takes_stays_as_it_is(value):
    assert as_setting(value) == value


def test_a_tuple_is_a_list():
    assert as_setting((8, "step")) == [8, "step"]


class Relu:
    """A class, as of a network's activation."""


class Noise:
    """An object without a text of its own."""

    def __init__(self, sigma):
        self.sigma = sigma


def halved(progress):
    return progress / 2


TEXTS = [
    (None, "None"),
    (float("inf"), "inf"),
    ({"net_arch": [400, 300]}, "{'net_arch': [400, 300]}"),
    ({"net_arch": {"pi": [64], "vf": (32,)}}, "{'net_arch': {'pi': [64], 'vf': [32]}}"),
    ({"activation_fn": Relu}, "{'activation_fn': Relu}"),
    (Noise(0.1), "Noise {'sigma': 0.1}"),
    (np.array([0.5, 1.0]), "[0.5, 1.0]"),
    ([[1, 2], [3]], "[[1, 2], [3]]"),
]


@pytest.mark.parametrize(("value", "text"), TEXTS, ids=[text for _, text in TEXTS])
def test_anything_else_is_told_in_a_text(value, text):
    assert as_setting(value) == text


def scheduled(rate):
    return lambda progress: rate * progress


OTHERS = [
    ({"net_arch": [400, 300]}, {"net_arch": [16]}),
    (lambda progress: 3e-4 * progress, lambda progress: 1e-3 * progress),
    (lambda progress: 3e-4 * progress, lambda progress: 3e-4 + progress),
    (scheduled(3e-4), scheduled(1e-3)),
    (functools.partial(halved, progress=1), functools.partial(halved, progress=2)),
    (Noise(0.1), Noise(0.2)),
    (list(range(5000)), [*range(4999), 0]),
]


@pytest.mark.parametrize(("one", "other"), OTHERS)
def test_other_settings_have_other_texts(one, other):
    assert as_setting(one) != as_setting(other)
    assert len(as_setting(one)) <= 4000


def test_the_same_function_made_again_is_the_same_setting():
    assert as_setting(scheduled(3e-4)) == as_setting(scheduled(3e-4))
    assert as_setting(halved).startswith("halved ")


CODE = """
from gym_extensions.baselines.adapters.hyperparameters import as_setting

class Plain: pass

def chosen(name): return (lambda rate: rate if name in {"adam", "sgd", "rmsprop"} else 0.0)

print(as_setting({"schedule": chosen("sgd"), "plain": Plain(), "names": {"a", "b", "c"}}))
"""


def test_every_process_writes_the_same_text(tmp_path):
    (tmp_path / "mine.py").write_text(CODE)
    ways = [["mine.py"], ["-c", "import mine"], ["-c", "import mine"]]
    found = {
        subprocess.run(
            [sys.executable, *way], cwd=tmp_path, capture_output=True, text=True, check=True
        ).stdout
        for way in ways
    }
    assert len(found) == 1
    assert "Plain {}" in found.pop()


def test_a_function_that_knows_itself_has_a_text():
    def again(count):
        return again(count - 1) if count else 0

    assert as_setting(again).startswith("test_a_function_that_knows_itself_has_a_text.<locals>.again ")
