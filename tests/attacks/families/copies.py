"""Attacks that present another entry's work as the author's own."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

from ..attack import REEVALUATED, REPRODUCED, Attack
from ..evaluate import evaluations, generator, replace_cells, rollouts, seeds_of, with_policy
from ..forger import Forger, cells
from ..forgeries.invented import scale
from ..forgeries.runs import as_runs
from ..judge import submission
from ..workshop import Workshop

COPY = "board: Has most episodes of random."


def make(
    edit: Callable[[Forger], object], name: str = "attack", base: str = "random"
) -> Callable[[Workshop], Path]:
    """Copies an honest submission under another name and changes it."""

    def copy(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy(base, name))
        edit(forger)
        return forger.commit()

    return copy


def renamed(forger: Forger) -> None:
    forger.declare("title", '"My own work"')
    forger.declare("authors", '["Somebody Else"]')


def noise(amount: float) -> Callable[[Forger], None]:
    def edit(forger: Forger) -> None:
        rows = forger.rows()
        for row in rows:
            scale(forger, row, 1 + amount)
        forger.write(rows)

    return edit


def without_policies(forger: Forger) -> None:
    shutil.rmtree(forger.folder / forger.group.name / "policies")


def new_episodes(runs: range, share: int = 20) -> Callable[[Forger], None]:
    """Evaluates the agent anew in the first episodes of every cell of some runs."""

    def edit(forger: Forger) -> None:
        rows = forger.rows()
        for cell in cells(rows):
            if int(cell[0]["run"]) in runs:
                for row, rollout in zip(cell[:share], next(evaluations(cell, 1))[:share], strict=True):
                    forger.put_rollout(row, rollout)
        forger.write(rows)

    return edit


def evaluated_again(forger: Forger) -> None:
    from gym_extensions.rollouts.policies import Policy

    folder = forger.folder / forger.group.name / "policies"
    names = {task.id: task.name for task in forger.group.tasks}

    def episodes(cell):  # type: ignore[no-untyped-def]
        path = folder / f"single-run{cell[0]['run']}-stage1-{names[cell[0]['task']]}.npz"
        policy = Policy.from_bytes(path.read_bytes())
        return rollouts(cell[0]["task"], with_policy(policy, generator(cell)), seeds_of(cell))

    replace_cells(forger, episodes)


ATTACKS = (
    Attack(
        "A copy whose name comes before that of the original.",
        submission(make(lambda _: None), beside="random"),
        COPY,
    ),
    Attack("A copy with another title and author.", submission(make(renamed), beside="random"), COPY),
    Attack("A copy with noise of 3e-13.", submission(make(noise(3e-13)), beside="random"), COPY),
    Attack("A copy with noise of 1e-7.", submission(make(noise(1e-7)), beside="random"), COPY),
    Attack("A copy without policies.", submission(make(without_policies), beside="random"), COPY),
    Attack(
        "A copy with its runs in another order.", submission(as_runs((4, 2, 0, 1, 3)), beside="random"), COPY
    ),
    Attack(
        "A copy of three runs, with two others.",
        submission(make(new_episodes(range(3, 5))), beside="random"),
        COPY,
    ),
    Attack(
        "A copy with a quarter of the episodes replaced.",
        submission(make(new_episodes(range(5), 5)), beside="random"),
        COPY,
    ),
    Attack(
        "A copy of two runs, with three others.",
        submission(make(new_episodes(range(2, 5))), beside="random"),
        "not detected",
        REPRODUCED,
        REPRODUCED,
        "A lower share of common runs would mark it, and entries that share seeds of one method by right.",
    ),
    Attack(
        "The policies of another entry are evaluated anew.",
        submission(make(evaluated_again, base="gaussian"), beside="gaussian"),
        "retraining: not-reproducible",
        REEVALUATED,
        REEVALUATED,
        "A comparison of policy files; small changes of the weights would hide the copy from it.",
    ),
)
