"""The digest of a trace and the Merkle root, computed by hand."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
import pytest

from gym_extensions.rollouts.auditing.digests import merkle_root, trace_digest

ARRAYS: dict[str, np.ndarray[Any, Any]] = {
    "segment_steps": np.array(10),
    "actions": np.array([[0.5, -1.0]], np.float32),
}
OUTCOME = (1, 1e-05, True, None)


def test_the_digest_of_a_trace_is_that_of_its_canonical_form() -> None:
    form = b"1,1e-05,true,\nactions <f4 1,2\n\0\0\0\x3f\0\0\x80\xbfsegment_steps <i8 \n\x0a" + bytes(7)
    assert trace_digest(ARRAYS, *OUTCOME) == hashlib.sha256(form).hexdigest()[:32]


def test_the_order_and_layout_of_arrays_in_memory_do_not_matter() -> None:
    matrix = np.arange(6.0).reshape(2, 3)
    forms = (matrix, np.asfortranarray(matrix), matrix.astype(">f8"))
    digests = {trace_digest({"state_qpos": form}, *OUTCOME) for form in forms}
    assert len(digests) == 1
    assert trace_digest(dict(reversed(ARRAYS.items())), *OUTCOME) == trace_digest(ARRAYS, *OUTCOME)


@pytest.mark.parametrize(
    "outcome", [(2, 1e-05, True, None), (1, 2.0, True, None), (1, 1e-05, False, None), (1, 1e-05, True, True)]
)
def test_every_part_of_the_outcome_changes_the_digest(outcome: tuple[int, float, bool, bool | None]) -> None:
    assert trace_digest(ARRAYS, *outcome) != trace_digest(ARRAYS, *OUTCOME)


@pytest.mark.parametrize(
    "change",
    [
        {"actions": np.array([[0.5, -0.5]], np.float32)},
        {"actions": np.array([[0.5, -1.0]])},
        {"actions": np.array([[0.5], [-1.0]], np.float32)},
        {"state_luck": np.zeros(1)},
    ],
)
def test_every_array_changes_the_digest(change: dict[str, np.ndarray[Any, Any]]) -> None:
    assert trace_digest(ARRAYS | change, *OUTCOME) != trace_digest(ARRAYS, *OUTCOME)


def test_the_root_of_three_digests_by_hand() -> None:
    leaves = [hashlib.sha256(b"\0" + bytes([value]) * 16).digest() for value in (1, 2, 3)]
    pair = hashlib.sha256(b"\1" + leaves[0] + leaves[1]).digest()
    assert (
        merkle_root(["01" * 16, "02" * 16, "03" * 16]) == hashlib.sha256(b"\1" + pair + leaves[2]).hexdigest()
    )


def test_the_root_of_nothing_is_the_digest_of_nothing() -> None:
    assert merkle_root([]) == hashlib.sha256().hexdigest()


def test_the_root_depends_on_the_order() -> None:
    assert merkle_root(["01" * 16, "02" * 16]) != merkle_root(["02" * 16, "01" * 16])
