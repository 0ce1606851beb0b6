"""Policies of one file per stage are moved into one file per run."""

from __future__ import annotations

import runpy
from collections.abc import Callable
from pathlib import Path

import msgspec

from gym_extensions.catalog.groups import group
from gym_extensions.rollouts.layout import run_file
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.run import PolicyFile, read_run, write_run
from gym_extensions.rollouts.run_policies import has_policies, npz_bytes, read_policies

SCRIPT = Path(__file__).parents[1] / "scoring" / "migrate_format_1.py"
HOPPER = group("hopper-gravity")


def unpack(folder: Path, protocol: str, run: int) -> None:
    """Gives a run the old form."""
    path = folder / run_file(HOPPER.name, protocol, run, ".npz")
    old = folder / HOPPER.name / "policies"
    old.mkdir(exist_ok=True)
    for (stage, task), policy in read_policies(folder, HOPPER, protocol, run).items():
        name = f"{protocol}-run{run}-stage{stage}{f'-{task}' if task else ''}.npz"
        (old / name).write_bytes(npz_bytes(policy.arrays()))
    path.unlink()
    document = read_run(path.with_suffix(".json"))
    assert document.policies is not None
    policies = PolicyFile(sha256=document.policies.sha256, size=1)
    write_run(path.with_suffix(".json"), msgspec.structs.replace(document, policies=policies))


def test_policies_of_the_old_form_are_read_and_repacked_to_the_same_bytes(
    submission: Callable[..., Path],
) -> None:
    folder = submission()
    before = {path: path.read_bytes() for path in folder.rglob("run*")}
    for protocol in ("sequential", "single"):
        for run in (0, 1):
            unpack(folder, protocol, run)
    assert read(folder, policies=True).problems == ()
    assert has_policies(folder, HOPPER, "single", 1)
    main = runpy.run_path(str(SCRIPT))["main"]
    for _ in range(2):  # the second time changes nothing
        assert main([str(folder), "--repack-policies"]) == 0
        assert {path: path.read_bytes() for path in folder.rglob("run*")} == before
        assert not (folder / HOPPER.name / "policies").exists()
