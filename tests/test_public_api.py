"""The public names: what users import, each with a docstring. A changed name needs a line in CHANGELOG.md."""

import dataclasses
import doctest
import importlib
from pathlib import Path

import pytest

from gym_extensions.catalog import variations

from .conftest import loaded

ROOT = Path(__file__).resolve().parents[1]
PUBLIC = {
    "gym_extensions.envs": f"""
        {" ".join(variations.__all__)} Variation
        Task TaskGroup TaskId VectorTaskId customize group load_group make make_vec
    """,
    "gym_extensions.baselines": """
        Agent BatchTrained Card Context Factory JobFailed JobFinished Monitor Observes OnnxPolicy Origin
        Parallel Policy Resumable StageStarted StepsTrained TaskEvaluated TrainingStarted record sb3 train
    """,
    "gym_extensions.references.experts": "ExpertCard card load names",
    "gym_extensions.metrics": """
        FORMULAS Interval MetricValue Profile area compute difference interval iqm
        probability_of_improvement profile
    """,
    "gym_extensions.policies": "Diagnosis OnnxPolicy Policy diagnose from_torch load",
    "gym_extensions.results": """
        board core core_pairs core_variants curves episodes evaluations forgetting_predictors
        landscapes metrics network_changes order_effects plot_board plot_curves plot_matrix plot_retention
        policies score_matrix scores
    """,
    "gym_extensions.scoring": "score_folder score_folders",
}
NAMES = [(package, name) for package, names in PUBLIC.items() for name in names.split()]

NEEDS_SB3 = ("gym_extensions.baselines", "sb3")
"""The name that needs the extra ``sb3``."""

EXAMPLES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts[1:]).removesuffix(".__init__")
    for path in ROOT.glob("*/gym_extensions/**/*.py")
    if ">>>" in path.read_text(encoding="utf-8")
}
"""The modules with examples in their docstrings."""
EXTRAS = {
    "gym_extensions.baselines.adapters.sb3": ("stable_baselines3",),
    "gym_extensions.baselines.adapters.sb3_policy": ("stable_baselines3",),
    "gym_extensions.submissions.policies.conversion": ("torch", "onnx", "onnxruntime"),
}
"""The packages of extras that the examples of a module need."""


@pytest.mark.parametrize("package", PUBLIC)
def test_a_package_exports_these_names(package: str) -> None:
    assert sorted(importlib.import_module(package).__all__) == sorted(PUBLIC[package].split())


@pytest.mark.parametrize(("package", "name"), NAMES)
def test_a_public_name_has_a_docstring_of_its_own(package: str, name: str) -> None:
    if (package, name) == NEEDS_SB3:
        pytest.importorskip("stable_baselines3")
    thing = getattr(importlib.import_module(package), name)
    docstring = thing.__doc__ or ""
    assert docstring.strip()
    # A dataclass without a docstring has its signature instead.
    assert not (dataclasses.is_dataclass(thing) and docstring.startswith(f"{name}("))


@pytest.mark.parametrize("module", sorted(EXAMPLES))
def test_the_examples_of_the_docstrings_run(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for package in EXTRAS.get(module, ()):
        pytest.importorskip(package)
    monkeypatch.chdir(ROOT)
    assert doctest.testmod(importlib.import_module(module)).failed == 0


AGENT = """from gym_extensions.baselines import Card, Observes, OnnxPolicy, Policy
import gym_extensions.baselines.agent, gym_extensions.baselines.isolated.guest, gym_extensions.policies"""


@pytest.mark.parametrize(
    ("program", "heavy"),
    [
        (
            "import gymnasium, gym_extensions.envs as envs; envs.group('nav-range').tasks\n"
            "gymnasium.make('gym_extensions/HopperGravityHalf-v0').reset(seed=0)",
            "numba",
        ),
        (
            "import numpy, gym_extensions.scoring.pipeline, gym_extensions.policies as policies\n"
            "policies.Policy(numpy.zeros(1), numpy.ones(1))",
            "numba",
        ),
        (AGENT, "numba"),
        (
            f"{AGENT}\nimport gym_extensions.baselines.algorithms.trpo",
            "mujoco torch gym_extensions.envs gym_extensions.references",
        ),
        (
            "from gym_extensions.scoring.cli import parser; parser().format_help()",
            "pandas numpy gymnasium mujoco torch rich msgspec",
        ),
    ],
    ids=["environments", "policies", "agent", "reference agent", "score --help"],
)
def test_what_a_program_does_not_need_is_not_loaded(program: str, heavy: str) -> None:
    assert loaded(program, heavy) == []
