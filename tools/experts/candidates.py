"""Candidates for the experts: their policies, their returns so far, and the choice among them."""

import functools
import json
import math
import re
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.tasks import Task, mujoco_tasks, task as published_task
from gym_extensions.envs import make_vec
from gym_extensions.envs.rollout import run_episodes
from gym_extensions.errors import BenchError
from gym_extensions.files import write_bytes, write_text
from gym_extensions.references import Reference, experts
from gym_extensions.references.experts import Measurement, Step, seed
from gym_extensions.submissions.log import read_log
from gym_extensions.submissions.policies.files import has_policies, npz_bytes, read_policies
from gym_extensions.submissions.policies.mlp import Policy
from tools.experts.recipes import FAMILIES

LANES = 100
"""Episodes that are stepped together. A matrix product may depend on it in the last bit, so it is fixed."""
SCREENING = 20
"""Episodes that a candidate is first seen with."""
OWN, GENERAL, RIVALS = 3, 4, 2
"""Stored policies that a task sees by its logs and by those of its body; candidates beside the best."""
BEAM_SCALE = 0.25
"""What a policy without range sensor divides the beams by when it gets one; its weights for them are 0."""
STORED = "stored:"
STAGE_STEPS = 300_000
"""Environment steps per task in the protocol of the submissions."""
QUICK = 100
"""Selection episodes that a published policy needs, and the episodes of a quick check."""
THRESHOLD = 1.05
"""Normalized return of a cell's log from which it is evaluated."""
CLEAR_ERRORS = 3.0
"""Standard errors of the difference by which a policy must beat an expert."""
SUBMISSIONS = ("trpo", "sac-fresh-buffer", "sac", "ppo", "reset", "cloning", "online-ewc", "l2", "l2-init")
"""Submissions whose policies have no axis of tasks."""


def episodes(policy: Policy, task: Task, seeds: Sequence[int]) -> tuple[list[float], list[bool | None]]:
    """Returns and successes of one episode per seed, ``LANES`` of them at a time."""
    outcomes = []
    for start in range(0, len(seeds), LANES):
        chunk = seeds[start : start + LANES]
        env = make_vec(task, len(chunk))
        outcomes += run_episodes(env, chunk, lambda observations, *_: policy.act(observations))
        env.close()
    return [outcome.return_ for outcome in outcomes], [outcome.success for outcome in outcomes]


@functools.cache
def num_observations(task: Task) -> int:
    """The number of the task's observations."""
    env: Any = make_vec(task, 1)
    env.close()
    return math.prod(env.single_observation_space.shape)


def fitted(policy: Policy, inputs: int) -> Policy:
    """The policy for a task with range beams where it had none, or without them where it had some.

    New beams have weight 0, so that its actions stay the same. Beams that are missing read 0, as in front of
    a parked wall, and become part of the bias.
    """
    known, first = int(policy.num_inputs or 0), policy.weights[0]
    mean, scale = policy.observation_mean, policy.observation_scale
    if inputs == known:
        return policy
    if inputs > known:
        new = inputs - known
        weights = np.concatenate([first, np.zeros((new, first.shape[1]), first.dtype)])
        biases = policy.biases
        if mean is not None and scale is not None:
            mean = np.concatenate([mean, np.zeros(new, mean.dtype)])
            scale = np.concatenate([scale, np.full(new, BEAM_SCALE, scale.dtype)])
    else:
        weights, beams = first[:inputs], np.zeros(known - inputs)
        if mean is not None and scale is not None:
            beams = -mean[inputs:] / scale[inputs:]
            mean, scale = mean[:inputs], scale[:inputs]
        clip = policy.observation_clip or math.inf
        constant = np.clip(beams, -clip, clip).astype(first.dtype) @ first[inputs:]
        biases = (policy.biases[0] + constant, *policy.biases[1:])
    layers = (weights, *policy.weights[1:])
    return replace(policy, weights=layers, biases=biases, observation_mean=mean, observation_scale=scale)


