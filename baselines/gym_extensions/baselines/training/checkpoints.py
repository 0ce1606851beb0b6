"""The state of unfinished jobs on disk: finished stages with their policies, and the agent after the last."""

import json
import os
import re
import shutil
import sys
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from gym_extensions.baselines import agent as agents
from gym_extensions.baselines.training.jobs import Settings, TrainingJob
from gym_extensions.envs.fingerprinting import fingerprint_of
from gym_extensions.errors import BenchError
from gym_extensions.files import remove, write_bytes, write_text
from gym_extensions.submissions import layout, log, run
from gym_extensions.submissions.policies.files import AnyPolicy, npz_arrays, npz_bytes, run_arrays
from gym_extensions.versions import blas_kernels, processor, version

SETTINGS = "settings.json"
CONTINUES = "The same command continues: it trains only what is not finished."
NO_BOX = 0.0, 0.0
PACKAGES = ("gym_extensions", "gymnasium", "mujoco", "numpy")
"""The packages on which the results of every job depend."""


@dataclass(frozen=True)
class Usage:
    """What a stage took in the process that trained it, and in that of an agent in a box."""

    steps: int  # environment steps in training
    cpu_seconds: float  # processor time of the process, all threads together
    peak_memory_mb: float  # largest memory since the start, of both processes added; 0 if unknown
    kernels: str  # the BLAS kernels
    processor: str  # its name
    cores: int  # logical processors of the machine


def processor_time(agent: object) -> float:
    """The processor time of this process in seconds, and of the agent's, if that is another one (a box)."""
    return time.process_time() + float(getattr(agent, "box_used", NO_BOX)[0])


def usage_since(started: float, steps: int, agent: object = None) -> Usage:
    """What training steps used since a time of :func:`processor_time`."""
    seconds = round(processor_time(agent) - started, 3)
    memory = round(peak_memory_mb() + float(getattr(agent, "box_used", NO_BOX)[1]), 1)
    return Usage(steps, seconds, memory, blas_kernels(), processor(), os.cpu_count() or 1)


def peak_memory_mb() -> float:
    """The largest memory of this process since it started, in MB; 0 where the system does not tell."""
    status = Path("/proc/self/status")  # on Linux, whose getrusage counts the process that started this one
    if status.exists() and (found := re.search(rb"VmHWM:\s+(\d+)", status.read_bytes())):
        return round(int(found[1]) / 1e3, 1)
    try:
        import resource
    except ModuleNotFoundError:  # Windows
        return 0.0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return round(peak / (1e6 if sys.platform == "darwin" else 1e3), 1)


def job_versions(packages: Iterable[str] = ()) -> dict[str, str]:
    """The versions of the packages that every job uses, and of those that its agent uses besides them."""
    return {name: version(name.replace("_", "-")) for name in (*PACKAGES, *packages)}


@dataclass(frozen=True)
class FinishedStage:
    """The record of a stage."""

    stage: int
    episodes: list[log.Episode]
    curves: list[run.Curve]
    memory: run.Memory  # the agent's so far
    usage: Usage  # what the stage took, its evaluation included
    evaluations: list[run.InterimEvaluation] = field(default_factory=list)


