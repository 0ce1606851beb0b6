"""`maintain diagnostics` computes what is not up to date, in the process with limits, and loses nothing."""

from pathlib import Path

import pytest

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.curation.cli import maintain
from gym_extensions.submissions import diagnostics

from .made_submissions import GROUP, change_policies, copy, honest, network

HERE = GROUPS[GROUP]


@pytest.fixture
def submission(tmp_path: Path) -> Path:
    return copy(honest(runs=2), tmp_path / "mine")


def record(submission: Path, *options: str) -> int:
    return maintain(["diagnostics", str(submission), "--cache", str(submission.parent / "cache"), *options])


def test_all_policies_are_described_once(submission: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert record(submission) == 0
    path = diagnostics.path_of(submission, HERE)
    found = diagnostics.Diagnostics.from_json(path.read_bytes())
    assert (found.group, found.states) == (HERE.id, 1)
    assert list(found.runs) == [f"{GROUP}/sequential/run{run}" for run in (0, 1)]
    (first, *_, last) = found.runs[f"{GROUP}/sequential/run1"].diagnoses
    assert (first.parameters, len(first.norms or ()), len(last.distances or ())) == (66, 1, 2)
    written = path.read_bytes()
    assert record(submission) == 0
    assert f"mine, {GROUP}: up to date." in capsys.readouterr().out
    assert record(submission, "--again", "--groups", GROUP) == 0
    assert path.read_bytes() == written


def test_other_policies_are_described_again(submission: Path) -> None:
    assert record(submission) == 0
    path = diagnostics.path_of(submission, HERE)
    written = path.read_bytes()
    change_policies(submission, lambda stored: stored.update({(0, None): stored[2, None]}))
    assert diagnostics.load(submission, HERE) == {}
    assert record(submission) == 0
    assert len(diagnostics.load(submission, HERE)) == 2
    assert path.read_bytes() != written


def test_a_policy_that_does_not_fit_the_observations_loses_nothing_else(
    submission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change_policies(submission, lambda stored: stored.update({(1, None): network(1, inputs=5)}))
    assert record(submission) == 0
    said = f"mine, {GROUP}/sequential/run0: The observations have 21 values; the policy has 5 inputs."
    assert said in capsys.readouterr().out


def test_a_group_without_observations_is_refused(
    submission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert record(submission, "--groups", f"{GROUP},nav-image") == 2
    assert "No observations of nav-image are published." in capsys.readouterr().err
