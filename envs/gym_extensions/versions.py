"""The versions of installed packages, the processor, and the BLAS kernels of this process."""

import functools
import platform
from importlib import metadata
from pathlib import Path

CPU_INFO = Path("/proc/cpuinfo")


@functools.cache
def version(package: str) -> str:
    """Returns the version of an installed package. It is read once per process: long metadata takes 4 ms."""
    return metadata.version(package)


def version_or_none(package: str) -> str | None:
    """Returns the version of a package; None if it is not installed."""
    try:
        return version(package)
    except metadata.PackageNotFoundError:
        return None


def processor() -> str:
    """The name of the processor, such as ``Intel(R) Xeon(R) CPU``; the architecture if it has no other."""
    try:
        lines = CPU_INFO.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return (names or [platform.processor()])[0] or platform.machine() or "unknown"


def blas_kernels() -> str:
    """The BLAS library of numpy in this process with its kernels, such as ``openblas SkylakeX``.

    The library chooses the kernels by the processor, OpenBLAS by the environment variable
    ``OPENBLAS_CORETYPE`` if it is set. Other kernels give other last bits of a matrix product. It is
    ``unnamed`` for a library that does not name them, such as Accelerate.
    """
    import numpy  # noqa: F401  (it loads its BLAS)
    from threadpoolctl import ThreadpoolController

    libraries = ThreadpoolController().select(user_api="blas").info()
    of_numpy = [each for each in libraries if "numpy" in each["filepath"]]
    names = (f"{each['internal_api']} {each.get('architecture', '')}" for each in of_numpy or libraries)
    return ", ".join(dict.fromkeys(name.strip() for name in names)) or "unnamed"
