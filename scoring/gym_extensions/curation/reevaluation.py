"""Whether the record of a re-evaluation proves the level of trust that the ledger states."""

from __future__ import annotations

from pathlib import Path

from gym_extensions.errors import BenchError
from gym_extensions.scoring.reevaluation.record import FOLDER, load, path_of


def require_reevaluation(path: Path, digest: str, salt: str) -> None:
    """Raises BenchError unless all policies of a submission were evaluated on the new seeds of a salt.

    Args:
        path: the submission's folder, in the folder of submissions of a repository.
        digest: the submission's digest without its traces.
        salt: the salt from which the seeds must follow, 64 hexadecimal digits.
    """
    folder = path.resolve().parent.parent / FOLDER
    record = load(folder, path.name)
    hint = f"Run `gym-extensions reevaluate submissions/{path.name} --salt SALT` with the salt of the line."
    if record is None:
        raise BenchError("unproven-level", "The file does not exist.", str(path_of(folder, path.name)), hint)
    if (record.new_seeds.digest, record.new_seeds.salt) != (digest, salt):
        message = "The record is of other files or of another salt."
        raise BenchError("unproven-level", message, str(path_of(folder, path.name)), hint)
    if not record.is_complete:
        message = "Not all logs of the submission have policies."
        raise BenchError("unproven-level", message, str(path_of(folder, path.name)), "Leave --level out.")
