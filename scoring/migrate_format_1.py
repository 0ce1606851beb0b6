"""Moves the policies of submissions from one file per stage to one file per run, in place.

    python scoring/migrate_format_1.py --repack-policies submissions/trpo …

The old form has a file per stage in ``<group>/policies``. No array changes, so that digests, and what
reviews say about them, stay. Running it again changes nothing. Remove it when no entry has such a folder.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

import msgspec

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.files import write_bytes
from gym_extensions.rollouts.layout import DOCUMENT, POLICIES
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.run import PolicyFile, read_run, write_run
from gym_extensions.rollouts.run_policies import content_sha256, npz_bytes, old_policy_files, read_arrays


def repack(folder: Path) -> int:
    """Writes the policies of every run of a submission into one file, and returns the number of files."""
    count = 0
    for old in sorted(folder.glob("*/policies")):
        group = GROUPS[old.parent.name]
        for path in sorted(old.parent.glob(f"*/run*{DOCUMENT}")):
            document = read_run(path)
            run = group, document.protocol, document.run
            if document.policies is None or not old_policy_files(folder, *run):
                continue
            arrays = read_arrays(folder, *run)
            data = npz_bytes(arrays)
            write_bytes(path.with_suffix(POLICIES), data)
            policies = PolicyFile(sha256=content_sha256(arrays), size=len(data))
            write_run(path, msgspec.structs.replace(document, policies=policies))
            count += 1
        shutil.rmtree(old)
    return count


def main(argv: list[str] | None = None) -> int:
    """Repacks the submissions that are named. Returns 1 if one of them has problems afterwards."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("submissions", nargs="+", type=Path)
    parser.add_argument("--repack-policies", action="store_true", required=True)
    status = 0
    for folder in parser.parse_args(argv).submissions:
        count, problems = repack(folder), read(folder).problems
        lines = [f"{problem.rule}: {problem.where}: {problem.message}" for problem in problems]
        sys.stdout.write("; ".join([f"{folder.name}: {count} files of policies", *lines]) + "\n")
        status |= bool(problems)
    return status


if __name__ == "__main__":
    raise SystemExit(main())
