"""How to cite gym-extensions and the paper whose tasks it rebuilds, as in CITATION.cff."""

from __future__ import annotations

from importlib.metadata import version

PAPER = """@article{henderson2017benchmark,
  title = {{Benchmark Environments for Multitask Learning in Continuous Domains}},
  author = {Henderson, Peter and Chang, Wei-Di and Shkurti, Florian and Hansen, Johanna and Meger, David and
            Dudek, Gregory},
  journal = {arXiv preprint arXiv:1708.04352},
  year = {2017},
  url = {https://arxiv.org/abs/1708.04352},
}
"""


def software_bibtex() -> str:
    """BibTeX of the installed version, and of the paper."""
    software = f"""@software{{gym_extensions,
  title = {{{{gym-extensions}}}},
  author = {{{{The gym-extensions authors}}}},
  version = {{{version("gym-extensions")}}},
  license = {{MIT}},
}}
"""
    return f"{software}\n{PAPER}"
