"""The public names of ``gym_extensions.baselines``."""

from __future__ import annotations

import inspect
import subprocess
import sys

import pytest

from gym_extensions import baselines

NAMES = ["Agent", "Card", "Factory", "Resumable", "sb3", "train"]


def test_the_public_names_are_listed_and_documented() -> None:
    assert baselines.__all__ == NAMES
    assert set(NAMES) <= set(dir(baselines))
    for name in NAMES:
        assert inspect.getdoc(getattr(baselines, name)), name


def test_train_documents_every_argument() -> None:
    text = inspect.getdoc(baselines.train) or ""
    for name in inspect.signature(baselines.train).parameters:
        assert f"\n    {name}: " in text
    assert all(section in text for section in ("Args:", "Returns:", "Raises:", "Example:"))


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'trian'"):
        baselines.trian  # noqa: B018


def loaded(code: str) -> str:
    heavy = "{'mujoco', 'torch', 'stable_baselines3'}"
    code = f"import sys; {code}; print(sorted({heavy} & set(sys.modules)))"
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout


def test_importing_the_package_loads_neither_a_simulator_nor_torch() -> None:
    assert loaded("import gym_extensions.baselines") == "[]\n"


def test_reference_agents_are_available_without_torch() -> None:
    code = (
        "from gym_extensions.baselines import Agent, Card, Factory, Resumable, algorithms, train;"
        "[algorithms.factory(name) for name in algorithms.names()]"
    )
    assert loaded(code) == "['mujoco']\n"
