"""The versions on which results depend."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import pytest

from gym_extensions.baselines.training.versions import joined
from gym_extensions.installed import blas_kernels

PRINT = "from gym_extensions.installed import blas_kernels; print(blas_kernels())"


@pytest.mark.skipif(
    "openblas" not in blas_kernels() or platform.machine() not in {"x86_64", "AMD64"},
    reason="only OpenBLAS on x86 has these kernels",
)
def test_the_kernels_that_openblas_uses_are_named() -> None:
    environment = os.environ | {"OPENBLAS_CORETYPE": "Nehalem"}
    command = [sys.executable, "-c", PRINT]
    printed = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    assert printed == "openblas Nehalem\n"


def test_several_values_are_joined_without_repetition() -> None:
    assert joined(["a, b", "", "b", "c"]) == "a, b, c"
    assert joined([]) == ""
