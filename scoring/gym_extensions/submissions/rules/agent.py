"""Rules about the code of an agent. Its text is judged, by ``ast``; nothing of it runs.

They bound its size, numbers and strings, so that an agent is a short text that a reader can judge. They do
not keep all weights out: a linear policy fits, and packed numbers, comments and docstrings can hold a network
(docs/security.md).
"""

import ast
import contextlib
import io
import symtable
import sys
import tokenize
from collections.abc import Iterator, Mapping
from pathlib import PurePosixPath
from typing import Any

from gym_extensions.errors import did_you_mean
from gym_extensions.submissions.characters import first_invisible
from gym_extensions.submissions.layout import AGENT, MANIFEST
from gym_extensions.submissions.manifest import BOX_PACKAGES
from gym_extensions.submissions.problem import Finding, quote, rule

Sources = Mapping[str, bytes]
"""The files of agent/ by path."""
Section = Mapping[str, Any] | None
"""The section [agent] of submission.toml, which may be wrong elsewhere; None without it."""
MAX_BYTES, MAX_LINE = 100_000, 150
MAX_NUMBERS, MAX_DIGITS = 300, 30
MAX_STRING, MAX_STRINGS = 200, 10_000
"""Largest text; numbers and characters of one; characters of a string, and of all strings together."""
BY_TEXT = frozenset(
    [
        *("__import__", "import_module", "exec_module", "load_module", "run_module", "run_path"),
        *("exec", "eval", "builtins", "__builtins__"),
    ]
)
"""What imports, or runs, what a text says."""
REFUSED = (SyntaxError, ValueError, RecursionError, MemoryError)
"""What Python raises for a text that it does not parse."""


def decoded(data: bytes) -> str:
    """The text of a file that Python parses as UTF-8. Raises one of ``REFUSED`` for any other file.

    Python obeys a first line such as ``# coding: utf-7``. The text that it runs would not be the one that
    the rules judge and a person reads. It is not compiled: a short text can give gigabytes of code.
    """
    encoding, _ = tokenize.detect_encoding(io.BytesIO(data).readline)
    if encoding != "utf-8":
        raise SyntaxError(f"It declares the encoding {encoding}, and must be UTF-8")
    text = data.decode("utf-8")
    ast.parse(text)
    return text


def parsed(sources: Sources) -> dict[str, ast.Module]:
    """The files that are Python; ``not_python`` reports the others."""
    trees = {}
    for path, data in sources.items():
        with contextlib.suppress(*REFUSED):
            trees[path] = ast.parse(decoded(data))
    return trees


@rule("agent")
def code_without_entry(sources: Sources, section: Section) -> Iterator[Finding]:
    """agent/ and the section [agent] of submission.toml come together. Its ``entry`` is a file of agent/ and
    a name that this file defines or imports. A file that is not ``__init__.py`` is loaded alone."""
    if not sources or section is None:
        where, lacks = (AGENT, "no section [agent]") if sources else (MANIFEST, "no agent/")
        hint = 'Write both: agent/agent.py, and [agent] with entry = "agent.py:make".'
        yield Finding(where, f"The submission has {lacks} beside it.", hint)
        return
    file, _, name = str(section.get("entry", "")).partition(":")
    path = f"{AGENT}/{file}"
    if path not in sources:
        message = f"The entry is {quote(section.get('entry'))}, and there is no {path[:80]}."
        yield Finding(f"{MANIFEST}, [agent] entry", message, did_you_mean(path[:80], sources))
    elif path in parsed(sources):
        symbols = symtable.symtable(decoded(sources[path]), path, "exec").get_symbols()
        defined = [each.get_name() for each in symbols if each.is_assigned() or each.is_imported()]
        if name not in defined:
            message = f"It defines no {quote(name)}, the factory that submission.toml names."
            yield Finding(path, message, did_you_mean(name, defined))


@rule("agent")
def not_python(sources: Sources, section: Section) -> Iterator[Finding]:
    """The files of agent/ are Python in UTF-8, together at most 100 kB, in lines of at most 150 characters,
    without control, invisible or bidirectional-override characters."""
    if (size := sum(map(len, sources.values()))) > MAX_BYTES:
        yield Finding(
            AGENT, f"The code has {size / 1e3:.1f} kB; the limit is {MAX_BYTES // 1000} kB.", "Shorten it."
        )
    for path, data in sources.items():
        try:
            text = decoded(data)
        except REFUSED as error:
            line = getattr(error, "lineno", None)
            message = getattr(error, "msg", None) or "It is not UTF-8, or nested too deeply"
            yield Finding(f"{path}, line {line}" if line else path, f"{message}.", "Correct it.")
            continue
        for number, line in enumerate(text.replace("\r\n", "\n").split("\n"), 1):
            if len(line) > MAX_LINE:
                message = f"The line has {len(line)} characters; the limit is {MAX_LINE}."
                yield Finding(f"{path}, line {number}", message, "Break it.")
            if char := first_invisible(line.replace("\t", "")):
                message = f"The line contains the control or invisible character U+{ord(char):04X}."
                yield Finding(f"{path}, line {number}", message, "Remove it.")


