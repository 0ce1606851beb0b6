"""Train in order, evaluate, record: one unit from an untrained agent to its last stage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from gym_extensions.atomic import write_bytes
from gym_extensions.baselines.agent import Agent, Factory, VectorEnv
from gym_extensions.baselines.agent_checks import card_of
from gym_extensions.baselines.training.evaluation import evaluate
from gym_extensions.baselines.training.jobs import Stage, Unit
from gym_extensions.baselines.training.progress import Finished, Progress
from gym_extensions.baselines.training.recorder import Recorder
from gym_extensions.baselines.training.seeding import training_seed
from gym_extensions.catalog.bodies import segments
from gym_extensions.catalog.budgets import budget
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.catalog.task import Task
from gym_extensions.envs import make_batch
from gym_extensions.rollouts.episodes import CurvePoint, Episode
from gym_extensions.rollouts.layout import PROGRESS, trace_name
from gym_extensions.rollouts.traces import trace_bytes


@dataclass(frozen=True)
class Settings:
    """How units are run: the agent's name, the budget's, and training lanes where not the budget's own."""

    agent: str
    budget: str
    lanes: int | None = None

    def lanes_for(self, tasks: int) -> int:
        """Training lanes: a multiple of the number of tasks, so that each has as many."""
        wanted = self.lanes or budget(self.budget).lanes
        return -(-wanted // tasks) * tasks


@dataclass(frozen=True)
class News:
    """How far a piece of work is: steps trained in a stage, or a finished cell and its mean return."""

    work: str
    stage: int
    steps: int
    evaluated: str = ""
    mean: float = 0.0


Listener = Callable[[News], object]


class Evaluator:
    """The evaluation lanes of every task, made when first asked for, and reused in every stage."""

    def __init__(self, unit: Unit, out: Path) -> None:
        self._unit, self._traces = unit, out / PROGRESS / unit.group / "traces"
        self._lanes: dict[str, VectorEnv] = {}

    def lanes(self, task: Task) -> VectorEnv:
        """As many lanes of the task as a cell has episodes."""
        if task.id not in self._lanes:
            self._lanes[task.id] = make_batch(task, EVALUATION_EPISODES)
        return self._lanes[task.id]

    def cell(self, agent: Agent, stage: int, task: Task) -> list[Episode]:
        """The rows of one cell of the matrix; the trace of every episode is kept."""
        unit = self._unit
        seeds = [evaluation_seed(unit.of.id, task.id, episode) for episode in range(EVALUATION_EPISODES)]
        rows = []
        rollouts = evaluate(agent, self.lanes(task), seeds, segments(task).steps)
        for episode, (seed, found) in enumerate(zip(seeds, rollouts, strict=True)):
            if found.trace is not None:
                name = trace_name(unit.protocol, unit.run, stage, task.name, episode)
                write_bytes(self._traces / name, trace_bytes(found.trace))
            end = (seed, found.length, found.return_, found.terminated, published(task.id))
            rows.append(Episode(unit.run, stage, task.id, episode, *end))
        return rows

    def close(self) -> None:
        """Closes every environment."""
        for env in self._lanes.values():
            env.close()


def run_unit(unit: Unit, make: Factory, settings: Settings, out: Path, listen: Listener) -> list[Finished]:
    """Every stage of the unit, finished; goes on after the last stage that an earlier attempt finished."""
    progress = Progress(out / PROGRESS / unit.group / unit.name)
    progress.begin(asdict(settings) | {"group": unit.of.id})
    plan = unit.stages(budget(settings.budget))
    done = progress.finished()
    if len(done) == len(plan):
        return done
    evaluator = Evaluator(unit, out)
    first = evaluator.lanes(plan[0].evaluated[0])
    spaces = (first.single_observation_space, first.single_action_space)
    agent = make(*spaces, training_seed(unit.run, unit.of.id, "agent"))
    parameters = done[0].parameters[0] if done else card_of(agent, settings.agent).parameters
    if done and not progress.resume(agent, done):
        done = []
    for stage in plan[len(done) :]:
        curves = _train(unit, stage, agent, settings, listen) if stage.steps else []
        rows = []
        for task in stage.evaluated:
            cell = evaluator.cell(agent, stage.number, task)
            listen(
                News(
                    unit.title,
                    stage.number,
                    stage.steps,
                    task.id,
                    sum(row.return_ for row in cell) / len(cell),
                )
            )
            rows += cell
        card = card_of(agent, settings.agent)
        record = Finished(stage.number, rows, curves, asdict(card), (parameters, card.parameters))
        progress.finish(record, agent, last=stage is plan[-1])
        done.append(record)
    evaluator.close()
    return done


def _train(unit: Unit, stage: Stage, agent: Agent, settings: Settings, listen: Listener) -> list[CurvePoint]:
    ids = [task.id for task in stage.trained]
    env = make_batch(stage.trained, settings.lanes_for(len(ids)))
    seed = training_seed(unit.run, unit.of.id, *ids, "training")
    batch = budget(settings.budget).batch_steps
    report = lambda taken: listen(News(unit.title, stage.number, taken))  # noqa: E731
    recorder = Recorder(env, ids, steps=stage.steps, batch_steps=batch, seed=seed, report=report)
    agent.learn(recorder, stage.steps)
    recorder.flush()
    env.close()
    return [
        CurvePoint(unit.protocol, unit.run, point.task, point.step, point.return_)
        for point in recorder.points
    ]
