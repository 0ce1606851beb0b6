"""Peak memory of many environments."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import pytest

pytestmark = pytest.mark.bench

MEMORY = """
import resource
import numpy as np
from gym_extensions.envs import make_vec
env = make_vec("Humanoid", 512, num_threads=2)
env.reset(seed=0)
for _ in range(20):
    env.step(np.full((512, 17), 0.3, np.float32))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def test_512_humanoid_environments_need_at_most_1_5_gb(side_by_side: Any) -> None:
    """The ratio is 1.5 GB / peak memory of the whole process, so above 1 is good."""

    def turn() -> tuple[int, float]:
        output = subprocess.run(
            [sys.executable, "-c", MEMORY], check=True, capture_output=True, text=True
        ).stdout
        return 1, int(output) * 1024 / 1.5e9

    contestants = {"512 Humanoid lanes": turn, "1.5 GB": lambda: (1, 1.0)}
    ratios = side_by_side("memory", contestants, bars={"1.5 GB": 1.0}, rounds=1)
    assert ratios["1.5 GB"] >= 1.0
