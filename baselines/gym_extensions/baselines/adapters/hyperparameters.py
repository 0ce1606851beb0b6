"""Settings of any kind as the manifest takes them: others than plain ones become texts that tell them apart.

A text is the same in every process: it holds no address in memory, and no module's name, which is another
where a program is run as a script.
"""

from __future__ import annotations

import functools
import hashlib
import re
from collections.abc import Mapping, Sequence, Set
from types import CellType, CodeType, FunctionType, MethodType
from typing import Any

import numpy as np

from gym_extensions.baselines.agent import Setting
from gym_extensions.rollouts.manifest_values import LONG, hyperparameter_error

DEEPEST = 5
"""Values in one another; what lies deeper is left out."""
ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")
DIGEST = 16
"""Hexadecimal digits of a sha256 that stand for what a text leaves out."""
EMPTY = CellType()


def as_setting(value: Any) -> Setting:
    """The value itself where the manifest takes it (a tuple as a list), else a text that describes it."""
    if not hyperparameter_error(value):
        plain: Setting = list(value) if isinstance(value, tuple) else value
        return plain
    text = _described(value, DEEPEST)
    if len(text) <= LONG:
        return text
    mark = f"… {_digest(text)}"
    return text[: LONG - len(mark)] + mark


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:DIGEST]


def _described(value: Any, deep: int) -> str:
    return _text(value, deep - 1) if deep else "…"


@functools.singledispatch
def _text(value: Any, below: int) -> str:
    kind: Any = type(value)
    if kind.__repr__ is object.__repr__:
        return f"{kind.__qualname__} {_described(getattr(value, '__dict__', {}), below)}"
    return ADDRESS.sub("", repr(value))


@_text.register(np.ndarray | np.generic)
def _(value: Any, below: int) -> str:
    return _text(value.tolist(), below)


@_text.register(Mapping)
def _(value: Mapping[Any, Any], below: int) -> str:
    pairs = (f"{_described(key, below)}: {_described(one, below)}" for key, one in value.items())
    return "{" + ", ".join(pairs) + "}"


@_text.register(list | tuple)
def _(value: Sequence[Any], below: int) -> str:
    return "[" + ", ".join(_described(one, below) for one in value) + "]"


@_text.register(set | frozenset)
def _(value: Set[Any], below: int) -> str:
    return "{" + ", ".join(sorted(_described(one, below) for one in value)) + "}"


@_text.register(type)
def _(value: type, below: int) -> str:
    return value.__qualname__


@_text.register(FunctionType)
def _(value: FunctionType, below: int) -> str:
    return f"{value.__qualname__} {_digest(_of_function(value, below))}"


@_text.register(MethodType)
def _(value: MethodType, below: int) -> str:
    return f"{value.__func__.__qualname__} of {_described(value.__self__, below)}"


@_text.register(functools.partial)
def _(value: functools.partial[Any], below: int) -> str:
    return f"partial {_described([value.func, value.args, value.keywords], below)}"


def _of_function(function: FunctionType, deep: int) -> str:
    """What makes two functions of one name differ: their code, their defaults, what they close over."""
    held = [cell.cell_contents for cell in function.__closure__ or () if cell != EMPTY]
    parts = (function.__defaults__, function.__kwdefaults__, held)
    return _of_code(function.__code__, deep) + _described(parts, deep)


def _of_code(code: CodeType, deep: int) -> str:
    inner = [
        _of_code(each, deep - 1) if isinstance(each, CodeType) and deep else _described(each, deep)
        for each in code.co_consts
    ]
    return f"{code.co_code.hex()} {code.co_names} {inner}"
