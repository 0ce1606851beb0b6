"""Episodes of stored policies on given seeds. The policies are read and run in the process with limits."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any

import msgspec
import mujoco
import numpy as np

from gym_extensions import files, versions
from gym_extensions.catalog.groups import TaskGroup, with_custom
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs import fingerprinting, make_vec, rollout
from gym_extensions.errors import BenchError
from gym_extensions.submissions import fetch
from gym_extensions.submissions.layout import run_key
from gym_extensions.submissions.policies import files as stored, onnx
from gym_extensions.submissions.run import ARITHMETIC
from gym_extensions.verification.limits import TOO_SLOW, Limits, answers, end_all

BASE_SECONDS, SECONDS_PER_CELL, HOURS = 120, 60, 4.0
"""Processor time of a process, more for each of its cells on average, and of all processes of a submission. A
cell of 20 long episodes takes a few seconds. The step of review.yml is longer than the hours."""


@dataclass(frozen=True)
class Cell:
    """Episodes of the policy of a stage on a task: its index, a seed per episode, and the seed of the noise.

    Without a seed of the noise the policy must be deterministic.
    """

    stage: int
    task: int
    seeds: tuple[int, ...]
    noise: int | None = None


@dataclass(frozen=True)
class RunRequest:
    """The cells of a run that are wanted, and where its policies are.

    ``folder`` is the submission, ``file`` the policies' file if it lies elsewhere, and ``policies`` the
    digest of its content that the run states.
    """

    folder: str
    group: str
    protocol: str
    run: int
    policies: str
    observes_task: bool
    cells: tuple[Cell, ...]
    file: str = ""

    @property
    def name(self) -> str:
        """The name of the run, ``group/protocol/runN``."""
        return run_key(self.group, self.protocol, self.run)

    def key(self, group: TaskGroup, cell: Cell) -> stored.Key:
        """The key of the policy of a cell."""
        return cell.stage, group.tasks[cell.task].name if self.protocol == "single" else None


@dataclass(frozen=True)
class Played:
    """The outcomes of every cell of a run, or why its policies do not give any.

    ``runtime`` is what ran ONNX networks, with its version; empty for plain arrays. ``sketches`` are those of
    the weights (:func:`~gym_extensions.submissions.policies.files.parameter_sketch`).
    """

    outcomes: tuple[tuple[rollout.Outcome, ...], ...] = ()
    problem: str = ""
    runtime: str = ""
    sketches: dict[str, list[float]] = field(default_factory=dict)


@contextmanager
def no_log_file() -> Iterator[None]:
    """Stops MuJoCo from writing warnings of unstable states into the current folder."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def run_cell(
    group: TaskGroup,
    policy: stored.AnyPolicy,
    cell: Cell,
    watch: Callable[[Any, Any], None] | None = None,
    world: Task | None = None,
) -> list[rollout.Outcome]:
    """The outcomes of a cell, an episode per seed, with the policy of its stage.

    A cell has environments of its own: making them takes milliseconds, and one of a Humanoid 17 MB of the
    4 GiB that the process with limits has. ``watch`` is called with them and the actions, after the reset and
    after every step. With ``world``, the episodes run in that task, and the policy still observes the index
    of the cell's task.

    Raises:
        BenchError: the policy does not fit the task, samples without a seed of the noise, or gives an action
            that is not finite.
    """
    env: Any = make_vec(world or group.tasks[cell.task], len(cell.seeds))
    with closing(env), np.errstate(all="ignore"), no_log_file():
        shape = env.single_action_space.shape
        if policy.num_actions != int(np.prod(shape)):
            message = f"The policy has {policy.num_actions} actions; the task has {shape[0]}."
            raise BenchError("bad-actions", message)
        policy.reset()
        noise = None if cell.noise is None else np.random.default_rng(cell.noise)

        def act(observations: Any, *_: Any) -> Any:
            return policy.act(observations, noise, cell.task).reshape(len(observations), *shape)

        seen = None if watch is None else lambda actions: watch(env, actions)
        return rollout.run_episodes(env, cell.seeds, act, watch=seen, where="the policy")


