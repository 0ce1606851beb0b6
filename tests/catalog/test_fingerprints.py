"""The committed table of fingerprints."""

from gym_extensions.catalog import fingerprints
from gym_extensions.catalog.tasks import TASKS

from ..conftest import refused

HALF = "gym_extensions/HopperGravityHalf-v0"


def test_the_table_has_one_row_per_task_in_the_order_of_the_catalog() -> None:
    rows = fingerprints.table()["tasks"]
    assert list(rows) == list(TASKS)
    assert all(row["fingerprint"] == fingerprints.digest(row) for row in rows.values())
    assert len({row["fingerprint"] for row in rows.values()}) == len(rows)


def test_fingerprints_of_published_results_do_not_change() -> None:
    assert fingerprints.published(HALF) == "af8ea315c226519b"
    assert fingerprints.published("gym_extensions/HumanoidGravityOneAndHalf-v0") == "5fac30efc503633c"


def test_an_unknown_id_raises_an_error_with_the_closest_id() -> None:
    with refused("no-fingerprint", HALF):
        fingerprints.published("gym_extensions/HoperGravityHalf-v0")
