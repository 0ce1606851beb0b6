"""The way from an agent to a submission: every unit that was asked for, then the files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict
from pathlib import Path

from gym_extensions.baselines.agent import Factory
from gym_extensions.baselines.agent_checks import card_of
from gym_extensions.baselines.agent_fit import fit_agent
from gym_extensions.baselines.submission import folder as destination
from gym_extensions.baselines.submission import manifest
from gym_extensions.baselines.submission.writer import assemble, wanted
from gym_extensions.baselines.training.jobs import Unit
from gym_extensions.baselines.training.progress import Finished
from gym_extensions.baselines.training.request import Request, checked
from gym_extensions.baselines.training.runner import Listener, Settings
from gym_extensions.baselines.training.work import UnitWork, made, name_of
from gym_extensions.baselines.training.workers import run_all
from gym_extensions.catalog.groups import group
from gym_extensions.envs import make_batch
from gym_extensions.rollouts.layout import MANIFEST

Announce = Callable[[Mapping[str, int]], object]
"""Told all pieces of work that are to be run: their titles, and how many cells each evaluates."""


def train(
    agent: str | Factory,
    groups: str | Iterable[str],
    protocols: str | Iterable[str],
    budget: str,
    runs: int | Iterable[int],
    *,
    out: str | Path,
    jobs: int = 0,
    lanes: int | None = None,
    listen: Listener = lambda _: None,
    announce: Announce = lambda _: None,
) -> list[Path]:
    """Runs an agent through protocols and writes its submission; goes on where an earlier attempt stopped.

    Args:
        agent: a reference agent's name, ``module:factory``, or a factory (with ``jobs``, one that pickles).
        groups: names of groups; one, or several.
        protocols: of ``sequential``, ``single``, ``joint``; one, or several.
        budget: a budget's name.
        runs: training seeds below 1000; one, or several.
        out: the submission's folder.
        jobs: processes that run units side by side, each with one thread; 0 runs them one by one in this
            process, where the number of BLAS threads is the caller's.
        lanes: training environments side by side, where not the budget's number.
        listen: told how far each unit is.
        announce: told what is to be run.

    Returns:
        The logs that were asked for, existing ones included.

    Raises:
        BenchError: an unknown name, a foreign submission in ``out``, a folder that cannot be one, an agent
            that lacks what the loop calls, that gives no actions, or that exceeds the budget.
    """
    request = checked(groups, protocols, budget, runs, lanes)
    folder = Path(out)
    settings = Settings(name_of(agent), request.budget.name, lanes)
    _refuse_unfit(made(agent), settings, folder, request)
    plan = {log: wanted(folder, group(log[0]), log[1], request.runs) for log in request.logs()}
    units = [unit for asked in plan.values() for unit in asked]
    if units:
        destination.prepare(folder)
    announce({unit.title: unit.cells(request.budget) for unit in units})
    finished: dict[Unit, list[Finished]] = {}
    for index, stages in run_all([UnitWork(unit, agent, settings, folder) for unit in units], jobs, listen):
        unit = units[index]
        finished[unit] = stages
        asked = plan[unit.group, unit.protocol]
        if all(each in finished for each in asked):
            parts = {each: finished.pop(each) for each in asked}
            assemble(folder, group(unit.group), unit.protocol, parts, settings)
    return [folder / name / f"{protocol}.csv" for name, protocol in plan]


def _refuse_unfit(make: Factory, settings: Settings, out: Path, request: Request) -> None:
    """Says before hours of training, not after them, what cannot become a submission."""
    destination.refuse_unfit(out)
    path = out / MANIFEST
    existing = manifest.read(path)
    env = make_batch(group(request.groups[0]).tasks[0], 1)
    agent = fit_agent(make, (env.single_observation_space, env.single_action_space), settings.agent)
    card = asdict(card_of(agent, settings.agent))
    env.close()
    manifest.refuse_mixing(path, existing, manifest.written(card, settings.budget, settings.lanes))
