"""The ``score`` command loads no library that it does not need."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

Write = Callable[..., Path]


def test_help_loads_no_table_library_and_no_simulator() -> None:
    code = (
        "import sys\nimport gym_extensions.scoring.cli\n"
        "from gym_extensions.scoring.cli import parser\nparser().format_help()\n"
        "heavy = ('pandas', 'numpy', 'gymnasium', 'mujoco', 'torch', 'rich', 'msgspec')\n"
        "print([name for name in heavy if name in sys.modules])"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout == b"[]\n"


def test_scoring_loads_no_simulator_and_no_torch(submission: Write) -> None:
    code = (
        "import sys\nfrom pathlib import Path\n"
        "from gym_extensions.scoring.pipeline.score import score_folders\n"
        "score_folders([Path(sys.argv[1])])\n"
        "heavy = ('pandas', 'scipy.stats', 'gymnasium', 'mujoco', 'torch')\n"
        "print([name for name in heavy if name in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code, submission()], capture_output=True, check=True)
    assert found.stdout == b"[]\n"


def test_only_csv_and_markdown_load_pandas(submission: Write) -> None:
    code = (
        "import sys\nfrom gym_extensions.scoring.cli import main\n"
        "for option in sys.argv[2:]:\n"
        "    main([sys.argv[1], *option.split()])\n"
        "    print('pandas' in sys.modules, file=sys.stderr)"
    )
    for options, loaded in (("", "--json", "--csv"), "False False True"), (("--markdown",), "True"):
        command = [sys.executable, "-c", code, str(submission()), *options]
        done = subprocess.run(command, capture_output=True, check=True)
        assert done.stderr.decode().split() == loaded.split()
