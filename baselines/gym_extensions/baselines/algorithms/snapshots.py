"""Fine-tuning with a copy of the policy per task: the least that an agent can do that observes the task."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from gym_extensions.baselines.agent import Card
from gym_extensions.baselines.algorithms.multi_head import MultiHead


class Snapshots(MultiHead):
    """The agent ``snapshots``. It learns bit for bit as ``trpo`` does, and copies its policy after each task.

    It is ``multi-head`` with the whole network as the head of a task, which starts with the parameters of the
    task before. A task that was not learned yet is evaluated with the present policy. So its score at the end
    is what ``trpo`` scores right after training, by definition, and it forgets nothing.
    """

    name, title = "snapshots", "TRPO + snapshots"
    description = "The reference agent with a copy of its policy per learned task; it observes the task."
    shares_hidden_layers = False

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, copy_head=True, **settings)

    def card(self) -> Card:
        """The card of ``trpo`` with the parameters of all copies."""
        card = super().card()
        settings = {key: value for key, value in card.hyperparameters.items() if key != "copy_head"}
        return replace(card, hyperparameters=settings)


make = Snapshots
