"""Properties of every parser: any input is read or refused by name, and what is written is read back."""

from __future__ import annotations

import json
import string
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays, integer_dtypes
from numpy.typing import NDArray

from gym_extensions.catalog.registry import TASKS
from gym_extensions.curation.ledger.line import decode
from gym_extensions.errors import BenchError
from gym_extensions.rollouts import rules
from gym_extensions.rollouts.auditing.salt import parse_salt, salt_of
from gym_extensions.rollouts.auditing.trace_errors import trace_errors
from gym_extensions.rollouts.checked_folder import CheckedFolder
from gym_extensions.rollouts.episodes import EPISODE_COLUMNS
from gym_extensions.rollouts.folder import scan
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.reading.toml_text import parse
from gym_extensions.rollouts.safe_npz import npz_bytes, read

BOUNDED = settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
TOML = st.text(alphabet="ab1.=[]{},\"'\\#\n -_:é", max_size=80)
HOPPER = TASKS["gym_extensions/Hopper-v0"]
LINE = json.dumps({"date": "2026-01-01", "entry": "a", "event": "accepted", "salt": ""})


def cut(data: bytes, edits: list[tuple[int, int]]) -> bytes:
    """The data with these bytes replaced, by position modulo its length."""
    content = bytearray(data)
    for position, byte in edits:
        content[position % len(content)] = byte
    return bytes(content)


EDITS = st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=8)


@BOUNDED
@given(TOML)
def test_toml_is_parsed_as_the_library_does_or_refused(text: str) -> None:
    try:
        tables = parse(text.encode())
    except RecursionError:
        assert text.count(".") > 7 or text.count("[") + text.count("{") > 7
    except ValueError:
        with pytest.raises(ValueError):
            tomllib.loads(text)
    else:
        assert tables == tomllib.loads(text)


@BOUNDED
@given(st.binary(max_size=200))
def test_any_bytes_of_a_manifest_are_read_or_refused(data: bytes) -> None:
    if rules.problems("manifest bytes", data):
        return
    rules.problems("manifest", parse(data))


@BOUNDED
@given(st.binary(max_size=300), st.booleans())
def test_any_bytes_of_a_log_are_read_or_refused(tmp_path: Path, data: bytes, has_header: bool) -> None:
    header = (",".join(EPISODE_COLUMNS) + "\n").encode() if has_header else b""
    (tmp_path / "single.csv").write_bytes(header + data)
    folder = CheckedFolder(scan(tmp_path))
    cells = folder.cells_of("single.csv", EPISODE_COLUMNS)
    assert folder.problems or cells is not None
    if cells is not None:
        assert {len(column) for column in cells.columns.values()} == {len(cells.columns["run"])}


@BOUNDED
@given(arrays(integer_dtypes(endianness="="), array_shapes(max_dims=3, max_side=4)))
def test_arrays_are_read_back(values: NDArray[Any]) -> None:
    content = read(npz_bytes({"a": values}))
    assert content is not None
    assert content["a"].dtype == values.dtype and np.array_equal(content["a"], values)


ARCHIVE = npz_bytes({"actions": np.ones((3, 2), np.float32), "segment_steps": np.array(10)})


@BOUNDED
@given(EDITS)
def test_a_damaged_archive_is_read_or_refused(edits: list[tuple[int, int]]) -> None:
    content = read(cut(ARCHIVE, edits))
    if content is not None:
        list(trace_errors(content, HOPPER, 3, 1.0))


POLICY = Policy(np.zeros(2), np.ones(2), (np.ones((3, 2)),), (np.zeros(2),)).to_bytes()


@BOUNDED
@given(EDITS)
def test_a_damaged_policy_acts_or_is_refused(edits: list[tuple[int, int]]) -> None:
    try:
        policy = Policy.from_bytes(cut(POLICY, edits))
    except BenchError as error:
        assert error.code == "bad-policy"
    else:
        assert policy.act(np.zeros((1, policy.num_inputs or 1))).shape == (1, len(policy.action_offset))


@BOUNDED
@given(
    st.dictionaries(
        st.sampled_from(["actions", "segment_steps", "segment_returns", "state_qpos", "x"]),
        st.sampled_from(["f4", "f8", "i8"]).flatmap(
            lambda name: arrays(np.dtype(name), array_shapes(max_side=3))
        ),
    ),
    st.integers(1, 1000),
    st.floats(allow_nan=True),
)
def test_any_arrays_of_a_trace_are_judged(
    content: dict[str, NDArray[Any]],
    length: int,
    return_: float,
) -> None:
    assert all(isinstance(error, str) for error in trace_errors(content, HOPPER, length, return_))


@BOUNDED
@given(st.binary(max_size=100), EDITS)
def test_any_line_of_a_ledger_is_read_or_refused(data: bytes, edits: list[tuple[int, int]]) -> None:
    for line in (data + b"\n", cut(LINE.encode(), edits) + b"\n"):
        with pytest.raises(BenchError) as error:
            decode(line, "row 1")
        assert error.value.code in ("ledger-line", "ledger-salt")


@BOUNDED
@given(st.text(alphabet=string.hexdigits + "\n g", max_size=70))
def test_a_salt_is_64_digits_or_refused(text: str) -> None:
    expected = len(text) == 64 and set(text) <= set("0123456789abcdef")
    assert (salt_of(f"{text}\n".encode()) == text) == expected
    if expected or not text:
        assert parse_salt(text) == text
    else:
        with pytest.raises(BenchError, match="is not 64 hexadecimal digits"):
            parse_salt(text)
