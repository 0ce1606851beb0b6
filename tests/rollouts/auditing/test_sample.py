"""The audit sample: an episode of every cell, mostly the largest return, and draws that a salt changes."""

from __future__ import annotations

import hashlib
from collections import Counter
from itertools import product

import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.task import Task
from gym_extensions.rollouts.auditing.sample import Audited, audit_sample, performance_cells

TASKS = group("hopper-gravity").tasks
SALT = "5a" * 32


def log(protocol: str, runs: tuple[int, ...], shift: int = 0, tasks: tuple[Task, ...] = TASKS) -> bytes:
    """A log whose largest return is that of episode (run + stage + position) modulo 20."""
    stages = range(len(tasks) + 1) if protocol == "sequential" else [1]
    rows = [
        f"{run},{stage},{task.id},{episode},{float(-((episode - run - stage - position - shift) % 20))}\n"
        for run, stage, (position, task), episode in product(runs, stages, enumerate(tasks), range(20))
    ]
    return "".join(["run,stage,task,episode,return\n", *rows]).encode()


def test_the_cells_of_final_performance_and_forgetting() -> None:
    # T = 5: five of R[5][j] and four of R[j][j] that are not R[5][5].
    cells = performance_cells("sequential", TASKS)
    assert len(cells) == len(set(cells)) == 9
    assert {stage for stage, _ in cells} == {1, 2, 3, 4, 5}
    for protocol in ("single", "joint"):
        assert performance_cells(protocol, TASKS) == [(1, task.id) for task in TASKS]


def largest(run: int, tasks: tuple[Task, ...] = TASKS) -> set[Audited]:
    """The episodes with the largest return of the cells of sequential.csv."""
    return {
        Audited(run, stage, task.id, (run + stage + position) % 20)
        for stage, (position, task) in product(range(len(tasks) + 1), enumerate(tasks))
    }


def test_the_sample_of_the_first_two_runs_has_the_largest_return_of_every_cell() -> None:
    sample = audit_sample("sequential", log("sequential", (0, 1)), [0, 1], TASKS)
    assert len(sample) == len(set(sample)) == 2 * (30 + 9 + 5)
    assert set(sample) >= largest(0) | largest(1)


def test_the_sample_of_a_later_run_has_one_episode_per_cell() -> None:
    sample = audit_sample("sequential", log("sequential", (3,)), [3], TASKS)
    assert len(sample) == len({(each.stage, each.task) for each in sample}) == 30
    # Of one cell per stage it is not the one with the largest return.
    assert Counter(each.stage for each in set(sample) - largest(3)) == dict.fromkeys(range(6), 1)


def test_five_runs_of_five_tasks_have_213_traces() -> None:
    runs = (0, 1, 2, 3, 4)
    samples = [audit_sample(name, log(name, runs), runs, TASKS) for name in ("sequential", "single")]
    assert sum(map(len, samples)) == 2 * (44 + 10) + 3 * (30 + 5) == 213


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_every_stage_but_the_last_has_one_more_drawn_episode(count: int) -> None:
    tasks = TASKS[:count]
    data = log("sequential", (0,), tasks=tasks)
    drawn = set(performance_cells("sequential", tasks))
    sample = audit_sample("sequential", data, [0], tasks)
    others = [row for row in sample if (row.stage, row.task) not in drawn]
    # The largest return of each such cell, all of stage 0 and all but R[s][s] later, and one episode more.
    assert Counter(row.stage for row in others) == {
        stage: count + 1 if stage == 0 else count for stage in range(count)
    }
    assert len(sample) == (count + 1) * count + (2 * count - 1) + count


def test_the_first_of_equal_returns_is_the_largest() -> None:
    text = log("single", (0,)).decode()
    head, *rows = text.splitlines()
    equal = "\n".join([head, *(row.rpartition(",")[0] + ",1.0" for row in rows), ""]).encode()
    assert {row.episode for row in audit_sample("single", equal, [0], TASKS)} >= {0}


