"""Hostile .npz files: archives, headers, sizes, and policies."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from gym_extensions.rollouts.auditing.digests import merkle_root, trace_digest
from gym_extensions.rollouts.layout import MAX_UNPACKED_BYTES
from gym_extensions.rollouts.safe_npz import npz_bytes, read

from ..rollouts.examples import Change
from .case import (
    LOG,
    POLICIES,
    POLICY,
    TOML,
    TRACE,
    TRACES,
    Case,
    all_of,
    npy,
    put,
    zipped,
)

PICKLE = b"\x80\x04cos\nsystem\n(S'true'\ntR."


def declares(size: int) -> bytes:
    """An archive whose directory declares another size than the member has."""
    data = bytearray(zipped({"a.npy": npy("'<f8'", "(1,)", bytes(8))}))
    start = data.rindex(b"PK\x01\x02")
    data[start + 24 : start + 28] = size.to_bytes(4, "little")
    return bytes(data)


def overlapping() -> bytes:
    """An archive whose 200 names share the data of one member."""
    single = zipped({"a.npy": npy("'<f8'", "(524288,)", bytes(2**22))})
    start, end = single.rindex(b"PK\x01\x02"), single.rindex(b"PK\x05\x06")
    directory = bytearray(single[start:end])
    count = 200
    tail = bytearray(single[end:])
    tail[8:10] = tail[10:12] = count.to_bytes(2, "little")
    tail[12:16] = (count * len(directory)).to_bytes(4, "little")
    return single[:start] + bytes(directory) * count + bytes(tail)


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


def policy(**changes: object) -> bytes:
    """A linear policy of Hopper with these arrays changed; None removes one."""
    text = {name: np.frombuffer(value, np.uint8) for name, value in NAMES.items()}
    content: dict[str, object] = {
        "format": np.array(1),
        **text,
        "action_offset": np.zeros(3),
        "action_scale": np.ones(3),
    }
    content |= {"weight_0": np.zeros((11, 3)), "bias_0": np.zeros(3), **changes}
    return npz_bytes({name: np.asarray(values) for name, values in content.items() if values is not None})


NAMES = {
    "head": b"deterministic",
    "activation": b"tanh",
    "output_activation": b"linear",
    "squash": b"linear",
    "observation_dtype": b"float64",
}
TASKS = (
    "HopperGravityHalf",
    "HopperGravityThreeQuarters",
    "Hopper",
    "HopperGravityOneAndQuarter",
    "HopperGravityOneAndHalf",
)


def policies(data: bytes | Callable[[], bytes]) -> Change:
    """The same policy file for all tasks."""
    return all_of(*(put(f"{POLICIES}/single-run0-stage1-{task}.npz", data) for task in TASKS))


def states_of_100_mebibytes(folder: Path) -> None:
    """Gives all traces of the sample the same states, which are far too large for their digests to matter."""
    states = zipped({"state_qpos.npy": npy("'<f8'", "(100, 131072)", bytes(100 * 2**20))})
    for path in (folder / TRACES).iterdir():
        path.unlink()
        path.write_bytes(states)


MALFORMED = ("malformed-arrays",)
CASES = (
    Case("a trace of null bytes", put(TRACE, bytes(2**20)), MALFORMED),
    Case("an empty trace", put(TRACE, b""), MALFORMED),
    Case("a trace of the largest size", put(TRACE, lambda: bytes(4 * 2**20)), MALFORMED),
    Case("a trace that is larger", put(TRACE, lambda: bytes(4 * 2**20 + 1)), ("too-large",)),
    Case(
        "the beginning of an archive",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", "(1,)", bytes(8))})[:-30]),
        MALFORMED,
    ),
    Case(
        "an archive with text before it",
        put(TRACE, lambda: b"#!/bin/sh\n" + zipped({"a.npy": npy("'<f8'", "(1,)", bytes(8))})),
        (),
    ),
    Case("a pickle", put(TRACE, lambda: zipped({"a.npy": npy("'|O'", "(1,)", PICKLE)})), ("pickled-arrays",)),
    Case("a pickle without an archive", put(TRACE, PICKLE), MALFORMED),
    Case(
        "an array of 256 MiB of zeros",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", f"({2**25},)", bytes(2**28))})),
        ("unpacks-too-large",),
    ),
    Case(
        "arrays just above the limit",
        put(
            TRACE,
            lambda: zipped({"a.npy": npy("'|u1'", f"({MAX_UNPACKED_BYTES},)", bytes(MAX_UNPACKED_BYTES))}),
        ),
        ("unpacks-too-large",),
    ),
    Case(
        "a header that states 2 to the 48th values",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", f"({2**47},)", bytes(8))})),
        ("malformed-array",),
    ),
    Case(
        "a header of negative lengths",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", "(-1, -1)", bytes(8))})),
        ("malformed-array",),
    ),
    Case(
        "a header of 10,000 dimensions",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", f"({'1,' * 10_000})", bytes(8))})),
        ("malformed-array",),
    ),
    Case(
        "a header of nested brackets",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", "(" * 2000, bytes(8))})),
        ("malformed-array",),
    ),
    Case(
        "a header that calls a function",
        put(TRACE, lambda: zipped({"a.npy": npy("__import__('os').getpid()", "()", bytes(8))})),
        ("malformed-array",),
    ),
    Case(
        "a header of structured values",
        put(TRACE, lambda: zipped({"a.npy": npy("[('a', '<f8')]", "(1,)", bytes(8))})),
        ("malformed-array",),
    ),
    Case(
        "a header of another version",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", "(1,)", bytes(8), b"\x03\x00")})),
        ("malformed-array",),
    ),
    Case(
        "an archive of 300 arrays",
        put(TRACE, lambda: zipped({f"a{i}.npy": npy("'<f8'", "(1,)", bytes(8)) for i in range(300)})),
        ("unpacks-too-large",),
    ),
    Case(
        "an archive of 60,000 names",
        put(TRACE, lambda: zipped({f"{i}": b"" for i in range(30_000)}, zipfile.ZIP_STORED)),
        ("malformed-array", "malformed-arrays", "unpacks-too-large"),
    ),
    Case(
        "an archive whose names share their data",
        put(TRACE, overlapping),
        ("repeated-array", "unpacks-too-large"),
    ),
    Case("a directory that declares less", put(TRACE, declares(1)), ("malformed-array",)),
    Case(
        "a directory that declares more",
        put(TRACE, declares(2**31)),
        ("malformed-array", "unpacks-too-large"),
    ),
    Case(
        "a name with two dots",
        put(TRACE, lambda: zipped({"../a.npy": npy("'<f8'", "(1,)", bytes(8))})),
        MALFORMED,
    ),
    Case(
        "a name that is absolute",
        put(TRACE, lambda: zipped({"/etc/a.npy": npy("'<f8'", "(1,)", bytes(8))})),
        MALFORMED,
    ),
    Case(
        "a name of 60,000 letters",
        put(TRACE, lambda: zipped({"a" * 60_000 + ".npy": npy("'<f8'", "(1,)", bytes(8))})),
        (),
    ),
    Case(
        "another compression",
        put(TRACE, lambda: zipped({"a.npy": npy("'<f8'", "(1,)", bytes(8))}, zipfile.ZIP_LZMA)),
        ("foreign-compression",),
    ),
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
    Case("a policy without a layer's bias", policies(policy(bias_0=None)), ("malformed-policy",)),
    Case(
        "a policy of weights that are no numbers",
        policies(policy(weight_0=np.full((11, 3), np.nan))),
        ("malformed-policy",),
    ),
    Case(
        "a policy of infinite weights",
        policies(policy(weight_0=np.full((11, 3), np.inf))),
        ("malformed-policy",),
    ),
    Case(
        "a policy of other observations",
        policies(policy(weight_0=np.zeros((12, 3)))),
        ("policy-fails",),
        "new seeds",
    ),
    Case(
        "a policy of other actions",
        policies(
            policy(
                action_offset=np.zeros(2),
                action_scale=np.ones(2),
                weight_0=np.zeros((11, 2)),
                bias_0=np.zeros(2),
            )
        ),
        ("policy-fails",),
        "new seeds",
    ),
    Case(
        "a policy of an unknown activation",
        policies(policy(activation=np.frombuffer(b"exec", np.uint8))),
        ("malformed-policy",),
    ),
    Case("a policy of an unknown array", policies(policy(code=np.zeros(3))), ("malformed-policy",)),
    Case(
        "a policy of a gigantic matrix",
        policies(lambda: policy(weight_0=np.zeros((11, 100_000)), bias_0=np.zeros(100_000))),
        ("malformed-policy",),
    ),
    Case("a policy of 2 MiB", put(POLICY, bytes(2**21 + 1)), ("missing-policy", "too-large")),
    Case(
        "a policy of 100 layers",
        policies(
            policy(
                weight_0=np.zeros((11, 11)),
                bias_0=np.zeros(11),
                **{f"weight_{i}": np.zeros((11, 3 if i == 99 else 11)) for i in range(1, 100)},
                **{f"bias_{i}": np.zeros(3 if i == 99 else 11) for i in range(1, 100)},
            )
        ),
        (),
    ),
    Case(
        "a policy of a missing layer",
        policies(policy(weight_5=np.zeros((3, 3)), bias_5=np.zeros(3))),
        ("malformed-policy",),
    ),
    Case(
        "a policy of numbers that overflow",
        policies(
            policy(
                weight_0=np.full((11, 3), 1e308),
                observation_mean=np.zeros(11),
                observation_scale=np.full(11, 5e-324),
            )
        ),
        ("policy-fails",),
        "new seeds",
    ),
    Case("a policy of empty arrays", policies(policy(weight_0=np.zeros((0, 3)))), ("malformed-policy",)),
    Case("a policy of scalars", policies(policy(weight_0=np.array(1.0))), ("malformed-policy",)),
    Case("a policy of 32 dimensions", policies(policy(weight_0=np.zeros((1,) * 32))), ("malformed-policy",)),
    Case(
        "a policy of rows per task",
        policies(policy(weight_0=np.zeros((5, 11, 3)))),
        ("policy-observes-task",),
    ),
    Case("one policy of five", put(POLICY, policy()), ("missing-policy",)),
    Case(
        "a policy of a run that does not exist",
        all_of(policies(policy()), put(POLICY.replace("run0", "run7"), policy())),
        ("foreign-policy",),
    ),
    Case(
        "a policy of another stage",
        all_of(policies(policy()), put(POLICY.replace("stage1", "stage9"), policy())),
        ("foreign-policy",),
    ),
)
