"""The way from an agent to a submission: every unit that was asked for, then the files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from gym_extensions.baselines import algorithms, manifest
from gym_extensions.baselines.agent import Factory, card_of
from gym_extensions.baselines.assemble import assemble, wanted
from gym_extensions.baselines.jobs import Job, run_all
from gym_extensions.baselines.protocol import Listener, Settings
from gym_extensions.baselines.requests import Request, checked
from gym_extensions.baselines.units import Unit
from gym_extensions.catalog.groups import group
from gym_extensions.envs import make_batch

PlanListener = Callable[[Sequence[Unit]], object]


def train(
    agent: str | Factory,
    groups: str | Iterable[str],
    protocols: str | Iterable[str],
    budget: str,
    runs: int | Iterable[int],
    out: str | Path,
    *,
    jobs: int = 0,
    lanes: int | None = None,
    listen: Listener = lambda _: None,
    announce: PlanListener = lambda _: None,
) -> list[Path]:
    """Runs an agent through protocols and writes its submission; goes on where an earlier attempt was stopped.

    Args:
        agent: a reference agent's name, ``module:factory``, or a factory (with ``jobs``, one that pickles).
        groups: names of groups; one, or several.
        protocols: of ``sequential``, ``single``, ``joint``; one, or several.
        budget: a budget's name.
        runs: training seeds below 1000; one, or several.
        out: the submission's folder.
        jobs: processes that run units side by side, each with one thread; 0 runs them one by one in this process,
            where the number of BLAS threads is the caller's.
        lanes: training environments side by side, where not the budget's number.
        listen: told how far each unit is.
        announce: told all units that are to be run.

    Returns:
        The logs that were asked for, existing ones included.

    Raises:
        BenchError: an unknown name, a foreign submission in ``out``, or an agent that exceeds the budget.
    """
    request = checked(groups, protocols, budget, runs, lanes)
    folder = Path(out)
    make = algorithms.factory(agent) if isinstance(agent, str) else agent
    name = agent if isinstance(agent, str) else getattr(agent, "__name__", type(agent).__name__)
    settings = Settings(name, request.budget.name, lanes)
    plan = {log: wanted(folder, group(log[0]), log[1], request.runs) for log in request.logs()}
    _refuse_foreign(make, settings, folder, request)
    announce([unit for asked in plan.values() for unit in asked])
    waiting = [Job(unit, agent, settings, folder) for asked in plan.values() for unit in asked]
    finished = {}
    for unit, stages in run_all(waiting, jobs, listen):
        finished[unit] = stages
        asked = plan[unit.group, unit.protocol]
        if all(each in finished for each in asked):
            parts = {each: finished.pop(each) for each in asked}
            assemble(folder, group(unit.group), unit.protocol, parts, settings)
    return [folder / name / f"{protocol}.csv" for name, protocol in plan]


def _refuse_foreign(make: Factory, settings: Settings, out: Path, request: Request) -> None:
    path = out / "submission.toml"
    existing = manifest.read(path)
    if not existing:
        return
    env = make_batch(group(request.groups[0]).tasks[0], 1)
    agent = make(env.single_observation_space, env.single_action_space, 0)
    env.close()
    from dataclasses import asdict

    card = asdict(card_of(agent, settings.agent))
    manifest.refuse_mixing(path, existing, manifest.written(card, settings.budget, settings.lanes))
