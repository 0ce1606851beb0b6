"""tools/README.md lists the commands, and no other."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_the_readme_lists_every_command() -> None:
    modules = [path for path in (ROOT / "tools").rglob("*.py") if "__main__" in path.read_text("utf-8")]
    names = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__main__") for path in modules
    }
    listed = re.findall(r"python -m ([\w.]+)", (ROOT / "tools" / "README.md").read_text("utf-8"))
    assert sorted(listed) == sorted(name.removesuffix(".__main__") for name in names)
