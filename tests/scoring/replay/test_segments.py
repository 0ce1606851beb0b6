"""The CPUs on which segments are replayed."""

from __future__ import annotations

import os

import pytest

from gym_extensions.scoring.replay.segments import usable_cpus


@pytest.mark.parametrize(("has_it", "count"), [(True, 3), (False, 5)])
def test_the_usable_cpus_are_known_on_every_system(
    has_it: bool, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python 3.13 knows the CPUs of the process; before it, and on every system, those of the machine."""
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 5)
    if has_it:
        monkeypatch.setattr(os, "process_cpu_count", lambda: 3, raising=False)
    else:
        monkeypatch.delattr(os, "process_cpu_count", raising=False)
    assert usable_cpus() == count


def test_there_is_at_least_one_cpu(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "process_cpu_count", lambda: None, raising=False)
    assert usable_cpus() == 1
