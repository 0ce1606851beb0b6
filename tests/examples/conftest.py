"""Loads the examples, which are scripts and not part of the package."""

from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import pytest

from ..conftest import module_of

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def load_example() -> Iterator[Callable[[str], ModuleType]]:
    """Imports an example by name."""
    torch = pytest.importorskip("torch", reason="the examples need torch: the extra `sb3`")
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield lambda name: module_of(EXAMPLES / f"{name}.py")
    torch.set_num_threads(threads)
