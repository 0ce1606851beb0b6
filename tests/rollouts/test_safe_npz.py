"""Reading .npz files from untrusted sources."""

from __future__ import annotations

import io
import random
import struct
import tracemalloc
import warnings
import zipfile
import zlib

import numpy as np
import pytest

from gym_extensions.rollouts.layout import MAX_ARRAYS
from gym_extensions.rollouts.safe_npz import NUMERIC, members, read

from .examples import arrays

HEADER = "{{'descr': {}, 'fortran_order': False, 'shape': {}, }}\n"


def npz(header: str, data: bytes, version: bytes = b"\x01\x00", name: str = "a.npy") -> bytes:
    """An archive of one .npy file with this header and these data."""
    size = struct.pack("<H" if version == b"\x01\x00" else "<I", len(header))
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr(name, b"\x93NUMPY" + version + size + header.encode() + data)
    return stream.getvalue()


def header_of(data: bytes) -> object:
    """The header of the first member."""
    listing, _ = members(data) or ([], 0)
    return listing[0].header


@pytest.mark.parametrize("dtype", sorted(NUMERIC))
@pytest.mark.parametrize("shape", [(), (3,), (2, 3), (0, 4)])
def test_arrays_of_numbers_are_read_as_they_are(dtype: str, shape: tuple[int, ...]) -> None:
    values = np.arange(np.prod(shape, dtype=int)).reshape(shape).astype(dtype)
    result = read(arrays(a=values, b=np.array(values, order="F")))
    assert result is not None
    for name in ("a", "b"):
        assert result[name].dtype == values.dtype
        assert result[name].shape == values.shape
        assert np.array_equal(result[name], values)


def test_both_versions_of_the_format_are_read() -> None:
    header = HEADER.format("'<f8'", "(2,)")
    for version in (b"\x01\x00", b"\x02\x00"):
        result = read(npz(header, np.array([1.0, 2.0]).tobytes(), version))
        assert result is not None
        assert result["a"].tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("dtype", "shape"),
    [
        ("'<U3'", "(1,)"),
        ("'<M8[s]'", "(1,)"),
        ("'|V8'", "(1,)"),
        ("[('x', '<f8')]", "(1,)"),
        ("('<f4', (2,))", "(1,)"),
        ("'<f16'", "(1,)"),
        ("'<f8'", "(-1, -1)"),
        ("'<f8'", "(1.0,)"),
        ("'<f8'", f"({2**48}, 0)"),
        ("'<f8'", f"({'1, ' * 33})"),
        ("'<f8'", "(1L,)"),
        ("__import__('os').getpid()", "(1,)"),
    ],
)
def test_other_headers_are_refused(dtype: str, shape: str) -> None:
    data = npz(HEADER.format(dtype, shape), bytes(8))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert header_of(data) is None
        assert read(data) is None


def test_a_header_must_agree_with_the_size_of_the_data() -> None:
    header = HEADER.format("'<f8'", "(2,)")
    assert read(npz(header, bytes(16))) is not None
    assert read(npz(header, bytes(15))) is None
    assert read(npz(header, bytes(17))) is None


def test_python_objects_are_recognized_and_not_read() -> None:
    data = arrays(a=np.array([{"x": 1}], dtype=object))
    (member,), _ = members(data) or ([], 0)
    assert member.header is not None
    assert member.header.dtype.hasobject
    assert not member.is_valid
    assert read(data) is None


def test_too_many_arrays_are_refused() -> None:
    values = {f"a{number}": np.zeros(1) for number in range(MAX_ARRAYS + 1)}
    assert read(arrays(**values)) is None
    values.popitem()
    assert read(arrays(**values)) is not None


def test_damaged_files_are_never_read_as_other_numbers() -> None:
    whole, rng = arrays(actions=np.zeros((50, 3)), returns=np.arange(5.0)), random.Random(3)
    original = {"actions": np.zeros((50, 3)).tolist(), "returns": [0.0, 1.0, 2.0, 3.0, 4.0]}
    assert {name: values.tolist() for name, values in (read(whole) or {}).items()} == original
    refused = 0
    for _ in range(1500):
        damaged = bytearray(whole)
        damaged[rng.randrange(len(damaged))] ^= rng.randrange(1, 256)
        result = read(bytes(damaged))
        if result is None:
            refused += 1
        else:
            assert [name for name, values in result.items() if values.tolist() != original[name]] == []
    assert 500 < refused < 1500


def test_a_member_that_is_larger_than_it_says_is_not_unpacked() -> None:
    """64 MiB of zeros follow an array; size and CRC of the headers are those of the array alone."""
    stream = io.BytesIO()
    np.save(stream, np.arange(10.0))
    array = stream.getvalue()
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("x.npy", array + bytes(2**26))
    data = bytearray(packed.getvalue())
    central = data.rindex(b"PK\x01\x02")
    for crc, size in ((14, 22), (central + 16, central + 24)):
        data[crc : crc + 4] = zlib.crc32(array).to_bytes(4, "little")
        data[size : size + 4] = len(array).to_bytes(4, "little")
    tracemalloc.start()
    try:
        values = read(bytes(data))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert values is not None
    assert values["x"].tolist() == list(range(10))
    assert peak < 2**22