def stored_policies(request: RunRequest, group: TaskGroup) -> dict[stored.Key, stored.AnyPolicy]:
    """The policies of a run.

    Raises ``BenchError`` if they cannot be read, are others than those of the run's document, or one depends
    on the task although the agent does not observe it.
    """
    if request.file:
        arrays = fetch.read_copy(Path(request.file), request.policies, request.name)
    else:
        arrays = stored.read_arrays(Path(request.folder), group, request.protocol, request.run)
        stored.require_digest(arrays, request.policies)
    policies = stored.policies_of(arrays, group, request.protocol)
    rows = max((policy.num_tasks for policy in policies.values()), default=0)
    if rows and not request.observes_task:
        raise BenchError("bad-policies", "A policy depends on the task, which the agent does not observe.")
    if rows > len(group.tasks):
        raise BenchError("bad-policies", f"A policy has arrays for {rows} tasks of {len(group.tasks)}.")
    return policies


def played(request: RunRequest, group: TaskGroup) -> Iterator[Played]:
    """The outcomes of each cell of a run, one after another, in this process; a problem is the last.

    The first one states the runtime and the sketches; without cells, it is the only one. Raises
    ``BenchError`` with another engine than that of the published tasks, without what runs networks, or if a
    fetched file is not that of the run.
    """
    fingerprinting.require_published_engine()
    try:
        policies = stored_policies(request, group)
        has_networks = any(isinstance(policy, onnx.OnnxPolicy) for policy in policies.values())
        runtime = f"{onnx.RUNTIME} {versions.version(onnx.RUNTIME)}" if has_networks else ""
        found = Played(runtime=runtime, sketches=stored.parameter_sketch(policies))
        if not request.cells:
            yield found
        for cell in request.cells:
            try:
                outcomes = tuple(run_cell(group, policies[request.key(group, cell)], cell))
            except BenchError as error:
                where = f"stage {cell.stage}, {group.tasks[cell.task].name}"
                raise BenchError(error.code, f"{where}: {error.message}", hint=error.hint) from error
            yield replace(found, outcomes=(outcomes,))
            found = Played()
    except BenchError as error:
        if error.code in (onnx.MISSING, fetch.OTHER_FILE):
            raise
        yield Played(problem=error.message)


def play(call: Mapping[str, Any]) -> Iterator[Any]:
    """The job of the process with limits: the outcomes of the cells of runs, each with the run's index."""
    requests = msgspec.convert(call["runs"], list[RunRequest])
    group = with_custom(call["groups"])[requests[0].group]
    for number, request in enumerate(requests):
        yield from ([number, msgspec.to_builtins(part)] for part in played(request, group))


def processor_seconds() -> float:
    """The processor time of this process and of those that it started and that ended."""
    return sum(os.times()[:4])


