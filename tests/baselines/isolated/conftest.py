"""Runs programs as an ordinary user, because root may not start a box; the tests of CI run as root."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from numba.core import caching

import gym_extensions

ROOT, ROOTS = Path(__file__).parents[3], ("envs", "scoring")
USER = 65533
HIDDEN = "/root"
"""A folder that only root can enter; where Python lies in it, the programs see that part of it."""
AS_USER = r"""
set -e
if [ $# -gt 0 ] && [ "$1" != -- ]; then
  stage=$(mktemp -d)
  mount --bind /root "$stage"
  mount -t tmpfs -o mode=755 none /root
  while [ "$1" != -- ]; do
    mkdir -p "/root/$1"
    mount --bind "$stage/$1" "/root/$1"
    shift
  done
  umount "$stage"
  rmdir "$stage"
fi
shift
exec setpriv --reuid=65533 --regid=65533 --clear-groups "$@"
"""
Run = Callable[..., Any]


def as_user(arguments: list[str]) -> list[str]:
    """A command line that runs another one as an ordinary user, in a mount namespace of its own."""
    if os.getuid() != 0:
        return arguments
    needed = {Path(sys.base_prefix), Path(sys.prefix), ROOT, *map(Path, sys.path)}
    inside = sorted({str(path.relative_to(HIDDEN)) for path in needed if path.is_relative_to(HIDDEN)})
    top = [path for path in inside if not any(path.startswith(f"{other}/") for other in inside)]
    return ["unshare", "--mount", "sh", "-c", AS_USER, "sh", *top, "--", *arguments]


class Ordinary:
    """An ordinary user with a home, whose programs print JSON. They import the code that this process does.

    Its home has the code that numba has compiled before, because that takes seconds of every new user.
    """

    def __init__(self, home: Path) -> None:
        self.home, self.compiled = home, home / "numba"
        folder_of: Callable[[str], str] = caching._CacheLocator.get_suitable_cache_subpath
        for path in (file for root in ROOTS for file in (ROOT / root).rglob("__pycache__/*.nb[ci]")):
            module = path.parents[1] / f"{path.name.partition('.')[0]}.py"
            target = self.compiled / folder_of(str(module))
            target.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target / path.name)
        for path in (home, *home.rglob("*")) if os.getuid() == 0 else ():
            os.chown(path, USER, USER)

    def start(self, program: str, *arguments: str) -> subprocess.Popen[str]:
        path = self.home / "program.py"
        path.write_text(program, encoding="utf-8")
        environment = {"PATH": os.environ["PATH"], "HOME": str(self.home), "OPENBLAS_NUM_THREADS": "1"}
        environment |= {"SECRET_TOKEN": "secret", "NUMBA_CACHE_DIR": str(self.compiled)}
        environment["PYTHONPATH"] = os.pathsep.join(
            str(Path(part).parent) for part in gym_extensions.__path__
        )
        return subprocess.Popen(
            as_user([sys.executable, str(path), *arguments]),
            cwd=self.home,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def run(self, program: str, *arguments: str) -> Any:
        """What the program printed last, as JSON."""
        process = self.start(program, *arguments)
        output, errors = process.communicate(timeout=600)
        assert process.returncode == 0, output + errors
        return json.loads(output.strip().splitlines()[-1])


PROBE = """
import json
from gym_extensions.baselines.isolated.box import Box
from gym_extensions.baselines.isolated.confine import Limits
from gym_extensions.errors import BenchError
try:
    Box("probe", None, Limits())
    print(json.dumps(""))
except BenchError as error:
    print(json.dumps(str(error)))
"""


@pytest.fixture(scope="session")
def ordinary() -> Iterator[Ordinary]:
    """An ordinary user who can start boxes. Skips the test, with the reason, where that is impossible."""
    if sys.platform != "linux":
        pytest.skip("boxes need Linux")
    with tempfile.TemporaryDirectory() as folder:
        user = Ordinary(Path(folder))
        process = user.start(PROBE)
        output, errors = process.communicate(timeout=120)
        if process.returncode != 0:
            pytest.skip(f"no ordinary user can run Python here: {errors.strip()[-200:]}")
        if reason := json.loads(output):
            pytest.skip(reason)
        yield user
