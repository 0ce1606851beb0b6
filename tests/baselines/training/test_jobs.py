"""The arguments of train, and the jobs of a protocol, their stages and their seeds."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines.agent import Card
from gym_extensions.baselines.agent_spec import AgentSpec
from gym_extensions.baselines.algorithms.floors import Zero
from gym_extensions.baselines.cli import parse_runs
from gym_extensions.baselines.generators import training_seed
from gym_extensions.baselines.training.jobs import Settings, jobs_of, parse_request, require_fit
from gym_extensions.baselines.training.runner import PendingJob
from gym_extensions.catalog.groups import GROUPS, TaskGroup, group
from gym_extensions.catalog.protocol import budget
from gym_extensions.catalog.tasks import customize, task
from gym_extensions.catalog.variations import MovingGoal
from gym_extensions.errors import BenchError
from gym_extensions.submissions.manifest import Observes

from ...conftest import refused

GROUP = group("hopper-gravity")
SMOKE = budget("smoke")
SPEC = AgentSpec("zero", Zero, Card("zero"), Observes())


EACH = [0, 1000, 1000, 1000, 1000, 1000]


@pytest.mark.parametrize(
    ("protocol", "run", "trained", "steps"),
    [
        ("sequential", 3, [(), (0,), (1,), (2,), (3,), (4,)], EACH),
        ("descending", 3, [(), (4,), (3,), (2,), (1,), (0,)], EACH),
        ("balanced", 6, [(), (4,), (3,), (0,), (2,), (1,)], EACH),
        ("joint", 0, [(0, 1, 2, 3, 4)], [5000]),
        ("cumulative", 0, [(4,)], [5000]),
    ],
)
def test_a_job_has_the_stages_of_its_protocol_and_evaluates_all_tasks_after_each(
    protocol: str, run: int, trained: list[tuple[int, ...]], steps: list[int]
) -> None:
    (job,) = jobs_of(GROUP, protocol, [run])
    stages = job.stages(SMOKE)
    assert [stage.trained for stage in stages] == [tuple(GROUP.tasks[at] for at in each) for each in trained]
    assert [stage.steps for stage in stages] == steps
    assert {stage.evaluated for stage in stages} == {GROUP.tasks}
    assert (job.name, job.title) == (f"{protocol}-run{run}", f"hopper-gravity {protocol}-run{run}")
    assert PendingJob(job, Settings(SPEC, SMOKE), Path()).steps == 5000


def test_the_single_protocol_has_a_job_per_run_and_task() -> None:
    jobs = jobs_of(GROUP, "single", [0, 2])
    names = [f"single-run{run}-task{task}" for run in (0, 2) for task in range(5)]
    assert [job.name for job in jobs] == names
    (stage,) = jobs[7].stages(SMOKE)
    assert (stage.trained, stage.steps) == ((GROUP.tasks[2],), 1000)


@pytest.mark.parametrize(
    ("num_envs", "num_tasks", "expected"), [(None, 1, 1), (None, 5, 5), (8, 1, 8), (8, 5, 10), (10, 5, 10)]
)
def test_each_task_has_equally_many_environments(num_envs: int | None, num_tasks: int, expected: int) -> None:
    assert Settings(SPEC, SMOKE, num_envs).num_envs_for(num_tasks) == expected


def test_seeds_differ_by_run_and_by_purpose() -> None:
    purposes = [("hopper-v0", "agent"), ("hopper-v0", "training"), ("hopper-v0/agent", "")]
    seeds = {training_seed(run, *purpose) for run in range(5) for purpose in purposes}
    assert len(seeds) == 15
    assert all(0 <= seed < 2**32 for seed in seeds)


def test_the_seed_of_a_run_and_purpose_is_fixed() -> None:
    assert training_seed(1000, "reference", "gym_extensions/HopperGravityHalf-v0", "random") == 3190986840


GOOD: dict[str, Any] = {"groups": "hopper-gravity", "protocols": "single", "budget": "smoke", "runs": 0}
BAD: list[tuple[dict[str, Any], str]] = [
    *(({"runs": value}, "bad-runs") for value in ("0-4", 1.5, [0, "1"], None, [])),
    *(({"runs": value}, "bad-run") for value in (-1, 100)),
    *(({"groups": value}, "bad-groups") for value in (None, [], [3])),
    ({"protocols": [1]}, "bad-protocols"),
    ({"budget": 1000}, "unknown-budget"),
]


@pytest.mark.parametrize(("changed", "code"), BAD)
def test_an_argument_of_another_type_is_rejected(changed: dict[str, Any], code: str) -> None:
    with refused(code):
        parse_request(**(GOOD | changed))


@pytest.mark.parametrize("runs", [[2, 0, 1, 0], range(3), np.arange(3), (run for run in range(3))])
def test_runs_are_integers_of_any_type_sorted_and_without_duplicates(runs: Any) -> None:
    assert parse_request(**(GOOD | {"runs": runs})).runs == (0, 1, 2)


def test_a_group_with_and_without_its_version_is_the_same_group() -> None:
    request = parse_request(**(GOOD | {"groups": ["hopper-gravity", "hopper-gravity-v0"]}))
    assert [(group.name, protocol) for group, protocol in request.logs()] == [("hopper-gravity", "single")]


def test_the_tasks_of_a_group_can_be_made_and_have_equal_spaces() -> None:
    require_fit(each for name, each in GROUPS.items() if not name.startswith("nav-"))
    moving = customize("Hopper", [MovingGoal()])
    for second, code, fact, where in (
        (task("HopperWall"), "different-spaces", "HopperWall-v0 has Box", "mixed"),
        (moving, "misplaced-variation", "It fits Pusher.", f"mixed, {moving.id}"),
    ):
        with refused(code, fact, where=where):
            require_fit([TaskGroup("mixed", (task("Hopper"), second))])


def test_runs_on_the_command_line_are_numbers_and_ranges() -> None:
    assert [parse_runs(text) for text in ("0", "0-4", "7, 2-3")] == [[0], [0, 1, 2, 3, 4], [7, 2, 3]]
    for text in ("", "-1", "1-", "0;1", "1.5"):
        with pytest.raises(BenchError, match="is not a list of runs"):
            parse_runs(text)
