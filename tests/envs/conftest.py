"""A table of fingerprints that tests may change."""

import copy
from typing import Any

import pytest

from gym_extensions.catalog import fingerprints


@pytest.fixture
def table(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A copy of the published table, in its place."""
    copied = copy.deepcopy(fingerprints.table())
    monkeypatch.setattr(fingerprints, "table", lambda: copied)
    return copied
