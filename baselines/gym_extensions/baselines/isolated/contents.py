"""What lies in the box: Python, the packages of agents, and this project without simulator and experts.

Everything is the world's own, seen through a read-only mount, so that versions and results are the same.
"""

import importlib.metadata
import os
import re
import sys
import sysconfig
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from gym_extensions.submissions.manifest import BOX_PACKAGES

PYTHON, PACKAGES, AGENT = "/python", "/packages", "/agent"
"""Where they lie in the box."""
DISTRIBUTIONS = (*BOX_PACKAGES, "numba", "msgspec", "tomli-w", "threadpoolctl")
"""The packages that an agent may import, with what they require, as far as they are installed."""
ABSENT = ("mujoco", "gym-extensions")
OWN = ("baselines", "catalog", "submissions", "errors", "files", "versions", "policies")
"""The parts of this project that an agent may import: no environments, experts or submissions."""
SYSTEM = ("/lib", "/lib64", "/usr/lib64", "/lib/x86_64-linux-gnu", "/usr/lib/x86_64-linux-gnu")
"""Folders of shared libraries; no programs."""
DEVICES = ("/dev/null", "/dev/zero", "/dev/random", "/dev/urandom")
FACTS = ("/proc/cpuinfo", "/sys/devices/system/cpu", "/etc/ld.so.cache")
"""From what libraries choose kernels for the processor. Nothing else of /proc and /sys is there."""


def mounts(agent: Path | None) -> Iterator[tuple[str, ...]]:
    """The options of bubblewrap that make the files of the box; ``agent`` is the stranger's file."""
    for name in SYSTEM:
        path = Path(name)
        if path.is_symlink():
            yield "--symlink", str(path.readlink()), name
        elif path.is_dir() and name != "/lib" and not path.parent.is_symlink():
            yield "--ro-bind", name, name
    yield from (("--dev-bind", name, name) for name in DEVICES)
    yield from (("--ro-bind-try", name, name) for name in FACTS)
    # Python with its standard library and its own shared libraries, without installed packages.
    yield "--ro-bind", os.path.realpath(sys.executable), f"{PYTHON}/bin/python"
    base = Path(sys.base_prefix).resolve()
    installed = {"base": sys.base_prefix, "platbase": sys.base_exec_prefix}
    for folder in sorted({sysconfig.get_path(name, vars=installed) for name in ("stdlib", "platstdlib")}):
        inside = f"{PYTHON}/{Path(folder).resolve().relative_to(base)}"
        yield "--ro-bind", folder, inside
        for name in ("site-packages", "dist-packages"):
            if (Path(folder) / name).is_dir():
                yield from _empty(f"{inside}/{name}")
    for path in sorted((base / "lib").glob("*.so*")) if base != Path("/usr") else ():
        if "mujoco" not in path.name and path.is_file():
            yield "--ro-bind", str(path), f"{PYTHON}/lib/{path.name}"
    for name, path in sorted(packages().items()):
        yield "--ro-bind", str(path), f"{PACKAGES}/{name}"
    yield from _empty(f"{PACKAGES}/gymnasium/envs/mujoco")  # its models
    for path in packages()["gym_extensions/catalog"].glob("states-*.npz"):  # experts have been there
        yield "--ro-bind", "/dev/null", f"{PACKAGES}/gym_extensions/catalog/{path.name}"
    if agent is not None:
        yield "--ro-bind", str(agent.resolve()), f"{AGENT}/{agent.name}"


def _empty(folder: str) -> Iterator[tuple[str, ...]]:
    yield from (("--tmpfs", folder), ("--remount-ro", folder))


@cache
def packages() -> dict[str, Path]:
    """The files and folders that :data:`DISTRIBUTIONS` installed, and :data:`OWN`, by their place."""
    found, waiting, seen = dict[str, Path](), list(DISTRIBUTIONS), {*ABSENT}
    while waiting:
        name = re.sub(r"[-_.]+", "-", waiting.pop()).lower()
        if name in seen:
            continue
        seen.add(name)
        try:
            distribution = importlib.metadata.distribution(name)
        except importlib.metadata.PackageNotFoundError:
            continue
        lines = (distribution.read_text("RECORD") or "").splitlines()  # thousands
        tops = {line.partition(",")[0].partition("/")[0].strip('"') for line in lines}
        for top in tops - {"", "..", "__pycache__"}:
            found[top] = Path(str(distribution.locate_file(top)))
        for requirement in distribution.requires or ():
            if "extra ==" not in requirement and (match := re.match(r"[\w.-]+", requirement)):
                waiting.append(match[0])
    for part in OWN:
        spec = find_spec(f"gym_extensions.{part}")
        assert spec is not None and spec.origin is not None
        path = Path(spec.origin)
        path = path.parent if spec.submodule_search_locations else path
        found[f"gym_extensions/{path.name}"] = path
    return found
