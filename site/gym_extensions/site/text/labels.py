"""Labels of protocols, budgets, levels of trust, metric values and facts of the manifest."""

from __future__ import annotations

import re
from collections.abc import Iterable

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.scoring.metrics.definitions import BY_NAME
from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.scoring.scorecard.model import REPORTED, VALIDATED, Scorecard
from gym_extensions.site.text.names import split_version
from gym_extensions.site.text.numbers import fixed, grouped, interval

PROTOCOLS = {
    "sequential": (
        "One task after another",
        "One policy learns the tasks of the group in order, and is tested on all of them at the end.",
    ),
    "single": ("Each task alone", "One policy per task, trained on that task only."),
    "joint": (
        "All tasks at once",
        "One policy is trained on all tasks of the group together, with the budget of the whole group.",
    ),
}
BUDGET_KINDS = {"1M": "long", "300k": "standard", "100k": "quick", "smoke": "tests"}
"""What a budget is for, where its name does not say it."""
TRUST = {
    REPORTED: "Published elsewhere without logs, so nothing can be checked.",
    VALIDATED: "The logs are complete and satisfy every rule. They were not replayed for these pages.",
    "replayed": (
        "A sample of the episodes was run again from the recorded actions and gave the claimed returns. "
        "Where the label says “all”, all of them were, or the submitted policies repeated every episode. "
        "The log fixes all recorded episodes in advance. The sample "
        "has one episode of every cell, most often the one with the largest return, and further ones of the "
        "first two runs. A salt that was fixed after the log draws a part of them. Without a salt, a "
        "determined cheat could edit the log until the drawn part misses the edit. Replay does not show how "
        "often a policy was trained."
    ),
    "re-evaluated": (
        "Replayed, and the submitted policies were evaluated on new seeds that follow from a salt, which was "
        "fixed after the submission. The logged returns are not significantly higher than the new ones."
    ),
    "reproduced": (
        "A maintainer trained a run of the entry again from its code and compared it with the log. It shows "
        "that code and log belong together; it is the only level that bears on how often was trained."
    ),
    "refused": "Breaks a rule, and is not on a board.",
}
TRUST_LABELS = {VALIDATED: "checked, not replayed"}
"""Labels of the levels of trust that are not shown by their name."""
VERIFIED = ("replayed", "re-evaluated", "reproduced")
"""Levels of entries of which at least a sample of the episodes was replayed."""
TABLE_COLUMNS = {
    "fully_trained": "after all tasks",
    "after_env_training": "right after training on the task",
    "first_step": "right before training on it",
    "single_env": "trained on it alone",
}
"""The columns of the paper's table, explained below their titles."""
OBSERVED = {
    "task_in_training": "task label in training",
    "task_in_evaluation": "task label in evaluation",
    "boundaries": "task boundaries",
}
STEPS = {"recorded": "recorded by the training loop", "claimed": "claimed by the authors"}
NOT_STATED = "not stated"


def budget(name: str) -> str:
    """A budget with what it is for, for example ``100k (quick)``."""
    return f"{name} ({BUDGET_KINDS[name]})" if name in BUDGET_KINDS else name


def budget_steps(name: str, group_id: str) -> str:
    """A budget in steps, for example ``100 000 training steps per task``."""
    return f"{grouped(BUDGETS[name].steps_for(split_version(group_id)[0]))} training steps per task"


def evaluated(card: Scorecard) -> str:
    """How actions are selected in evaluation, for example ``sampled actions``."""
    return NOT_STATED if card.manifest is None else f"{card.manifest.protocol.evaluation} actions"


def observed(card: Scorecard) -> str:
    """The task information that the agent receives besides the environment's observations."""
    if card.manifest is None:
        return NOT_STATED
    observes = card.manifest.observes
    return ", ".join(label for key, label in OBSERVED.items() if getattr(observes, key)) or "none"


def task_label(card: Scorecard) -> str:
    """When the agent receives the task label: ``none``, ``training``, ``evaluation`` or both."""
    if card.manifest is None:
        return NOT_STATED
    observes = card.manifest.observes
    times = {"training": observes.task_in_training, "evaluation": observes.task_in_evaluation}
    return " and ".join(name for name, received in times.items() if received) or "none"


