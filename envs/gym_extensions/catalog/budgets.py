"""Training budgets, which set the number of steps per task."""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.errors import BenchError, did_you_mean


@dataclass(frozen=True)
class Budget:
    """Number of training steps per task, ``batches × batch_steps``.

    Args:
        name: the name, for example ``1M``.
        batches: batches per task.
        batch_steps: environment steps per batch, summed over the environments.
        num_envs: environments that are stepped in parallel.
        body_batches: batches per task of a body group, if different.
        on_boards: whether submissions with this budget appear on the boards.
    """

    name: str
    batches: int
    batch_steps: int
    num_envs: int
    body_batches: int | None = None
    on_boards: bool = True

    def batches_for(self, group_name: str) -> int:
        """Batches per task of the named group. The paper trained its body groups half as long."""
        if self.body_batches is not None and group_name.endswith("-body"):
            return self.body_batches
        return self.batches

    def steps_for(self, group_name: str) -> int:
        """Training steps per task of the named group."""
        return self.batches_for(group_name) * self.batch_steps


BUDGETS = {
    budget.name: budget
    for budget in (
        Budget("paper", batches=1000, batch_steps=50_000, num_envs=50, body_batches=500),
        Budget("1M", batches=200, batch_steps=5_000, num_envs=20),
        Budget("300k", batches=150, batch_steps=2_000, num_envs=25),
        Budget("100k", batches=50, batch_steps=2_000, num_envs=8),
        Budget("smoke", batches=4, batch_steps=250, num_envs=1, on_boards=False),
    )
}
STANDARD_BUDGET = "300k"
"""The budget of the standard boards and of the reference agents."""


def budget(name: str) -> Budget:
    """Returns the budget of that name. Raises ``BenchError`` if it does not exist."""
    if name not in BUDGETS:
        hint = did_you_mean(name, BUDGETS)
        raise BenchError("unknown-budget", f"There is no budget {name!r}.", hint=hint)
    return BUDGETS[name]
