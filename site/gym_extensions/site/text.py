"""Labels, names and numbers as readers see them."""

import re
import unicodedata
from collections.abc import Iterable
from functools import lru_cache
from itertools import takewhile

from markupsafe import Markup, escape

from gym_extensions.catalog.groups import SUITES
from gym_extensions.catalog.protocol import BUDGETS, STANDARD_BUDGET
from gym_extensions.metrics.formulas import BY_NAME
from gym_extensions.metrics.values import Estimate
from gym_extensions.submissions.review import NEW_SEEDS_ALPHA

MINUS = "\N{MINUS SIGN}"
THIN_SPACE = "\N{NARROW NO-BREAK SPACE}"


def fixed(value: float, digits: int = 2) -> str:
    """The value with ``digits`` digits after the point and a minus sign; −0.00 becomes 0.00."""
    return f"{value:z.{digits}f}".replace("-", MINUS)


def interval(low: float, high: float, digits: int = 2) -> str:
    """Both ends of an interval, for example ``−0.03 to 0.41``."""
    return f"{fixed(low, digits)} to {fixed(high, digits)}"


def digits_for(values: Iterable[float]) -> int:
    """Digits after the point (0, 1 or 2) that show the largest value with about four figures."""
    largest = max((abs(value) for value in values), default=0.0)
    if largest >= 1000:
        return 0
    return 1 if largest >= 10 else 2


def grouped(count: int) -> str:
    """A whole number with spaces between thousands, for example ``10 000``."""
    return f"{count:,}".replace(",", THIN_SPACE).replace("-", MINUS)


def count(number: int, noun: str, plural: str = "") -> str:
    """A number with its noun: ``1 run``, ``2 runs``; ``plural`` where it is not the noun with an s."""
    return f"{grouped(number)} {noun if number == 1 else plural or f'{noun}s'}"


def readable(value: object) -> str:
    """A value of the manifest as text: ``true`` as yes, whole numbers grouped, lists with commas."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return grouped(value)
    if isinstance(value, float):
        return repr(value).replace("-", MINUS)
    if isinstance(value, (list, tuple)):
        return ", ".join(map(readable, value))
    return str(value)


def plus_minus(value: Estimate) -> str:
    """Mean and half of the interval with three digits: ``0.421 ±0.113``; empty without a value."""
    if value.mean is None:
        return ""
    half = f" ±{fixed((value.ends[1] - value.ends[0]) / 2, 3)}" if value.ends else ""
    return fixed(value.mean, 3) + half


JOINERS = "\N{ZERO WIDTH JOINER}\N{VARIATION SELECTOR-16}"


def short(text: str, length: int = 60) -> str:
    """A text of at most ``length`` characters; a longer one ends in an ellipsis, not in half a character."""
    if len(text) <= length:
        return text
    cut = length - 1
    while cut and (unicodedata.combining(text[cut]) or text[cut] in JOINERS or text[cut - 1] in JOINERS):
        cut -= 1
    return text[:cut].rstrip() + "\N{HORIZONTAL ELLIPSIS}"


def split_version(versioned: str) -> tuple[str, str]:
    """A task or group id without its namespace, as (name, version), for example ``("Hopper", "0")``."""
    name = versioned.rsplit("/", maxsplit=1)[-1]
    match = re.fullmatch(r"(.+)-v(\d+)", name)
    return (match[1], match[2]) if match else (name, "")


def _task(name: str, version: str) -> Markup:
    """A name that may break between its words, with its version unless that is 0."""
    words = re.findall(r"[A-Z]?[^A-Z]+|[A-Z]+", name) or [name]
    return Markup("<wbr>").join(escape(word) for word in words) + (
        f"-v{version}" if int(version or 0) else ""
    )


@lru_cache(maxsize=1024)
def task(task_id: str) -> Markup:
    """A task's name without its namespace and version 0, for example ``HopperWall`` or ``HopperWall-v1``."""
    return _task(*split_version(task_id))


@lru_cache(maxsize=1024)
def variation(task_id: str, tasks: tuple[str, ...]) -> Markup:
    """A task's name without what all tasks of its group share.

    This is the base name (``GravityHalf`` in place of ``HopperGravityHalf``; the base task keeps its name)
    or parts between hyphens (``Map0-Goal1`` in place of ``State-Based-Navigation-2d-Map0-Goal1``).
    """
    names = [split_version(other)[0] for other in tasks]
    bases = (name for name in names if all(re.match(f"{re.escape(name)}(?!-)", other) for other in names))
    base = next(bases, "")
    name, version = split_version(task_id)
    if base:
        return _task(name.removeprefix(base) or name, version)
    parts, own = [other.split("-") for other in names], name.split("-")
    first = _shared(parts)
    last = _shared([list(reversed(each[first:])) for each in parts])
    return _task("-".join(own[first : len(own) - last]) or name, version)