class JobFolder:
    """The folder of one unfinished job. A stage is finished once its record exists; it is written last."""

    def __init__(self, out: Path, job: TrainingJob) -> None:
        """``out`` is the submission's folder."""
        self.job, self.path = job, out / layout.PROGRESS / job.group.name / job.name

    def begin(self, settings: Settings) -> None:
        """Stores what the job's results depend on: settings, agent, tasks, and the versions of the packages.

        Raises ``BenchError`` if the folder belongs to others.
        """
        path, agent, group = self.path / SETTINGS, settings.agent, self.job.group
        versions = job_versions(agent.card.packages)
        document = {
            "agent": agent.name,
            "algorithm": agent.card.algorithm,
            "evaluation": agent.card.evaluation,
            "hyperparameters": agent.card.hyperparameters,
            "observes": msgspec.structs.asdict(agent.observes),
            "budget": settings.budget.name,
            "num_envs": settings.num_envs,
            "steps_counted": settings.steps_counted,
            "seeds": settings.seeds,
            "group": group.id,
            "tasks": group.task_ids,
            "fingerprints": [fingerprint_of(task) for task in group.tasks],
            "versions": versions,
            "isolated": hasattr(agent.factory, "for_job"),  # in a box, whose checkpoints have another format
        }
        text = json.dumps(document, indent=1, sort_keys=True)
        if not path.exists():
            write_text(path, f"{text}\n")
        stored, new = {"isolated": False, **json.loads(path.read_bytes())}, json.loads(text)
        if stored != new:
            code = "other-run-unfinished" if stored["versions"] == versions else "other-version"
            message = f"The unfinished run has other settings: {_changes(stored, new)}."
            hint = "Finish it with its settings and versions, delete the folder, or choose another --out."
            raise BenchError(code, message, str(self.path), hint)

    def finished(self) -> list[FinishedStage]:
        return [msgspec.json.decode(path.read_bytes(), type=FinishedStage) for path in self._records()]

    def resume(self, agent: agents.Agent, done: list[FinishedStage]) -> agents.Agent | None:
        """The agent after the last finished stage; None if it cannot be saved: the job starts again.

        Raises ``BenchError`` if the checkpoint is missing, or the agent cannot load it. Nothing is deleted.
        """
        if isinstance(agent, agents.Resumable):
            return agents.load(agent, self._checkpoint(done[-1].stage))
        self.forget()
        return None

    def finish(self, record: FinishedStage, agent: agents.Agent, last: bool) -> None:
        """Saves the agent, writes the record, then deletes the agent of the stage before."""
        checkpoint = self._checkpoint(record.stage)
        if isinstance(agent, agents.Resumable) and not last:
            partial = checkpoint.with_name(f".{checkpoint.stem}.partial.npz")
            agents.save(agent, partial)
            remove(checkpoint)  # of an attempt that ended before its record
            partial.replace(checkpoint)
        write_bytes(self.path / f"stage{record.stage}.json", msgspec.json.encode(record, enc_hook=float))
        for older in self.path.glob("agent*.npz"):
            if older != checkpoint:
                remove(older)

    def store_policy(self, stage: int, policy: AnyPolicy | None) -> None:
        """Writes the policy after a stage; removes the record of an earlier attempt, and a policy if None."""
        path = self.path / f"policy{stage}.npz"
        remove(self.path / f"stage{stage}.json")  # its episodes are not those of this policy
        if policy is None:
            path.unlink(missing_ok=True)
        else:
            write_bytes(path, npz_bytes(run_arrays({(stage, self.job.task_name): policy})))

    def policies(self) -> tuple[dict[str, agents.Array], list[Path]]:
        """The arrays of the policies of finished stages by full name, and the files that are missing."""
        paths = [self.path / f"policy{_number(record)}.npz" for record in self._records()]
        found = [path for path in paths if path.exists()]
        arrays = {name: array for path in found for name, array in npz_arrays(path.read_bytes()).items()}
        return arrays, [path for path in paths if path not in found]

    def forget(self) -> None:
        """Deletes every finished stage, the records first."""
        for path in [*reversed(self._records()), *self.path.glob("*.npz")]:
            remove(path)

    def remove(self) -> None:
        shutil.rmtree(self.path, ignore_errors=True)

    def _records(self) -> list[Path]:
        return sorted(self.path.glob("stage*.json"), key=_number)

    def _checkpoint(self, stage: int) -> Path:
        return self.path / f"agent{stage}.npz"


def _changes(old: Mapping[str, Any], new: Mapping[str, Any]) -> str:
    """What differs, in words: ``hyperparameters.rate is 0.1, and 0.2 in this command``."""
    pairs = []
    for key in sorted({*old, *new}):
        first, second = old.get(key), new.get(key)
        if isinstance(first, dict) and isinstance(second, dict):
            pairs += [f"{key}.{part}" for part in [_changes(first, second)] if part]
        elif first != second:
            pairs.append(f"{key} is {first!r}, and {second!r} in this command")
    return "; ".join(pairs)


def _number(record: Path) -> int:
    return int(record.stem.removeprefix("stage"))
