"""Names of tasks and groups as markup, from their versioned ids."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache
from itertools import takewhile

from markupsafe import Markup, escape

from gym_extensions.catalog.suites import SUITES
from gym_extensions.site.text.numbers import count

JOINERS = "\N{ZERO WIDTH JOINER}\N{VARIATION SELECTOR-16}"
MAX_TITLE = 60
ELLIPSIS = "\N{HORIZONTAL ELLIPSIS}"


def short(text: str, length: int = MAX_TITLE) -> str:
    """A text of at most ``length`` characters; a longer one ends in an ellipsis, not in half a character."""
    if len(text) <= length:
        return text
    cut = length - 1
    while cut and (unicodedata.combining(text[cut]) or text[cut] in JOINERS or text[cut - 1] in JOINERS):
        cut -= 1
    return text[:cut].rstrip() + ELLIPSIS


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
    base = next((name for name in names if all(other.startswith(name) for other in names)), "")
    name, version = split_version(task_id)
    return _task((name.removeprefix(base) if base else _own_parts(name, names)) or name, version)


def _own_parts(name: str, names: list[str]) -> str:
    """The parts of a name between those that all names begin with and those that all end with."""
    parts = [other.split("-") for other in names]
    first = _shared(parts)
    last = _shared([list(reversed(each[first:])) for each in parts])
    own = name.split("-")
    return "-".join(own[first : len(own) - last])


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
