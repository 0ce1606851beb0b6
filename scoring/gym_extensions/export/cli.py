"""``gym-extensions export``: results as folders in the formats of other projects."""

from __future__ import annotations

import argparse
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.errors import BenchError, reports_mistakes, working

EPILOG = "Nothing is sent anywhere: upload the folder yourself."


def parser() -> argparse.ArgumentParser:
    """The command's arguments."""
    command = argparse.ArgumentParser(
        prog="gym-extensions export",
        description="Write results into a new folder, in the format of another project.",
        epilog=EPILOG,
    )
    formats = command.add_subparsers(dest="format", required=True, metavar="FORMAT")
    eee = formats.add_parser("every-eval-ever", help="metrics as records of Every Eval Ever", epilog=EPILOG)
    _add_submissions(eee, "+")
    _add_out(eee)
    hugging_face = formats.add_parser(
        "hugging-face",
        help="policies with model cards, and episodes as a dataset with Croissant metadata",
        epilog=EPILOG,
    )
    _add_submissions(hugging_face, "*")
    hugging_face.add_argument("--experts", action="store_true", help="also the experts of this version")
    _add_out(hugging_face)
    minari = formats.add_parser("minari", help="episodes of a verified policy as a Minari dataset")
    add = minari.add_argument
    add("submission", type=Path, metavar="SUBMISSION", help="a submission's folder")
    add("--group", required=True, metavar="NAME", help="the group")
    add("--protocol", choices=PROTOCOLS, default="sequential")
    add("--run", type=int, default=0, metavar="N", help="the run (default: 0)")
    add("--stage", type=int, metavar="S", help="the policy after S tasks (default: the last one)")
    add("--task", metavar="NAME", help="the task (default: the last one of the group)")
    add("--episodes", type=int, default=20, metavar="N", help="with the seeds 0 to N - 1 (default: 20)")
    _add_out(minari)
    return command


def _add_submissions(command: argparse.ArgumentParser, count: str) -> None:
    help_ = "a submission, or a folder of submissions"
    command.add_argument("submissions", nargs=count, type=Path, metavar="SUBMISSION", help=help_)
    help_ = "only this group; may be repeated (default: all)"
    command.add_argument("--group", action="append", default=[], metavar="NAME", help=help_)


def _add_out(command: argparse.ArgumentParser) -> None:
    command.add_argument("--out", required=True, type=Path, metavar="DIR", help="the new folder")


@contextmanager
def new_folder(target: Path) -> Iterator[Path]:
    """A folder that gets the name ``target`` at the end, or is removed if anything fails.

    Raises:
        BenchError: the target exists, or cannot be written.
    """
    if target.exists() or target.is_symlink():
        raise BenchError("bad-out", "It exists.", str(target), "Name a new folder for --out.")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        partial = Path(tempfile.mkdtemp(prefix=f".{target.name}.", dir=target.parent))
    except OSError as error:
        message = f"{error.strerror or error}."
        raise BenchError("not-written", message, str(target), "Choose another folder for --out.") from error
    try:
        yield partial
        partial.chmod(0o755)  # mkdtemp's is private
        partial.rename(target)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs the command and returns the exit status."""
    options = parser().parse_args(argv)
    with new_folder(options.out) as folder, working(f"exporting to {options.out}"):
        if options.format == "every-eval-ever":
            from gym_extensions.export.every_eval_ever import write_records

            count = write_records(folder, options.submissions, options.group)
            said = f"{count} record{'s' if count > 1 else ''}"
        elif options.format == "hugging-face":
            from gym_extensions.export.hugging_face import write_repositories

            said = ", ".join(write_repositories(folder, options.submissions, options.group, options.experts))
        else:
            from gym_extensions.export.minari_dataset import write_dataset

            names = ("protocol", "run", "stage", "task", "episodes")
            chosen = {name: getattr(options, name) for name in names}
            said = write_dataset(folder, options.submission, options.group, **chosen)
    print(f"{options.out}: {said}")
    return 0
