"""Imports a script of docs/findings as a module."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "findings"


def findings_script(name: str) -> ModuleType:
    """The module of ``docs/findings/<name>.py``; the test is skipped without matplotlib."""
    pytest.importorskip("matplotlib", reason="the figures need matplotlib: the extra `plot`")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FOLDER))
        spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        patch.setitem(sys.modules, name, module)
        spec.loader.exec_module(module)
    return module
