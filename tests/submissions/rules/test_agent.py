"""Every rule about the code of an agent reports its mistake, and honest agents break none."""

import shutil
import tracemalloc
from pathlib import Path

import pytest

from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import code_digest

from ..examples import GROUP, TOML, Change, Table, all_of, put

ROOT = Path(__file__).parents[3]
ALGORITHMS = sorted(ROOT.glob("baselines/*/baselines/algorithms/[!_]*.py"))
CODE = "agent/agent.py"
HEADER = '\n[agent]\nentry = "agent.py:make"\npackages = {}\n'
MAKE = "def make(observation_space, action_space, seed):\n    return None\n"


def stating(packages: str = "[]", entry: str = "agent.py:make") -> Change:
    text = HEADER.format(packages).replace("agent.py:make", entry)

    def change(folder: Path) -> None:
        with (folder / TOML).open("a", encoding="utf-8") as file:
            file.write(text)

    return change


def code(text: str | bytes, packages: str = "[]", path: str = CODE) -> Change:
    data = text if isinstance(text, bytes) else text.encode()
    return all_of(stating(packages), put(CODE, MAKE.encode()), put(path, data))


def after_make(text: str) -> Change:
    return code(f"{MAKE}{text}\n")


LINE_1, LINE_3, LINE_4 = (f"{CODE}, line {number}" for number in (1, 3, 4))
LONG = "# 12345\n" * 6_300
TWO = f"\n'{'x' * 101}'\n'{'y' * 101}'"
"""Two strings that are one."""
UTF_7 = f"# coding: utf-7\n{MAKE}# +AAo-WEIGHTS = [1.5, 2.5]\n"
"""Python reads a line feed in the comment, so that it runs what follows."""
MINE, TXT = all_of(stating(entry="mine.py:make"), put(CODE, MAKE.encode())), code("1", path="agent/a.txt")
EXAMPLES: Table = {
    "code-without-entry": [
        ("code alone", put(CODE, MAKE.encode()), "agent", "[agent]"),
        ("a section alone", stating(), TOML, "agent/agent.py"),
        ("another file", MINE, f"{TOML}, [agent] entry", "agent/agent.py"),
        ("another name", code("def made(): ..."), CODE, "made"),
    ],
    "unexpected-name": [
        ("no Python", TXT, "agent/a.txt", ""),
        ("a folder", code("", path="agent/b/a.py"), "agent/b", "", (), 2),
    ],
    "not-python": [
        ("a mistake", after_make("def"), LINE_3, "invalid syntax"),
        ("deeply nested", after_make("(" * 5000 + ")" * 5000), LINE_3, "nested"),
        ("not UTF-8", code(MAKE.encode() + b"# \xff"), CODE, "UTF-8"),
        ("a long line", after_make(f"# {'x' * 149}"), LINE_3, "151 characters"),
        ("hidden text", after_make("# \u202e"), LINE_3, "U+202E"),
        ("hidden weights", after_make("# ·\ufe00\U000e0101\U000e01ef"), LINE_3, "U+FE00"),
        ("a control character", after_make("# \x0c" + "x" * 99), LINE_3, "U+000C"),
        ("a line in many", after_make(f"# {'x' * 99}\x0b{'x' * 99}"), LINE_3, "201 characters", (), 2),
        ("other text than a reader sees", code(UTF_7), CODE, "declares the encoding utf-7"),
        ("much", all_of(after_make(LONG), put("agent/b.py", LONG.encode())), "agent", "100 kB"),
    ],
    "many-numbers": [
        ("a layer", after_make("W = [\n" + "1.5, 2,\n" * 151 + "]"), "agent", "302"),
        ("a long one", after_make(f"W = 1{'0' * 30}"), LINE_3, "30"),
    ],
    "long-strings": [
        ("one", after_make(f"W = ({TWO})"), LINE_4, "202"),
        ("bytes", after_make(f"W = ({TWO})".replace("\n", "\nb")), LINE_4, "202"),
        ("many", after_make(f"W = '{'x' * 140}'\n" * 72), "agent", "10,080"),
    ],
    "foreign-package": [
        ("absent", code(MAKE, '["jax"]'), f"{TOML}, [agent] packages", "'jax'"),
        ("not stated", code(f"import torch\n{MAKE}"), LINE_1, "'torch'"),
        ("a simulator", code(f"from mujoco.x import y\n{MAKE}"), LINE_1, "mujoco"),
    ],
    "hidden-import": [
        ("a module", after_make("import importlib as x; x.import_module('numba')"), LINE_3, "import_module"),
        ("its function", after_make("from importlib import import_module as x"), LINE_3, "import_module"),
        ("a builtin", after_make("X = __import__('numba')"), LINE_3, "__import__"),
        ("in another name", after_make("X = [__import__][0]"), LINE_3, "__import__"),
        ("a text that runs", after_make("exec('import ' + 'numba')"), LINE_3, "exec"),
        ("the builtins", after_make("import builtins"), LINE_3, "builtins"),
    ],
    "bad-value": [
        ("packages in a text", code(MAKE, '"torch"'), f"{TOML}, [agent] packages", "'torch'"),
        ("packages in a number", code(MAKE, "3"), f"{TOML}, [agent] packages", "3"),
    ],
    "malformed-training": [("no table", put("trained/1.toml", b"rank = 1\n"), "trained/1.toml", "rank")],
}


@pytest.mark.parametrize(
    ("text", "packages"),
    [
        (f'"""{"A long text. " * 40}"""\nimport math, numpy, gym_extensions\n{MAKE}', "[]"),
        (f"import torch\nfrom stable_baselines3 import PPO\n{MAKE}", '["torch", "stable-baselines3"]'),
        ("from gym_extensions.baselines.algorithms.trpo import make\n", "[]"),
        ("class Agent: ...\nmake = Agent\n", "[]"),
        (f"import re\n{MAKE}    return re.compile('x'), seed.eval()\n", "[]"),
        ("class Agent: ...\nmake: type = Agent\n", "[]"),
        ("if True:\n    other, make = 1, len\n", "[]"),
    ],
)
def test_these_agents_break_no_rule(text: str, packages: str, folder: Path) -> None:
    code(text.replace(". A", ".\nA"), packages)(folder)
    assert read(folder).problems == ()


@pytest.mark.parametrize("path", ALGORITHMS, ids=lambda path: path.stem)
def test_the_code_of_this_project_keeps_to_the_limits(path: Path, folder: Path) -> None:
    code(path.read_text(encoding="utf-8"), path=f"agent/{path.stem}_.py")(folder)
    found = {problem.rule for problem in read(folder).problems}
    assert found <= {"foreign-package"}, "some import packages that this section does not state"


def test_a_text_that_python_compiles_to_much_more_is_only_parsed(folder: Path) -> None:
    """Every ``return`` repeats what follows ``finally``, so that 23 kB need 330 MB when they are compiled."""
    code("def make():\n try:\n" + "  return\n" * 1000 + " finally:\n" + "  make()\n" * 1500)(folder)
    tracemalloc.start()
    assert read(folder).problems == ()
    assert tracemalloc.get_traced_memory()[1] < 1.5e8
    tracemalloc.stop()


def test_code_alone_is_a_submission(folder: Path) -> None:
    shutil.rmtree(folder / GROUP)
    code(MAKE)(folder)
    found = read(folder)
    assert found.problems == ()
    assert found.code == code_digest({CODE: MAKE.encode()}, "agent.py:make")