class Workplace:
    """The folder in which candidates and their returns are kept between commands.

    ``policies/<run>/<steps>.npz`` are the checkpoints of the training runs, ``policies/<run>/run.json`` says
    how they came about, and ``returns/<purpose>/<task>/<candidate>.json`` has the returns on the seeds of a
    purpose, in their order. ``submissions`` is the folder of the submissions.
    """

    def __init__(self, folder: Path, submissions: Path = Path("submissions")) -> None:
        self.folder, self.submissions = folder, submissions

    def policy(self, candidate: str, task: Task) -> Policy:
        """The policy of a candidate, fitted to the task's observations."""
        if candidate.startswith(STORED):
            policy = stored_policy(self.submissions, candidate)
        else:
            run, _, steps = candidate.rpartition("@")
            policy = experts.read_policy(self.folder / "policies" / run / f"{steps}.npz")
        return replace(fitted(policy, num_observations(task)), head="deterministic")

    def returns(self, candidate: str, task: Task, purpose: str) -> dict[str, Any]:
        """What is known of a candidate: ``returns``, ``success`` and ``cpu_seconds``."""
        path = self._path(candidate, task, purpose)
        empty: dict[str, Any] = {"candidate": candidate, "returns": [], "success": [], "cpu_seconds": 0.0}
        return json.loads(path.read_text()) if path.exists() else empty

    def evaluate(self, candidate: str, task: Task, purpose: Any, count: int) -> Measurement:
        """Evaluates a candidate on the first ``count`` seeds of a purpose, as far as it was not yet."""
        known = self.returns(candidate, task, purpose)
        done = len(known["returns"])
        if done < count:
            began = time.process_time()
            seeds = [seed(task, purpose, index) for index in range(done, count)]
            returns, successes = episodes(self.policy(candidate, task), task, seeds)
            known["returns"] += returns
            known["success"] += successes
            known["cpu_seconds"] += time.process_time() - began
            write_text(self._path(candidate, task, purpose), json.dumps(known))
        return summary(known, max(count, done))

    def candidates(self, task: Task) -> dict[str, Measurement]:
        """Every candidate of a task that was seen, with all its selection episodes."""
        paths = sorted((self.folder / "returns" / "select" / task.bare_name).glob("*.json"))
        rows = [json.loads(path.read_text()) for path in paths]
        return {row["candidate"]: summary(row, len(row["returns"])) for row in rows}

    def select(self, task: Task, count: int) -> str | None:
        """The candidate with the best mean over ``count`` selection seeds; None without candidates.

        The best by the episodes so far gets the missing ones, until the best has all of them. Then the next
        ``RIVALS`` do if they could still be better, by two standard errors of the difference.
        """
        while found := sorted(self.candidates(task).items(), key=lambda item: -item[1].mean):
            (name, best), *others = found
            if best.episodes < count:
                self.evaluate(name, task, "select", count)
                continue
            for rival, seen in others[:RIVALS]:
                error = math.hypot(best.standard_error, seen.standard_error)
                if seen.episodes < count and best.mean - seen.mean < 2 * error:
                    self.evaluate(rival, task, "select", count)
                    break
            else:
                return name
        return None

    def best(self, task: Task) -> str | None:
        """The best candidate of those with 100 selection episodes, or with the most if none has 100."""
        found = self.candidates(task)
        most = max((seen.episodes for seen in found.values()), default=0)
        full = {name: seen for name, seen in found.items() if seen.episodes >= min(most, QUICK)}
        return max(full, key=lambda name: full[name].mean, default=None)

    def resolved(self, parent: str | None) -> str | None:
        """The candidate that ``best:<task>`` or ``last:<run>`` means now; any other name as it is.

        Raises ``BenchError`` if there is none.
        """
        kind, _, name = (parent or "").partition(":")
        if kind == "best":
            if (best := self.best(published_task(name))) is None:
                hint = "Harvest or train candidates of the task first, or name one with --from."
                raise BenchError("unknown-candidate", f"{name} has no candidate.", str(self.folder), hint)
            return best
        if kind == "last":
            return f"{name}@{self.run(name)['checkpoints'][-1]['steps']}"
        return parent

    def run(self, name: str) -> dict[str, Any]:
        """What is known of a training run, finished or not. Raises ``BenchError`` if there is none."""
        paths = (self.folder / "policies" / name / file for file in ("run.json", "running.json"))
        if (found := next((path for path in paths if path.exists()), None)) is None:
            raise BenchError("unknown-run", f"There is no run {name!r}.", str(self.folder), "Train it first.")
        return json.loads(found.read_text())

    def steps_tried(self, task: Task) -> int:
        """Environment steps of all runs whose checkpoints are candidates of a task."""
        runs = [self.run(path.parent.name) for path in (self.folder / "policies").glob("*/run*.json")]
        return sum(row["checkpoints"][-1]["steps"] for row in runs if task.name in row["targets"])

    def _path(self, candidate: str, task: Task, purpose: str) -> Path:
        name = re.sub(r"[^\w@.-]+", "+", candidate)
        return self.folder / "returns" / purpose / task.bare_name / f"{name}.json"


def summary(row: dict[str, Any], count: int) -> Measurement:
    """The first ``count`` episodes of a row of :meth:`Workplace.returns`."""
    returns = np.array(row["returns"][:count])
    known = [float(value) for value in row["success"][:count] if value is not None]
    return Measurement(
        episodes=len(returns),
        mean=float(returns.mean()),
        deviation=float(returns.std(ddof=1)),
        success=float(np.mean(known)) if known else None,
        cpu_seconds=round(row["cpu_seconds"], 1),
    )


def stored_policy(submissions: Path, candidate: str) -> Policy:
    """A policy of a submission, such as ``stored:trpo/hopper-body/sequential-run1-stage8``."""
    match = experts.STORED.fullmatch(candidate)
    assert match is not None, candidate
    submission, group_name, protocol, run, stage, task_name = match.groups()
    policies = read_policies(submissions / submission, GROUPS[group_name], protocol, int(run))
    policy = policies[int(stage), task_name]
    assert isinstance(policy, Policy), "the submissions that are harvested have plain arrays"
    return policy


