"""Diagnostics: what the networks of a submission do on the published observations of its tasks.

``gym-extensions maintain diagnostics`` computes them and writes ``diagnostics/<group>.json`` into the
submission's folder. Loads no simulator.
"""

from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Annotated, Literal, NamedTuple

from gym_extensions.catalog import states
from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.documents import JsonDocument, about
from gym_extensions.metrics.statistics import interval
from gym_extensions.metrics.values import MetricValue
from gym_extensions.submissions.layout import DIAGNOSTICS, DOCUMENT
from gym_extensions.submissions.policies.diagnostics import Diagnosis
from gym_extensions.submissions.run import read_run
from gym_extensions.submissions.submission import runs_folder


@dataclass(frozen=True, slots=True)
class DiagnosedRun:
    """The policies of a run."""

    policies: Annotated[str, about("digest of the run's policies")]
    diagnoses: Annotated[tuple[Diagnosis, ...], about("of each policy, by stage, in `single` by task")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnostics(JsonDocument):
    """The diagnostics of a submission on a group."""

    format: Annotated[Literal[1], about("1")] = 1
    group: Annotated[str, about("group id")]
    states: Annotated[int, about("version of the observations")]
    runs: Annotated[dict[str, DiagnosedRun], about("by name, such as `hopper-gravity/sequential/run0`")]


def path_of(submission: Path, group: TaskGroup) -> Path:
    """The file of a group's diagnostics in a submission's folder."""
    return submission / DIAGNOSTICS / f"{group.name}.json"


def load(submission: Path, group: TaskGroup) -> dict[str, DiagnosedRun]:
    """The diagnosed runs by name whose policies and observations are the present ones.

    Raises ``BenchError`` if a file cannot be read.
    """
    command = "gym-extensions maintain diagnostics"
    found = Diagnostics.load(path_of(submission, group), "bad-diagnostics", command)
    if found is None or found.states != states.VERSION:
        return {}
    current = {}
    for name, run in found.runs.items():
        path = runs_folder(submission, *name.split("/")[:2]) / f"{name}{DOCUMENT}"
        stated = read_run(path).policies if path.is_file() else None
        if stated and stated.sha256 == run.policies:
            current[name] = run
    return current


class Change(NamedTuple):
    """A number of the last hidden layer: means over runs at three stages, the change from first to last."""

    untrained: float
    first: float
    last: float
    change: MetricValue


def changes(submission: Path) -> dict[str, dict[str, Change]]:
    """By group id, how ``ranks`` and ``inactive`` change in the sequential runs of a submission.

    Raises ``BenchError`` if a file cannot be read.
    """
    found: dict[str, dict[str, Change]] = {}
    for group in GROUPS.values():
        runs = [run.diagnoses for name, run in load(submission, group).items() if "/sequential/" in name]
        for measure in ("ranks", "inactive"):
            layers = [[getattr(stage, measure) for stage in run] for run in runs]  # [run][stage][layer]
            if hidden := [[stage[-1] for stage in run] for run in layers if all(run)]:  # none if it failed
                values = [run[-1] - run[1] for run in hidden]
                untrained, first, last = (fmean(run[at] for run in hidden) for at in (0, 1, -1))
                change = MetricValue.of(interval(values), values)
                found.setdefault(group.id, {})[measure] = Change(untrained, first, last, change)
    return found
