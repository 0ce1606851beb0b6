"""What only the makers of this repository run; README.md lists the commands. The package never imports it."""

import argparse
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
"""The folder of the repository."""


def argument_parser(module: str, documentation: str | None) -> argparse.ArgumentParser:
    """The parser of ``python -m MODULE``, whose help is the docstring of the module, line by line."""
    return argparse.ArgumentParser(
        prog=f"python -m {module}",
        description=documentation,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