@rule("agent")
def many_numbers(sources: Sources, section: Section) -> Iterator[Finding]:
    """The code has at most 300 numbers, each of at most 30 characters: weights are learned, not carried."""
    count = 0
    for path, tree in parsed(sources).items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and type(node.value) in (int, float, complex):
                count += 1
                if (node.end_col_offset or 0) - node.col_offset > MAX_DIGITS:
                    message = f"A number has more than {MAX_DIGITS} characters."
                    yield Finding(f"{path}, line {node.lineno}", message, "Round it.")
    if count > MAX_NUMBERS:
        message = f"The code has {count} numbers; the limit is {MAX_NUMBERS}."
        yield Finding(AGENT, message, "Compute them, or let the agent learn them.")


@rule("agent")
def long_strings(sources: Sources, section: Section) -> Iterator[Finding]:
    """No string of the code has more than 200 characters, and all together have at most 10,000. (Docstrings
    are free.)"""
    definitions = (ast.Module, ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    total = 0
    for path, tree in parsed(sources).items():
        nodes = list(ast.walk(tree))
        bodies = [node.body for node in nodes if isinstance(node, definitions) and node.body]
        docstrings = {id(body[0].value) for body in bodies if isinstance(body[0], ast.Expr)}
        for node in nodes:
            if not isinstance(node, ast.Constant) or not isinstance(node.value, str | bytes):
                continue
            if id(node) in docstrings:
                continue
            total += len(node.value)
            if len(node.value) > MAX_STRING:
                message = f"A string has {len(node.value):,} characters; the limit is {MAX_STRING}."
                yield Finding(f"{path}, line {node.lineno}", message, "Shorten it.")
    if total > MAX_STRINGS:
        message = f"The strings have {total:,} characters; the limit is {MAX_STRINGS:,}."
        yield Finding(AGENT, message, "Shorten them.")


@rule("agent")
def foreign_package(sources: Sources, section: Section) -> Iterator[Finding]:
    """The code imports Python's own modules, gym_extensions, numpy, its own files, and the ``packages`` that
    [agent] states. These are some of numpy, scipy, gymnasium, torch, stable-baselines3, onnx, onnxruntime."""
    listed = (section or {}).get("packages", ())
    packages = [str(each) for each in listed] if isinstance(listed, list) else []  # bad-value reports it
    for package in packages:
        if package not in BOX_PACKAGES:
            message = f"There is no {quote(package)} in the box."
            hint = "Without it, the agent cannot be trained here; submit runs and policies instead."
            yield Finding(f"{MANIFEST}, [agent] packages", message, hint)
    own = (PurePosixPath(path).stem for path in sources)
    known = {*sys.stdlib_module_names, "gym_extensions", "numpy", *own}
    known |= {package.replace("-", "_") for package in packages}
    for path, tree in parsed(sources).items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                names = [each.name for each in node.names]
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                names = [node.module or ""]
            else:
                continue
            for top in dict.fromkeys(name.partition(".")[0] for name in names):
                if top not in known:
                    message = f"It imports {quote(top)}, which [agent] does not state."
                    hint = f"State it in packages, if it is one of {', '.join(BOX_PACKAGES)}."
                    yield Finding(f"{path}, line {node.lineno}", message, hint)


@rule("agent")
def hidden_import(sources: Sources, section: Section) -> Iterator[Finding]:
    """The code names no ``import_module``, ``__import__`` or the like, nor ``exec`` and ``eval``, which run a
    text. (Methods of these two names are free. Longer ways, such as ``pkgutil``, are not found.)"""
    for path, tree in parsed(sources).items():
        for node in ast.walk(tree):
            match node:
                case ast.Name(id=name) | ast.alias(name=name):
                    is_used = name in BY_TEXT
                case ast.Attribute(attr=name):
                    is_used = name in BY_TEXT - {"exec", "eval"}
                case _:
                    continue
            if is_used:
                message = f"It names {quote(name)}, which imports or runs what a text says."
                yield Finding(f"{path}, line {node.lineno}", message, "Write an import statement.")
