"""Fetches MuJoCo for the browser with ``npm``, for the page Play: ``make site-assets``."""

import gzip
import shutil
import subprocess
import tarfile
import tempfile
from contextlib import suppress
from pathlib import Path

from gym_extensions.errors import BenchError, reports_mistakes
from gym_extensions.site import SITE_ASSETS
from gym_extensions.site.play.assets import PACKAGE, SHA256, VERSION, check, load, read_file
from tools import argument_parser


def fetch(folder: Path) -> None:
    """Fetches the package with npm, checks the two files and writes them.

    Raises ``BenchError`` if npm is missing or fails, or a file is not the pinned one.
    """
    npm = shutil.which("npm")
    if npm is None:
        raise BenchError("no-npm", "npm is not installed.", hint="Install Node.js, which has npm.")
    with tempfile.TemporaryDirectory() as scratch:
        done = subprocess.run(
            [npm, "pack", "--silent", f"{PACKAGE}@{VERSION}"],
            cwd=scratch, capture_output=True, text=True, check=False,
        )  # fmt: skip
        archives = list(Path(scratch).glob("*.tgz"))
        if done.returncode or len(archives) != 1:
            raise BenchError("no-package", f"npm failed: {done.stderr.strip()[-300:]}", PACKAGE)
        with tarfile.open(archives[0]) as archive:
            archive.extraction_filter = getattr(tarfile, "data_filter", None)  # from Python 3.11.4 on
            archive.extractall(scratch)
        contents = {name: read_file(Path(scratch) / "package" / name) for name in SHA256}
    for name, content in contents.items():
        check(name, content, folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "mujoco.js").write_bytes(contents["mujoco.js"])
    (folder / "mujoco.wasm.gz").write_bytes(gzip.compress(contents["mujoco.wasm"], 9, mtime=0))


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Fetches the files, unless they are there."""
    parser = argument_parser("tools.mujoco_wasm", __doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=SITE_ASSETS, help="default: %(default)s")
    folder = parser.parse_args(argv).folder
    with suppress(BenchError):  # other files are there
        if load(folder) is not None:
            return 0
    fetch(folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
