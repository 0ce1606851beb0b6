"""Space of entries: identical files count once, and repeated entries keep the traces of one run."""

from __future__ import annotations

from pathlib import Path

import pytest

from .findings_script import findings_script

ROOT = Path(__file__).resolve().parent.parent
REPEATED = sorted(path.stem for path in (ROOT / "scoring" / "repetitions").glob("*.json"))
space = findings_script("space")


def test_identical_files_count_once(tmp_path: Path) -> None:
    for entry, content in (("a", b"1" * 500_000), ("b", b"1" * 500_000), ("c", b"2" * 250_000)):
        path = tmp_path / entry / "hopper-gravity" / "traces" / "sequential-run0.npz"
        path.parent.mkdir(parents=True)
        path.write_bytes(content)
        (path.parent / "salt.txt").write_text("salt")
    assert space.stored_megabytes(tmp_path) == 0.75
    assert space.stored_megabytes(tmp_path, "a", "hopper-gravity", "sequential") == 0.5
    assert space.stored_megabytes(tmp_path, protocol="joint") == 0


def test_the_entries_stay_below_the_limit_of_the_repository() -> None:
    assert space.stored_megabytes(ROOT / "submissions") < space.MAX_MEGABYTES


@pytest.mark.parametrize("entry", REPEATED)
def test_repeated_entries_keep_the_traces_that_the_page_names(entry: str) -> None:
    names = [path.name for path in (ROOT / "submissions" / entry).glob("*/traces/*.npz")]
    kept = {name.split("-run")[1].split("-")[0] for name in names}
    assert kept == (set() if entry == "zero" else {"0"})


def test_without_fine_tuning_there_is_no_space_to_name(tmp_path: Path) -> None:
    assert space.Space.of(tmp_path, "trpo", []) is None
    assert space.Space.of(tmp_path, "trpo", ["hopper-gravity"]).largest == ("hopper-gravity", 0)
