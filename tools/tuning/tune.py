"""Tunes every method by the same rule, with the same number of training steps.

    python -m tools.tuning.tune cloning l2            # run the trials that are missing, one after the other
    python -m tools.tuning.tune cloning l2 --report   # the mean scores of each setting, and the chosen one

The first line of ``<method>.jsonl`` is the plan: the settings to try, the tasks, and the rule of choice. Each
further line is one trial: one setting on one body, whose tasks are learned in order. A command that was
interrupted continues with the first trial that the file does not have.
"""

import json
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from statistics import fmean
from typing import Any

import msgspec

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.submission import commit_of
from gym_extensions.catalog.tasks import task
from gym_extensions.errors import BenchError, reports_mistakes, require_known
from gym_extensions.files import write_text
from gym_extensions.references import load_references
from tools import argument_parser
from tools.tuning.measure_learners import Run, measure

HERE = Path(__file__).resolve().parent
"""The folder of the plans and trials."""


class Plan(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What was fixed before the first trial."""

    method: str  # a name of ``train``
    settings: list[dict[str, Any]]  # keyword arguments of the method's factory
    bodies: list[str]
    gravities: list[float]  # of a body's tasks in training order, as multiples of the standard gravity
    steps: int  # per task
    batch_steps: int
    num_envs: int
    seed: int  # of every trial
    references: str  # version of the floors and experts that normalize returns
    rule: str  # of choice, as text


class Trial(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One setting on one body."""

    setting: int  # index in ``Plan.settings``
    body: str
    returns: list[list[float]]  # mean returns: a row per learned task, with a column per task
    end_score: float
    learned_score: float
    cpu_seconds: float  # of training, without evaluation
    commit: str  # of the code; with the suffix ``-dirty`` if files had been changed


def read(path: Path) -> tuple[Plan, list[Trial]]:
    """The plan and the finished trials of a file."""
    first, *rest = path.read_text("utf-8").splitlines()
    return msgspec.json.decode(first, type=Plan), [msgspec.json.decode(line, type=Trial) for line in rest]


def append(path: Path, trial: Trial) -> None:
    """Adds a line. The file is replaced as a whole, so an interruption leaves no part of a line."""
    write_text(path, path.read_text("utf-8") + json.dumps(msgspec.to_builtins(trial)) + "\n")


def scores(plan: Plan, body: str, returns: Sequence[Sequence[float]]) -> tuple[float, float]:
    """The end score and the learned score of a trial: means of normalized returns over its tasks.

    The end score is measured after the last task, the learned score on each task right after training on it.
    Floor (0) and expert (1) are those of the body at standard gravity.
    """
    reference = load_references(plan.references).tasks[task(body).id]
    end = fmean(reference.normalize(value) for value in returns[-1])
    learned = fmean(reference.normalize(row[index]) for index, row in enumerate(returns))
    return round(end, 6), round(learned, 6)


def missing(plan: Plan, trials: Sequence[Trial]) -> list[tuple[int, str]]:
    """The setting and the body of the trials that were not run yet, in order."""
    done = {(trial.setting, trial.body) for trial in trials}
    return [pair for pair in product(range(len(plan.settings)), plan.bodies) if pair not in done]


def run_trial(plan: Plan, setting: int, body: str) -> Trial:
    """Trains one setting on the tasks of one body."""
    tasks = tuple(f"{body}@{gravity}" for gravity in plan.gravities)
    sizes = (plan.steps, plan.batch_steps, plan.num_envs)
    rows = measure(Run(plan.method, plan.settings[setting], tasks, plan.seed, *sizes))
    returns = [[row["returns"][name] for name in tasks] for row in rows]
    seconds = sum(row["cpu_s_per_1M"] for row in rows) * plan.steps / 1e6
    return Trial(setting, body, returns, *scores(plan, body, returns), round(seconds, 1), commit_of(HERE))


def run_in_new_process(plan: Plan, setting: int, body: str) -> Trial:
    """``run_trial`` in a process of its own, so that no trial depends on those before it."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(run_trial, plan, setting, body).result()


def tune(path: Path) -> None:
    """Runs the missing trials of a file. Raises ``BenchError`` if the method's library is not installed."""
    plan, trials = read(path)
    algorithms.factory(plan.method)
    for setting, body in missing(plan, trials):
        trial = run_in_new_process(plan, setting, body)
        append(path, trial)
        result = f"end score {trial.end_score:.3f}, {trial.cpu_seconds:.0f} CPU seconds"
        print(f"{plan.method}, {described(plan.settings[setting])}, {body}: {result}", flush=True)


def described(setting: dict[str, Any]) -> str:
    """A setting as text, such as ``coefficient=0.1``."""
    return " ".join(f"{name}={json.dumps(value)}" for name, value in setting.items())


def report(path: Path) -> str:
    """A table with the mean scores of each setting, and the chosen setting if all trials were run."""
    plan, trials = read(path)
    width = max(len(described(setting)) for setting in plan.settings)
    lines = [f"{plan.method}: {len(trials)} of {len(plan.settings) * len(plan.bodies)} trials"]
    lines.append("  ".join([" " * width, "end score", *(f"{body:>11}" for body in plan.bodies), "learned"]))
    means = {}
    for index, setting in enumerate(plan.settings):
        found = {trial.body: trial for trial in trials if trial.setting == index}
        cells = [f"{found[body].end_score:11.3f}" if body in found else f"{'–':>11}" for body in plan.bodies]
        end = learned = "–"
        if len(found) == len(plan.bodies):
            means[index] = fmean(trial.end_score for trial in found.values())
            end = f"{means[index]:.3f}"
            learned = f"{fmean(trial.learned_score for trial in found.values()):.3f}"
        lines.append("  ".join([f"{described(setting):{width}}", f"{end:>9}", *cells, f"{learned:>7}"]))
    if len(means) == len(plan.settings) > 1:
        best = max(means, key=means.__getitem__)  # the first of equal ones
        lines.append(f"chosen: {described(plan.settings[best])}")
    return "\n".join(lines)


@reports_mistakes
def main(argv: Sequence[str] | None = None) -> int:
    """Runs trials or reports them; the exit status is 1 if a method's library is missing."""
    parser = argument_parser("tools.tuning.tune", __doc__)
    parser.add_argument("methods", nargs="+", metavar="METHOD")
    parser.add_argument("--report", action="store_true", help="print the scores, train nothing")
    options = parser.parse_args(argv)
    for method in options.methods:
        require_known("method", method, {path.stem for path in HERE.glob("*.jsonl")}, str(HERE))
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # read by the spawned processes, which load numpy afresh
    if not options.report and not commit_of(HERE):
        hint = "Run it in a clone of the repository."
        raise BenchError("no-commit", "Every trial states the commit of its code.", str(HERE), hint)
    status = 0
    for method in options.methods:
        path = HERE / f"{method}.jsonl"
        try:
            print(report(path)) if options.report else tune(path)
        except BenchError as error:
            if error.code != "missing-extra":
                raise
            print(f"{method} was left out: {error}", flush=True)
            status = 1
    return status


if __name__ == "__main__":
    raise SystemExit(main())
