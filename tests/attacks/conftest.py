"""The option with which `make attack` writes the table."""

from __future__ import annotations

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds ``--write-table``."""
    parser.addoption(
        "--write-table", action="store_true", help="write the table of attacks to docs/security.md"
    )
