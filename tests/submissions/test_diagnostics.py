"""The diagnostics of a submission belong to its present policies, and say how networks change."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.catalog import states
from gym_extensions.catalog.groups import group
from gym_extensions.submissions import diagnostics
from gym_extensions.submissions.layout import DOCUMENT, run_file
from gym_extensions.submissions.policies.diagnostics import Diagnosis
from gym_extensions.submissions.run import read_run

HERE = group("hopper-gravity")


def diagnosed(submission: Path, run: int) -> diagnostics.DiagnosedRun:
    """A run whose last rank rises by 1 + ``run`` per stage, and whose units become inactive at the end."""
    policies = read_run(submission / run_file(HERE.name, "sequential", run, DOCUMENT)).policies
    assert policies is not None
    stages = tuple(
        Diagnosis(parameters=9, ranks=(9.0, 2.0 + stage * (1 + run)), inactive=(0.0, float(stage == 5)))
        for stage in range(6)
    )
    return diagnostics.DiagnosedRun(policies=policies.sha256, diagnoses=stages)


def write(submission: Path, runs: Mapping[int, diagnostics.DiagnosedRun] | None = None) -> Path:
    runs = runs or {run: diagnosed(submission, run) for run in (0, 1)}
    named = {f"{HERE.name}/sequential/run{run}": each for run, each in runs.items()}
    document = diagnostics.Diagnostics(group=HERE.id, states=states.VERSION, runs=named)
    return document.write(diagnostics.path_of(submission, HERE))


def test_a_change_is_that_of_the_last_hidden_layer_with_an_interval_over_runs(
    make_submission: Callable[..., Path],
) -> None:
    submission = make_submission(protocols=("sequential",))
    assert diagnostics.changes(submission) == {}
    write(submission)
    found = diagnostics.changes(submission)[HERE.id]
    rank, inactive = found["ranks"], found["inactive"]
    assert (rank.untrained, rank.first, rank.last, rank.change.runs) == (2.0, 3.5, 9.5, (4.0, 8.0))
    assert rank.change.ends == pytest.approx((6 - 12.706 * 2, 6 + 12.706 * 2), rel=1e-4)
    assert (inactive.first, inactive.last, inactive.change.ends) == (0.0, 1.0, (1.0, 1.0))


def test_a_run_that_failed_has_no_network_and_does_not_count(make_submission: Callable[..., Path]) -> None:
    submission = make_submission(protocols=("sequential",))
    lost = diagnosed(submission, 0)
    lost = replace(lost, diagnoses=(Diagnosis(parameters=0, ranks=(), inactive=()),) * 6)
    write(submission, {0: lost, 1: diagnosed(submission, 1)})
    assert diagnostics.changes(submission)[HERE.id]["ranks"].change.runs == (8.0,)


def test_diagnostics_of_other_policies_or_observations_do_not_count(
    make_submission: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    submission = make_submission(protocols=("sequential",))
    path = write(submission)
    monkeypatch.setattr(states, "VERSION", 2)
    assert diagnostics.changes(submission) == {}
    monkeypatch.undo()
    stated = diagnosed(submission, 0).policies
    path.write_text(path.read_text("utf-8").replace(stated, "0" * 64), "utf-8")
    assert diagnostics.changes(submission) == {}
