"""Fetching MuJoCo for the browser."""

import shutil
from pathlib import Path

import pytest

from tools.mujoco_wasm import main


def test_without_npm_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    assert main([str(tmp_path / "assets")]) == 2
    assert "Install Node.js, which has npm." in capsys.readouterr().err
    assert not (tmp_path / "assets").exists()
