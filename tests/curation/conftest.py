"""A project, its copies on branches, and a gate that judges no submission."""

import shutil
from pathlib import Path

import pytest

from gym_extensions.curation import gate

from .repositories import git, make_project


@pytest.fixture(scope="session")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with code, an owner and a submission; the branch ``submission`` adds a new submission."""
    return make_project(tmp_path_factory.mktemp("base") / "project")


@pytest.fixture
def project(base: Path, tmp_path: Path) -> Path:
    """A copy of the project on a branch that equals its base."""
    return Path(shutil.copytree(base, tmp_path / "project"))


@pytest.fixture
def request_with_submission(project: Path) -> Path:
    """A copy of the project on a branch that adds a new submission."""
    git(project, "switch", "--quiet", "submission")
    return project


@pytest.fixture
def no_judge(monkeypatch: pytest.MonkeyPatch) -> None:
    """Judges no submission: for what is decided before or after that."""
    found = {"level": "claimed", "repeated": 380, "episodes": 400, "notes": ["`@alice` <img>"]}
    monkeypatch.setattr(gate, "answers", lambda _, call, __: iter([call["report"] | found]))
