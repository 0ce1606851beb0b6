"""The changelog: towncrier collects every fragment once, under the heading of its kind."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

pytest.importorskip("towncrier")

ROOT = Path(__file__).resolve().parent.parent
FRAGMENTS = sorted((ROOT / "changelog.d").glob("*.md"))
KINDS = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["towncrier"]["type"]
HEADING = {kind["directory"]: kind["name"] for kind in KINDS}


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A folder with the changelog, its fragments and their configuration alone."""
    shutil.copytree(ROOT / "changelog.d", tmp_path / "changelog.d")
    for name in ("pyproject.toml", "CHANGELOG.md"):
        shutil.copy(ROOT / name, tmp_path)
    return tmp_path


def towncrier(folder: Path, *arguments: str) -> str:
    """Standard output of ``towncrier build`` in the folder."""
    command = [
        sys.executable,
        "-m",
        "towncrier",
        "build",
        "--version",
        "1.0.0",
        "--date",
        "2026-01-02",
        *arguments,
    ]
    return subprocess.run(
        command, cwd=folder, capture_output=True, encoding="utf-8", check=True, timeout=60
    ).stdout


def by_heading(text: str) -> dict[str, str]:
    """The text below each ``###`` heading, with single spaces."""
    parts = re.split(r"^### (.*)$", text, flags=re.MULTILINE)
    return {name: " ".join(body.split()) for name, body in zip(parts[1::2], parts[2::2], strict=True)}


def test_every_fragment_is_named_by_what_and_kind() -> None:
    pattern = rf"[a-z0-9-]+\.({'|'.join(HEADING)})\.md"
    assert [path.name for path in FRAGMENTS if not re.fullmatch(pattern, path.name)] == []


def test_the_draft_has_every_fragment_once_under_its_heading(copy: Path) -> None:
    draft = by_heading(towncrier(copy, "--draft"))
    places = {
        path.name: [
            (name, body.count(f"- {' '.join(path.read_text('utf-8').split())}"))
            for name, body in draft.items()
        ]
        for path in FRAGMENTS
    }
    wrong = {
        name: counts
        for name, counts in places.items()
        if [(heading, count) for heading, count in counts if count] != [(HEADING[name.split(".")[1]], 1)]
    }
    assert wrong == {}


def test_the_headings_come_in_the_order_of_the_configuration(copy: Path) -> None:
    headings = list(by_heading(towncrier(copy, "--draft")))
    assert headings == [name for name in HEADING.values() if name in headings]


def test_a_release_moves_the_fragments_below_the_introduction(copy: Path) -> None:
    introduction = (copy / "CHANGELOG.md").read_text("utf-8")
    towncrier(copy, "--yes")
    released = (copy / "CHANGELOG.md").read_text("utf-8")
    assert released.startswith(f"{introduction}\n## 1.0.0 (2026-01-02)\n\n### ")
    assert list((copy / "changelog.d").glob("*.md")) == []
