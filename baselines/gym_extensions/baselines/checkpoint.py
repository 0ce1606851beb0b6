"""An agent's state as named arrays in an npz file, without pickle."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from gym_extensions.baselines.agent import Array


def save_arrays(path: Path, **arrays: Array) -> None:
    """Writes the arrays to ``path``, whatever its suffix."""
    with path.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def load_arrays(path: Path) -> dict[str, Array]:
    """Reads the arrays of an npz file by name."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def saved_generator(generator: np.random.Generator) -> Array:
    """The state of a random generator as a string array."""
    return np.array(json.dumps(generator.bit_generator.state, sort_keys=True))


def restore_generator(generator: np.random.Generator, saved: Array) -> None:
    """Sets a random generator to a state from :func:`saved_generator`."""
    state: dict[str, Any] = json.loads(str(saved))
    generator.bit_generator.state = state
