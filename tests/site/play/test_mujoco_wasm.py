"""MuJoCo for the browser is used only if it is the pinned one."""

import gzip
import hashlib
from pathlib import Path

import pytest

from gym_extensions.site.play import assets

from ...conftest import refused


def write_assets(folder: Path, script: bytes = b"script", wasm: bytes = b"wasm") -> Path:
    folder.mkdir()
    (folder / "mujoco.js").write_bytes(script)
    (folder / "mujoco.wasm.gz").write_bytes(gzip.compress(wasm))
    return folder


def test_the_simulator_is_read_only_if_it_is_the_pinned_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    digests = {f"mujoco.{name}": hashlib.sha256(name.encode()).hexdigest() for name in ("js", "wasm")}
    monkeypatch.setattr(assets, "SHA256", digests)
    assert assets.load(tmp_path / "none") is None
    simulator = assets.load(write_assets(tmp_path / "right", b"js", b"wasm"))
    assert simulator is not None
    assert b"Apache License" in simulator.license
    assert set(simulator.files()) == {"play/mujoco.js", "play/mujoco.wasm.packed", "play/LICENSE-mujoco.txt"}
    with refused("bad-asset", "mujoco.wasm is not the one", "make site-assets"):
        assets.load(write_assets(tmp_path / "wrong", b"js", b"other"))
    (tmp_path / "right" / "mujoco.js").unlink()
    with refused("bad-asset", "No such file"):
        assets.load(tmp_path / "right")
