"""The site's words: what protocols, budgets and levels of trust are called, and how names are set."""

from __future__ import annotations

import re

from markupsafe import Markup, escape

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.catalog.suites import SUITES
from gym_extensions.scoring.metrics.definitions import BY_NAME
from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.scoring.scorecard.model import REPORTED, VALIDATED, Scorecard
from gym_extensions.site.text.numbers import fixed, grouped, interval

PROTOCOLS = {
    "sequential": (
        "One task after another",
        "One policy learns the group's tasks in order. What is left at the end?",
    ),
    "single": ("Each task alone", "One policy for each task, trained on it alone."),
    "joint": (
        "All tasks at once",
        "One policy trained on all tasks of the group together, with the group's whole budget.",
    ),
}
TRUST = {
    REPORTED: "Printed elsewhere; there are no logs, so nothing could be checked.",
    VALIDATED: "The logs are complete and keep every rule; they were not replayed for these pages.",
    "replayed": (
        "A sample of the episodes (or all, where it says so), run again from their recorded actions, gives "
        "the claimed returns. The finished log draws the sample, so its author could draw again by changing "
        "the log; and it holds episodes right after each task’s own training and at the end alone, none of "
        "the other cells, on which zero-shot transfer and generalization rest."
    ),
    "refused": "Breaks a rule, and is on no board.",
}
TABLE_COLUMNS = {
    "fully_trained": "after all tasks",
    "after_env_training": "right after training on the task",
    "first_step": "right before training on it",
    "single_env": "trained on it alone",
}
"""What the columns of the paper's table are, below their titles."""
OBSERVED = {
    "task_in_training": "the task, while training",
    "task_in_evaluation": "the task, in evaluation",
    "boundaries": "when the task changes",
}


def task(task_id: str) -> Markup:
    """A task's name without its namespace, with places where a narrow column may break it."""
    name = task_id.rsplit("/", maxsplit=1)[-1].removesuffix("-v0")
    pieces = re.findall(r"[A-Z]?[^A-Z]+|[A-Z]+", name) or [name]
    return Markup("<wbr>").join(escape(piece) for piece in pieces)


def variation(task_id: str, tasks: tuple[str, ...]) -> Markup:
    """A task's name without what all names of its group begin with; the base itself keeps its own."""
    names = [found.rsplit("/", maxsplit=1)[-1].rsplit("-v", maxsplit=1)[0] for found in tasks]
    shared = next((name for name in names if all(other.startswith(name) for other in names)), "")
    own = task_id.rsplit("/", maxsplit=1)[-1].removesuffix("-v0")
    return task(own.removeprefix(shared) or own)


def group(group_id: str) -> Markup:
    """A group's name with its version set back; a suite says what it is."""
    if group_id in SUITES:
        groups = count(len(SUITES[group_id]), "group")
        return Markup('{} <span class="version">suite, mean of {}</span>').format(group_id, groups)
    name, _, version = group_id.rpartition("-v")
    return Markup('{}<span class="version">-v{}</span>').format(name, version) if name else escape(group_id)


def budget(name: str, group_id: str) -> str:
    """A budget in steps a task, for example ``100k: 100 000 training steps a task``."""
    steps = BUDGETS[name].steps_for(group_id.rsplit("-v", maxsplit=1)[0])
    return f"{grouped(steps)} training steps a task"


def observed(card: Scorecard) -> str:
    """What the agent observes besides the environment's observations, in a few words."""
    if card.manifest is None:
        return "not said"
    observes = card.manifest.observes
    return ", ".join(words for key, words in OBSERVED.items() if getattr(observes, key)) or "nothing"


def parameters(card: Scorecard) -> str:
    """How many parameters the agent has at the start, and at the end if that differs."""
    memory = card.manifest.memory if card.manifest else None
    if memory is None:
        return "not said"
    first, last = memory.parameters_first, memory.parameters_last
    return grouped(first) if first == last else f"{grouped(first)} → {grouped(last)}"


def stored(card: Scorecard) -> str:
    """How many transitions the agent holds at most."""
    memory = card.manifest.memory if card.manifest else None
    return "not said" if memory is None else grouped(memory.stored_steps)


def better(name: str) -> str:
    """Which direction of a metric is better, in words."""
    return {"higher": "higher is better", "lower": "lower is better"}.get(BY_NAME[name].better, "not ranked")


def ends(estimate: MetricValue) -> str:
    """The interval in words, or that there is none."""
    return interval(*estimate.ends) if estimate.ends else "one run"


def value(estimate: MetricValue) -> str:
    """The mean, or a dash."""
    return "–" if estimate.mean is None else fixed(estimate.mean)


def count(number: int, what: str) -> str:
    """``1 run``, ``2 runs``."""
    return f"{grouped(number)} {what}{'' if number == 1 else 's'}"


def web_address(url: object) -> str:
    """The URL if a browser may follow it (http or https), else nothing."""
    text = str(url or "")
    return text if re.match(r"https?://[^\s/]", text, re.IGNORECASE) else ""


def level(trust: str) -> str:
    """The level of trust without what follows it: ``replayed (all)`` is ``replayed``."""
    first = trust.split(" ", maxsplit=1)[0]
    return first if first in TRUST else "other"


def trust(card: Scorecard) -> str:
    """The level of trust; ``refused`` with problems."""
    return card.trust or "refused"


def facts(card: Scorecard) -> list[tuple[str, str]]:
    """What the manifest says on training and evaluation, as (name, words)."""
    if card.manifest is None:
        return []
    rows = [
        ("Algorithm", card.manifest.protocol.algorithm),
        ("Actions in evaluation", card.manifest.protocol.evaluation),
        ("Observes", observed(card)),
        ("Transitions stored", stored(card)),
        ("Parameters", parameters(card)),
    ]
    return [(name, words) for name, words in rows if words]


def rank(span: tuple[int, int] | None) -> str:
    """A rank interval: ``rank 1``, ``rank 1–3``, or nothing."""
    if span is None:
        return ""
    return f"rank {span[0]}" if span[0] == span[1] else f"rank {span[0]}–{span[1]}"