def parameters(card: Scorecard) -> str:
    """The number of parameters at the start, and at the end if it differs: the largest of all groups."""
    memory = card.manifest.memory if card.manifest else None
    if memory is None:
        return NOT_STATED
    first, last = memory.parameters_first, memory.parameters_last
    return grouped(first) if first == last else f"{grouped(first)} → {grouped(last)}"


def stored(card: Scorecard) -> str:
    """The maximum number of transitions that the agent stores."""
    memory = card.manifest.memory if card.manifest else None
    return NOT_STATED if memory is None else grouped(memory.stored_steps)


def tuning(card: Scorecard) -> str:
    """The training steps that were spent on choosing the settings."""
    spent = card.manifest.tuning if card.manifest else None
    if spent is None:
        return NOT_STATED
    if not spent.steps:
        return "none declared"
    return f"{grouped(spent.steps)} steps" + (f" on {', '.join(spent.tasks)}" if spent.tasks else "")


def better(name: str) -> str:
    """Which direction of a metric is better."""
    return {"higher": "higher is better", "lower": "lower is better"}.get(BY_NAME[name].better, "not ranked")


def ends(value: MetricValue) -> str:
    """The interval, or that there is only one run."""
    return interval(*value.ends) if value.ends else "one run"


def mean(value: MetricValue) -> str:
    """The mean, or a dash."""
    return "–" if value.mean is None else fixed(value.mean)


def missing(items: Iterable[str]) -> str:
    """What a full entry lacks; a missing file of a protocol is named after it."""
    files = {
        f"{name}.csv": f"the protocol “{label.lower()}” ({name}.csv)"
        for name, (label, _) in PROTOCOLS.items()
    }
    return ", ".join(files.get(item, item) for item in items)


def web_address(url: object) -> str:
    """The URL if a browser may follow it (http or https), else nothing."""
    text = str(url or "")
    return text if re.match(r"https?://[^\s/]", text, re.IGNORECASE) else ""


def level(card: Scorecard) -> str:
    """The level of trust without the sample, as ``replayed``; ``refused`` with problems."""
    first = (card.trust or "refused").split(" ", maxsplit=1)[0]
    return first if first in TRUST else "other"


def is_pending(card: Scorecard) -> bool:
    """Whether the ledger does not have the files of the entry, so that it is not accepted yet."""
    return card.ledger is not None and card.ledger.is_pending


def short_trust(card: Scorecard) -> str:
    """The level of trust in one or two words."""
    return {VALIDATED: "checked", "other": card.trust or ""}.get(level(card), level(card))


def trust(card: Scorecard) -> str:
    """The level of trust as it is shown; ``refused`` with problems."""
    return TRUST_LABELS.get(card.trust or "", card.trust or "refused")


def trust_sample(card: Scorecard) -> tuple[str, str]:
    """The level of trust as it is shown, and the number of replayed episodes or nothing."""
    name, _, sample = trust(card).partition(" (")
    episodes = sample.removesuffix(")").rpartition(": ")[2]
    return name, "all episodes" if episodes == "all" else episodes


def facts(card: Scorecard) -> list[tuple[str, str]]:
    """What the manifest states on training and evaluation, as (label, value)."""
    if card.manifest is None:
        return []
    rows = [
        ("Algorithm", card.manifest.protocol.algorithm),
        ("Actions in evaluation", card.manifest.protocol.evaluation),
        ("Training steps", STEPS[card.manifest.protocol.steps]),
        ("Task label, task boundaries", observed(card)),
        ("Replay memory", f"{stored(card)} transitions"),
        ("Parameters", parameters(card)),
        ("Tuning", tuning(card)),
    ]
    return [(label, value) for label, value in rows if value]


def rank(interval: tuple[int, int] | None) -> str:
    """A rank interval: ``rank 1``, ``rank 1–3``, or nothing."""
    if interval is None:
        return ""
    best, worst = interval
    return f"rank {best}" if best == worst else f"rank {best}–{worst}"
