"""Where runs come from: versions, machine and commit, and what training took, measured where it trains."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from gym_extensions.submissions.run import LONGEST, Versions
from gym_extensions.versions import blas_kernels, version

CPU_INFO = Path("/proc/cpuinfo")
PACKAGES = ("gym_extensions", "gymnasium", "mujoco", "numpy")
"""The packages on which the results of every job depend."""


@dataclass(frozen=True)
class Usage:
    """What a stage took in the process that trained it, and in that of an agent in a box."""

    steps: int  # environment steps in training
    cpu_seconds: float  # processor time of the process, all threads together
    peak_memory_mb: float  # largest memory of the process since it started; 0 if unknown
    kernels: str  # the BLAS kernels
    processor: str  # its name
    cores: int  # logical processors of the machine


def processor_time(agent: object) -> float:
    """The processor time of this process in seconds, and of the agent's, if that is another one (a box)."""
    return time.process_time() + float(getattr(agent, "box_seconds", 0.0))


def usage_since(started: float, steps: int, agent: object = None) -> Usage:
    """What training steps used since a time of :func:`processor_time`."""
    seconds = round(processor_time(agent) - started, 3)
    return Usage(steps, seconds, peak_memory_mb(), blas_kernels(), processor(), os.cpu_count() or 1)


def peak_memory_mb() -> float:
    """The largest memory of this process since it started, in MB; 0 where the system does not tell."""
    try:
        import resource
    except ModuleNotFoundError:  # Windows
        return 0.0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return round(peak / (1e6 if sys.platform == "darwin" else 1e3), 1)


def processor() -> str:
    """The name of the processor, such as ``Intel(R) Xeon(R) CPU``; the architecture if it has no other."""
    try:
        lines = CPU_INFO.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return (names or [platform.processor()])[0] or platform.machine() or "unknown"


def joined(texts: Iterable[str]) -> str:
    """The distinct texts, as one of at most ``LONGEST`` characters."""
    return ", ".join(dict.fromkeys(filter(None, texts)))[:LONGEST]


def commit_of(folder: Path) -> str:
    """The commit of the folder's git repository; empty without one, with ``-dirty`` if there are changes."""
    command = ["git", "-C", str(folder), "describe", "--always", "--abbrev=40", "--dirty", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def job_versions(packages: Iterable[str] = ()) -> dict[str, str]:
    """The versions of the packages that every job uses, and of those that its agent uses besides them."""
    return {name: version(name.replace("_", "-")) for name in (*PACKAGES, *packages)}


def run_versions(kernels: Iterable[str]) -> Versions:
    """The versions of the packages, of Python and of the platform, with the BLAS kernels of the stages."""
    return Versions(
        **job_versions(),
        python=platform.python_version(),
        platform=f"{platform.system()}-{platform.machine()}",
        blas=joined(kernels),
    )
