"""An archive of all traces has the Merkle root and the digest that the manifest states."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from gym_extensions.errors import BenchError
from gym_extensions.scoring.replay.archive import check_archive

GROUP = "hopper-motor-noise"
"""The group of ``random_submission``."""


def archive_of(folder: Path, edit: Callable[[dict[str, bytes]], object]) -> Path:
    """A zip file of the traces of all episodes, changed."""
    traces = (folder / ".progress" / GROUP / "traces").iterdir()
    content = {f"{GROUP}/traces/{path.name}": path.read_bytes() for path in traces}
    edit(content)
    path = folder.with_name("archive.zip")
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    return path


def test_an_archive_of_all_traces_has_the_root(random: Path) -> None:
    assert check_archive(random, archive_of(random, lambda content: None)) == ()


def lose(content: dict[str, bytes]) -> None:
    del content[min(content)]


def swap(content: dict[str, bytes]) -> None:
    first, second = sorted(content)[:2]
    content[first], content[second] = content[second], content[first]


@pytest.mark.parametrize(("edit", "count"), [(lose, 1), (swap, 2)])
def test_an_archive_with_another_root_is_a_problem(
    random: Path, edit: Callable[[dict[str, bytes]], object], count: int
) -> None:
    (problem,) = check_archive(random, archive_of(random, edit))
    assert (problem.rule, problem.where) == ("archive-differs", "archive.zip")
    assert problem.message.count(".npz") == count


def test_an_archive_with_another_digest_than_the_manifest_states_is_a_problem(random: Path) -> None:
    with (random / "submission.toml").open("a") as file:
        file.write(f'\n[archive]\nurl = ""\nsha256 = "{64 * "0"}"\n')
    (problem,) = check_archive(random, archive_of(random, lambda content: None))
    assert (problem.rule, problem.message) == (
        "archive-differs",
        "Its SHA-256 is not the one in [archive].",
    )


def test_a_file_that_is_not_an_archive_is_refused(random: Path, tmp_path: Path) -> None:
    (tmp_path / "archive.zip").write_bytes(b"not a zip file")
    with pytest.raises(BenchError) as error:
        check_archive(random, tmp_path / "archive.zip")
    assert error.value.code == "bad-archive"