def test_a_salt_changes_drawn_episodes_and_no_largest() -> None:
    data = log("single", (0,))
    samples = [set(audit_sample("single", data, [0], TASKS, salt)) for salt in ("", SALT, "5b" * 32)]
    best = {Audited(0, 1, task.id, (1 + position) % 20) for position, task in enumerate(TASKS)}
    assert set.intersection(*samples) >= best
    assert len({frozenset(sample) for sample in samples}) == 3


def test_a_drawn_episode_by_hand() -> None:
    data = log("single", (0,))
    digest = hashlib.sha256(data.partition(b"\n")[2]).hexdigest()
    others = [episode for episode in range(20) if episode != 1]
    for salt, seed in (("", f"{digest}/0"), (SALT, f"{digest}/{SALT}/0")):
        drawn = min(others, key=lambda episode, seed=seed: rank(seed, episode))  # type: ignore[misc]
        assert Audited(0, 1, TASKS[0].id, drawn) in audit_sample("single", data, [0], TASKS, salt)


def rank(seed: str, episode: int, stage: int = 1, task: str = TASKS[0].id) -> str:
    return hashlib.sha256(f"{seed}/{stage}/{task}/{episode}".encode()).hexdigest()


@pytest.mark.parametrize("salt", ["", SALT])
def test_the_drawn_episode_of_a_stage_by_hand(salt: str) -> None:
    first, second = (task.id for task in TASKS[:2])
    data = log("sequential", (0,), tasks=TASKS[:2])
    digest = hashlib.sha256(data.partition(b"\n")[2]).hexdigest()
    seed = f"{digest}/{salt}/0" if salt else f"{digest}/0"
    # T = 2. The largest return of a cell is that of episode stage + position. Stage 0 draws from the other 19
    # episodes of R[0][1] and R[0][2] together, stage 1 from those of R[1][2]: the table has the other cells.
    pools = {
        0: [(first, each) for each in range(20) if each != 0]
        + [(second, each) for each in range(20) if each != 1],
        1: [(second, each) for each in range(20) if each != 2],
    }
    sample = set(audit_sample("sequential", data, [0], TASKS[:2], salt))
    for stage, pool in pools.items():
        task, episode = min(pool, key=lambda each: rank(seed, each[1], stage, each[0]))
        members = {Audited(0, stage, *each) for each in pool}
        assert sample & members == {Audited(0, stage, task, episode)}


@pytest.mark.parametrize("salt", ["", SALT])
def test_the_drawn_episodes_of_a_later_run_by_hand(salt: str) -> None:
    data = log("sequential", (2,), tasks=TASKS[:2])
    digest = hashlib.sha256(data.partition(b"\n")[2]).hexdigest()
    seed = f"{digest}/{salt}/2" if salt else f"{digest}/2"
    sample = set(audit_sample("sequential", data, [2], TASKS[:2], salt))
    drawn = set()
    for stage in range(3):
        pool = [
            (task.id, each)
            for (position, task), each in product(enumerate(TASKS[:2]), range(20))
            if each != 2 + stage + position
        ]
        task_id, episode = min(pool, key=lambda each: rank(seed, each[1], stage, each[0]))
        drawn.add(Audited(2, stage, task_id, episode))
    cells = {(each.stage, each.task) for each in drawn}
    best = {each for each in largest(2, TASKS[:2]) if (each.stage, each.task) not in cells}
    assert sample == drawn | best


def test_the_rows_of_a_run_select_its_sample_and_no_other() -> None:
    def of_run_three(data: bytes) -> list[Audited]:
        runs = sorted({int(line.split(b",")[0]) for line in data.splitlines()[1:]})
        return [row for row in audit_sample("single", data, runs, TASKS) if row.run == 3]

    alone = of_run_three(log("single", (3,)))
    assert of_run_three(log("single", (0, 3))) == alone
    assert of_run_three(log("single", (0, 3), shift=1)) != alone