@dataclass
class Player:
    """Runs episodes of stored policies in processes with limits, and keeps the outcomes of cells in a folder.

    So an interrupted verification goes on where it was. A file is named by all that determines its content:
    the cell, the run's files and versions. No version tells what the code of a foreign environment does, so
    nothing is kept of a group with such a task.

    Attributes:
        folder: of the outcomes.
        groups: TOML files of custom groups that submissions contain.
        jobs: processes that work at once.
        hours: of processor time for all that is done with it, its processes included; what needs more is too
            slow.
        started, done: called with the number of cells before they are run, and of those that are finished, in
            any thread.
    """

    folder: Path
    groups: Sequence[str] = ()
    jobs: int = 1
    hours: float = HOURS
    started: Callable[[int], None] = lambda cells: None
    done: Callable[[int], None] = lambda cells: None
    _before: float = field(default_factory=processor_seconds, init=False)

    @cached_property
    def _machine(self) -> list[str]:
        packages = (versions.version("numpy"), versions.version("gym-extensions"), str(ARITHMETIC))
        runtime = versions.version_or_none(onnx.RUNTIME)
        return [*fingerprinting.engine().values(), *packages, *([runtime] if runtime else [])]

    @cached_property
    def _foreign(self) -> set[str]:
        """The names of the groups with a task of another package."""
        groups = with_custom(self.groups).values()
        return {group.name for group in groups if any(task.is_foreign for task in group.tasks)}

    def _file(self, request: RunRequest, cell: Cell | None) -> Path:
        """Where the outcomes of a cell are kept, or without one what is known of the policies."""
        one = replace(request, folder="", file="", cells=() if cell is None else (cell,))
        return self.folder / f"{sha256(msgspec.json.encode([one, self._machine])).hexdigest()}.json"

    def _kept(self, request: RunRequest) -> dict[Cell | None, Played]:
        """What is kept of the cells of a run, or without cells of its policies (None)."""
        kept = dict[Cell | None, Played]()
        for cell in () if request.group in self._foreign else request.cells or (None,):
            with suppress(OSError, ValueError):  # it is not there, or was not written to its end
                kept[cell] = msgspec.json.decode(self._file(request, cell).read_bytes(), type=Played)
        return kept

    def play(self, requests: Sequence[RunRequest]) -> list[Played]:
        """The outcomes of each run, as they are kept, or made now.

        Raises ``BenchError`` if a process reached a limit or failed, or the hours are used up.
        """
        self.started(sum(len(request.cells) for request in requests))
        found = [self._kept(request) for request in requests]
        missing = dict[int, RunRequest]()
        for number, request in enumerate(requests):
            cells = tuple(cell for cell in request.cells if cell not in found[number])
            if cells or not found[number]:
                missing[number] = replace(request, cells=cells)
            self.done(len(request.cells) - len(cells))
        if missing:
            self._run(missing, found)
        return [_joined(request, parts) for request, parts in zip(requests, found, strict=True)]

    def _run(self, missing: Mapping[int, RunRequest], found: Sequence[dict[Cell | None, Played]]) -> None:
        """Runs what is missing of the requests with these numbers, keeps it, and adds it to what is found."""
        batches = list[list[int]]()  # of the numbers of requests, by group
        for group in dict.fromkeys(request.group for request in missing.values()):
            numbers = [number for number, request in missing.items() if request.group == group]
            batches += [numbers[first :: self.jobs] for first in range(min(self.jobs, len(numbers)))]
        left = 3600 * self.hours - (processor_seconds() - self._before)
        if left <= 0:
            raise BenchError(TOO_SLOW, f"{self.hours:g} hours of processor time were used up.")
        per_process = min(BASE_SECONDS, left / len(batches))
        cells = sum(len(request.cells) for request in missing.values())
        per_cell = min(SECONDS_PER_CELL, (left - per_process * len(batches)) / max(1, cells))

        def work(numbers: Sequence[int]) -> None:
            batch = [missing[number] for number in numbers]
            call = {"runs": msgspec.to_builtins(batch), "groups": list(self.groups)}
            waiting = [iter(request.cells or (None,)) for request in batch]
            for place, answer in answers(play, call, limits_of(batch, per_process, per_cell)):
                request, cell, part = batch[place], next(waiting[place]), msgspec.convert(answer, Played)
                found[numbers[place]][cell] = part
                if not part.problem and request.group not in self._foreign:  # a problem may be mended
                    files.write_bytes(self._file(request, cell), msgspec.json.encode(part))
                self.done(len(request.cells) if part.problem else 1)

        with ThreadPoolExecutor(self.jobs) as pool:
            futures = [pool.submit(work, numbers) for numbers in batches]
            try:
                for future in as_completed(futures):
                    future.result()
            except BaseException:  # Ctrl-C as well
                pool.shutdown(wait=False, cancel_futures=True)
                end_all()
                raise


def _joined(request: RunRequest, parts: Mapping[Cell | None, Played]) -> Played:
    """The outcomes of all cells of a run from those of each, or the problem."""
    if problem := next((part.problem for part in parts.values() if part.problem), ""):
        return Played(problem=problem)
    outcomes = tuple(parts[cell].outcomes[0] for cell in request.cells)
    runtime = next((part.runtime for part in parts.values() if part.runtime), "")
    sketches = next((part.sketches for part in parts.values() if part.sketches), {})
    return Played(outcomes, "", runtime, sketches)


def limits_of(
    requests: Sequence[RunRequest], per_process: float = BASE_SECONDS, per_cell: float = SECONDS_PER_CELL
) -> Limits:
    """Limits of the process that runs these requests: seconds for itself, and for each cell on average."""
    seconds = round(per_process + per_cell * sum(len(request.cells) for request in requests))
    return Limits(cpu_seconds=seconds, wall_seconds=4 * seconds)
