"""A base body is one row and one entry, a run-time variation two new files: both are added in a copy."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[2] / "envs" / "gym_extensions"

ROW = """
    Body(
        name="Monopod",
        family="planar",
        asset="hopper.xml",
        model_name="hopper",
        prose=Prose("Summary.", "Reward.", "Start.", "End.", "Source."),
        rewards=RewardBounds(-20.0, 20.0),
        beams="pitch",
        velocity_limit=10.0,
    ),
)
"""
ENTRY = '    "Monopod": Implementation(planar.Hopper, planar_rules.HopperRules),\n'
USE_BODY = """
import numpy as np
from gym_extensions.catalog.registry import TASKS
from gym_extensions.envs import Gravity, MotorNoise, RangeSensor, Wall, customize, make, make_vec
from gym_extensions.envs.docgen.tables import observation_fields
task = TASKS["gym_extensions/Monopod-v0"]
assert len(observation_fields(task)) == 11
busy = customize(task, [Gravity(0.8), MotorNoise(), RangeSensor(), Wall()])
assert type(make_vec(busy, 2)).__name__ == "MujocoVectorEnv"
np.testing.assert_array_equal(make_vec(busy, 1).reset(seed=[3])[0][0], make(busy).reset(seed=3)[0])
"""

VARIATION = '''
from dataclasses import dataclass

from gym_extensions.catalog.variations.base import RuntimeVariation


@dataclass(frozen=True)
class WeakMotors(RuntimeVariation):
    """Multiplies every command by a factor."""

    factor: float = 0.5
'''
EFFECT = """
from gym_extensions.catalog.variations.weak_motors import WeakMotors
from gym_extensions.envs.effects.base import Effect, EffectKind, VectorEffect, required


class WeakMotorsEffect(Effect):
    def __init__(self, task):
        self._factor = required(task, WeakMotors).factor

    def control(self, simulation, ctrl):
        return self._factor * ctrl


class VectorWeakMotorsEffect(VectorEffect):
    def __init__(self, physics, templates):
        self._factor = required(templates[0].task, WeakMotors).factor

    def control(self, ctrl, steps):
        return self._factor * ctrl


KIND = EffectKind(WeakMotors, WeakMotorsEffect, VectorWeakMotorsEffect, draw_order=6)
"""
USE_VARIATION = """
import numpy as np
from gym_extensions.catalog.variations.weak_motors import WeakMotors
from gym_extensions.envs import customize, make, make_vec
task = customize("Hopper", [WeakMotors()])
vector, single, full = make_vec(task, 1), make(task), make("Hopper")
assert type(vector).__name__ == "MujocoVectorEnv"
vector.reset(seed=[3]); single.reset(seed=3); full.reset(seed=3)
action = np.full(3, 0.5, np.float32)
weak = single.step(action)[0]
np.testing.assert_array_equal(vector.step(action[None])[0][0], weak)
assert not np.array_equal(full.step(action)[0], weak)
"""


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A copy of the packages, which comes first on the path of ``run``."""
    return shutil.copytree(SOURCE, tmp_path / "gym_extensions", ignore=shutil.ignore_patterns("__pycache__"))


def run(copy: Path, code: str) -> None:
    """Runs the code with the copied packages; fails with its error output."""
    environment = os.environ | {"PYTHONPATH": str(copy.parent)}
    process = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    assert process.returncode == 0, process.stderr


def edit(path: Path, old: str, new: str) -> None:
    """Replaces the last occurrence of a text in a file."""
    before, match, after = path.read_text(encoding="utf-8").rpartition(old)
    assert match
    path.write_text(before + new + after, encoding="utf-8")


def test_a_body_is_one_row_in_the_catalog_and_one_entry_in_the_registry_of_classes(copy: Path) -> None:
    edit(copy / "catalog" / "bodies" / "planar.py", "\n)\n", ROW)
    edit(copy / "envs" / "bodies.py", '    "Pusher"', ENTRY + '    "Pusher"')
    run(copy, USE_BODY)


def test_a_runtime_variation_is_one_new_file_in_the_catalog_and_one_in_effects(copy: Path) -> None:
    (copy / "catalog" / "variations" / "weak_motors.py").write_text(VARIATION, encoding="utf-8")
    (copy / "envs" / "effects" / "weak_motors.py").write_text(EFFECT, encoding="utf-8")
    run(copy, USE_VARIATION)