def stored_candidates(submissions: Path) -> dict[str, list[tuple[float, str]]]:
    """Per task the stored policies with their mean return in the logs of the submissions, the best first."""
    found: dict[str, list[tuple[float, str]]] = defaultdict(list)
    for path in sorted(submissions.glob("*/*/*/run*.csv")):
        submission, group_name, protocol, run = *path.parts[-4:-1], path.stem
        of_run = (GROUPS[group_name], protocol, int(run.removeprefix("run")))
        if submission not in SUBMISSIONS or not has_policies(submissions / submission, *of_run):
            continue
        means = read_log(path).groupby(["stage", "task"], as_index=False)["return"].mean()
        for stage, task_id, mean in means.itertuples(index=False):
            name = task_id.removeprefix("gym_extensions/").removesuffix("-v0")
            ending = f"-{name}" if protocol == "single" else ""
            found[name].append(
                (mean, f"{STORED}{submission}/{group_name}/{protocol}-{run}-stage{stage}{ending}")
            )
    return {name: sorted(policies, reverse=True) for name, policies in found.items()}


def harvest(work: Workplace, family: str) -> Iterator[str]:
    """Sees stored policies on all tasks of the bodies of a family; yields a line for each.

    Every task sees the best ``OWN`` by its logs, and the ``GENERAL`` policies of the bodies with the highest
    return in a log of any of the tasks.
    """
    ranked = stored_candidates(work.submissions)
    tasks = [row for row in mujoco_tasks() if FAMILIES.get(row.base) == family]
    pool = sorted((cell for row in tasks for cell in ranked.get(row.bare_name, [])[:OWN]), reverse=True)
    generalists = list(dict.fromkeys(candidate for _, candidate in pool))[:GENERAL]
    for row in tasks:
        own = [candidate for _, candidate in ranked.get(row.bare_name, [])[:OWN]]
        for candidate in dict.fromkeys([*own, *generalists]):
            seen = work.evaluate(candidate, row, "select", SCREENING)
            yield f"{row.name} {candidate} {seen.mean:.0f} ± {seen.deviation:.0f}"


def select(work: Workplace, tasks: Sequence[Task], count: int) -> Iterator[str]:
    """Selects the expert of each task; yields a line for each."""
    for row in tasks:
        best = work.select(row, count)
        seen = work.candidates(row).get(best or "")
        yield f"{row.name} {best} {seen.mean:.1f} ± {seen.deviation:.1f}" if seen else f"{row.name} none"


def history(work: Workplace, candidate: str) -> tuple[Step, ...]:
    """The training runs behind a candidate, the first one first."""
    if match := experts.STORED.fullmatch(candidate):
        submission, group, protocol, _, stage, _ = match.groups()
        tasks = {"sequential": int(stage), "single": 1}.get(protocol, len(GROUPS[group].tasks))
        return (Step(candidate, submission, tasks * STAGE_STEPS),)
    name, steps_text = candidate.rsplit("@", 1)
    run = work.run(name)
    steps = int(steps_text)
    seconds = next(row["cpu_seconds"] for row in run["checkpoints"] if row["steps"] == steps)
    last = Step(f"{name}@{steps}", run["agent"], steps, seconds, run["command"], tuple(run["tasks"]))
    return (*(history(work, run["parent"]) if run["parent"] else ()), last)


def write_policy(path: Path, policy: Policy) -> None:
    """Writes a policy's arrays as a compressed npz file, whole or not at all."""
    write_bytes(path, npz_bytes(policy.arrays()))


def challenge(
    work: Workplace,
    cells: Mapping[str, Sequence[tuple[float, str]]],
    count: int,
    references: Mapping[str, Reference],
) -> Iterator[str]:
    """Evaluates cells of submissions above the expert on fresh seeds; yields a line for each.

    A cell is a task after a stage of a run. It is above if the normalized mean of its 20 episodes is above
    ``THRESHOLD``; 20 episodes are noise, so that an equal policy exceeds it now and then. It beats the
    expert if its mean over the fresh episodes is higher by three standard errors of the difference. Open
    tasks and provisional experts are left out.

    Args:
        work: keeps the returns.
        cells: mean return in the log and candidate, the best first, by task (:func:`stored_candidates`).
        count: number of fresh episodes.
        references: floors and experts by task id.
    """
    for name, ranked in cells.items():
        task = published_task(name)
        row = references[task.id]
        if row.expert is None or not row.expert.policy or row.expert.provisional:
            continue
        floor, expert = row.floor.mean, row.expert
        for mean, candidate in ranked:
            score = (mean - floor) / (expert.mean - floor)
            if score <= THRESHOLD:
                break  # the best are first
            seen = work.evaluate(candidate, task, "challenge", count)
            error = math.hypot(seen.standard_error, expert.standard_error)
            beats = seen.mean - expert.mean > CLEAR_ERRORS * error
            yield (
                f"{task.name} {candidate}: {score:.3f} in its log; in {seen.episodes} episodes "
                f"{seen.mean:.1f} ± {seen.standard_error:.1f}, the expert {expert.mean:.1f} ± "
                f"{expert.standard_error:.1f}{': beats the expert' if beats else ''}"
            )
