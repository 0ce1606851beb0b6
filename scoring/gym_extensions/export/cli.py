"""``gym-extensions export``: results as folders in the formats of other projects."""

import argparse
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gym_extensions.errors import BenchError, reports_mistakes, working

FORMATS = {
    "hugging-face": "policies with model cards, and episodes as a dataset with Croissant metadata",
    "zoo": "policies as one dataset in Parquet: returns, diagnostics and weights, with Croissant metadata",
}
EPILOG = "Nothing is sent anywhere: upload the folder yourself."


def parser() -> argparse.ArgumentParser:
    """The command's arguments."""
    command = argparse.ArgumentParser(
        prog="gym-extensions export",
        description="Write results into a new folder, in the format of another project.",
        epilog=EPILOG,
    )
    formats = command.add_subparsers(dest="format", required=True, metavar="FORMAT")
    for name, text in FORMATS.items():
        part = formats.add_parser(name, help=text, epilog=EPILOG)
        add, help_ = part.add_argument, "a submission, or a folder of submissions"
        add("submissions", nargs="*", type=Path, metavar="SUBMISSION", help=help_)
        help_ = "only this group (or core); may be repeated (default: all)"
        add("--group", action="append", default=[], metavar="NAME", help=help_)
        if name == "hugging-face":
            add("--experts", action="store_true", help="also the experts of this version")
        add("--out", required=True, type=Path, metavar="DIR", help="the new folder")
    return command


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
        scratch = tempfile.TemporaryDirectory(prefix=f".{target.name}.", dir=target.parent)
    except OSError as error:
        message = f"{error.strerror or error}."
        raise BenchError("not-written", message, str(target), "Choose another folder for --out.") from error
    with scratch:
        partial = Path(scratch.name) / target.name
        partial.mkdir()
        yield partial
        partial.rename(target)


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Runs the command and returns the exit status."""
    options = parser().parse_args(argv)
    with new_folder(options.out) as folder, working(f"exporting to {options.out}"):
        from gym_extensions.export import hugging_face, zoo

        if options.format == "zoo":
            written = zoo.write_zoo(folder, options.submissions, options.group)
        else:
            chosen = options.submissions, options.group, options.experts
            written = hugging_face.write_repositories(folder, *chosen)
    print(f"{options.out}: {', '.join(written)}")
    return 0
