"""Hostile traces for replay: states of other sizes and names, and traces of other episodes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gym_extensions.rollouts.auditing.digests import merkle_root, trace_digest
from gym_extensions.rollouts.safe_npz import npz_bytes, read

from ..rollouts.examples import Change
from .case import LOG, TOML, TRACES, Case, npy, zipped


def bind(folder: Path) -> None:
    """Makes the log commit to the traces of the folder, as their author can."""
    header, *rows = (folder / LOG).read_text().splitlines()
    cells = [row.split(",") for row in rows]
    for row in cells:
        name = f"single-run{row[0]}-stage1-{row[2].split('/')[1].removesuffix('-v0')}-episode{row[3]}.npz"
        path = folder / TRACES / name
        content = read(path.read_bytes()) if path.exists() else None
        if content is not None:
            row[9] = trace_digest(content, int(row[5]), float(row[6]), row[7] == "true", None)
    (folder / LOG).write_text("\n".join([header, *map(",".join, cells), ""]), newline="\n")
    text = (folder / TOML).read_text()
    root = merkle_root([row[9] for row in cells])
    (folder / TOML).write_text(text[: text.index("root = ")] + f'root = "{root}"\n', newline="\n")


def every_trace(width: int, state: str = "qpos") -> Change:
    """Gives all traces of the sample states of that many zeros per segment, and commits to them."""

    def change(folder: Path) -> None:
        rows = [line.split(",") for line in (folder / LOG).read_text().splitlines()[1:]]
        returns = {(row[2].split("/")[1].removesuffix("-v0"), row[3]): float(row[6]) for row in rows}
        for path in (folder / TRACES).iterdir():
            task, episode = path.stem.split("-")[3], path.stem.rsplit("episode", 1)[1]
            segments = np.zeros(100)
            segments[0] = returns[task, episode]
            content = {
                "actions": np.zeros((1000, 3), np.float32),
                "segment_steps": np.array(10),
                "segment_returns": segments,
                f"state_{state}": np.zeros((99, width)),
            }
            path.unlink()
            path.write_bytes(npz_bytes(content))
        bind(folder)

    return change


def states_of_100_mebibytes(folder: Path) -> None:
    """Gives all traces of the sample the same states, which are far too large for their digests to matter."""
    states = zipped({"state_qpos.npy": npy("'<f8'", "(100, 131072)", bytes(100 * 2**20))})
    for path in (folder / TRACES).iterdir():
        path.unlink()
        path.write_bytes(states)


CASES = (
    Case(
        "compressed zeros as states in every trace",
        every_trace(600),
        ("replay-differs", "trace-missing"),
        "replay",
    ),
    Case("states of 100 MiB in every trace", states_of_100_mebibytes, ("unpacks-too-large",), "replay"),
    Case(
        "a state of another name in every trace",
        every_trace(3, "luck"),
        ("replay-differs", "trace-missing"),
        "replay",
    ),
    Case("traces of other episodes", lambda folder: None, ("trace-malformed",), "replay"),
)