def _shared(parts: list[list[str]]) -> int:
    """The number of parts that all begin with."""
    return sum(1 for _ in takewhile(lambda each: len(set(each)) == 1, zip(*parts, strict=False)))


def group(group_id: str) -> Markup:
    """A group's name with its version in a smaller style; a suite with the number of its groups."""
    if group_id in SUITES:
        groups = count(len(SUITES[group_id]), "group")
        return Markup('{} <span class="version">suite, mean of {}</span>').format(group_id, groups)
    name, version = split_version(group_id)
    return Markup('{}<span class="version">-v{}</span>').format(name, version) if version else escape(name)


def group_name(group_id: str) -> str:
    """A group's name in a list of links, without version 0."""
    name, version = split_version(group_id)
    return f"{name}-v{version}" if int(version or 0) else f"{name}{' suite' if group_id in SUITES else ''}"


TAGS = {"`": "<code>{}</code>", "*": "<em>{}</em>"}
"""By the mark around a text."""


def inline(text: str) -> Markup:
    """Markup of a paragraph: ``code`` in backticks, *emphasis*, and of a link the text; no other Markdown."""
    parts = re.split(r"(`[^`]+`|\*\w[^*`]*\w\*)", re.sub(r"\[([^\]]*)\]\([^)\s]*\)", r"\1", text))
    return Markup().join(
        Markup(TAGS[part[0]]).format(part[1:-1]) if index % 2 else escape(part)
        for index, part in enumerate(parts)
    )


PROTOCOLS = {
    "sequential": (
        "Sequential",
        "One policy learns the tasks of the group in order, and is tested on all of them at the end.",
    ),
    "single": ("Single-task", "One policy per task, trained on that task only."),
    "joint": (
        "Joint",
        "One policy is trained on all tasks of the group together, with the budget of the whole group.",
    ),
    "cumulative": (
        "Cumulative",
        "One policy is trained on the last task alone, for the steps of the whole sequence.",
    ),
    "descending": ("Descending", "One policy learns the tasks from the last to the first."),
    "balanced": (
        "Balanced orders",
        "One policy learns the tasks one after another; over the runs, every task is equally often in every "
        "position.",
    ),
}
BUDGET_KINDS = {"1M": "long", "300k": "standard", "100k": "quick", "smoke": "trials"}
"""What a budget is for, where its name does not say it."""
TABLE_COLUMNS = {
    "fully_trained": "after all tasks",
    "after_env_training": "right after training on the task",
    "first_step": "right before training on it",
    "single_env": "trained on it alone",
}
"""The columns of the paper's table, explained below their titles."""


def budget(name: str) -> str:
    """A budget with what it is for, for example ``100k (quick)``."""
    return f"{name} ({BUDGET_KINDS[name]})" if name in BUDGET_KINDS else name


def budget_steps(name: str, group_id: str) -> str:
    """A budget in steps, for example ``100 000 training steps per task``."""
    return f"{grouped(BUDGETS[name].steps_for(split_version(group_id)[0]))} training steps per task"


STANDARD_STEPS = BUDGETS[STANDARD_BUDGET].batches * BUDGETS[STANDARD_BUDGET].batch_steps
"""Training steps per task of the standard boards and of the reference agents."""
COLUMN_NAMES = {
    "final_performance": "Kept",
    "learning_performance": "Learned",
    "forgetting": "Forgotten",
    "zero_shot_transfer": "Transfer",
}
"""What tables call a metric."""


def column(name: str) -> str:
    """The name of a metric's column on all pages: that of the table of methods, or the metric's own title."""
    return COLUMN_NAMES.get(name, BY_NAME[name].title)


def better(name: str) -> str:
    """Which direction of a metric is better."""
    return {"higher": "higher is better", "lower": "lower is better"}.get(BY_NAME[name].better, "not ranked")


def ends(value: Estimate) -> str:
    """The interval, or that there is only one run."""
    return interval(*value.ends) if value.ends else "one run"


def mean(value: Estimate) -> str:
    """The mean, or a dash."""
    return "–" if value.mean is None else fixed(value.mean)


def p_value(value: float) -> str:
    """A p value with three digits, with four about .05; smaller ones as ``< 0.001``."""
    return f"< {fixed(0.001, 3)}" if value < 0.001 else fixed(value, 4 if 0.0495 <= value < 0.0505 else 3)


def p_equals(value: float) -> str:
    """A p value in a sentence, for example ``p = 0.012`` or ``p < 0.001``."""
    said = p_value(value)
    return f"p {said}" if said.startswith("<") else f"p = {said}"


REFUSED_P = p_value(NEW_SEEDS_ALPHA)
"""Logs with this p value on new seeds, or a lower one, are refused."""


def rank(ranks: tuple[int, int] | None) -> str:
    """The possible ranks, for example ``1`` or ``2–4``; empty without a rank."""
    return "–".join(map(str, dict.fromkeys(ranks or ())))
