"""MuJoCo for the browser: two files of the npm package ``@mujoco/mujoco``, pinned by their digests.

``make site-assets`` fetches them with ``npm``. They belong to no package and to no commit.
"""

import base64
import gzip
import hashlib
import zlib
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from gym_extensions.errors import BenchError

PACKAGE, VERSION = "@mujoco/mujoco", "3.14.0"
SHA256 = {
    "mujoco.js": "bc6980e4bc5ee5f809a6cabde0743798637e113d333f9e85124714d42be1ccae",
    "mujoco.wasm": "2d380f1070a556c3003b4a7c7c10c98a5f61db4e91815de1075ec478e9487e76",
}
"""The files that are used, by name."""
FOLDER = Path(".site-assets")
"""Where ``make site-assets`` puts them, in the current folder."""
HINT = "Run: make site-assets"


@dataclass(frozen=True)
class Simulator:
    """The two files as the site publishes them."""

    script: bytes  # the JavaScript that loads the other
    wasm: bytes  # the WebAssembly, compressed with gzip
    license: bytes  # of both, Apache-2.0

    @property
    def megabytes(self) -> float:
        """Their size as they are loaded."""
        return sum(map(len, self.files().values())) / 1e6

    def facts(self) -> dict[str, str]:
        """Paths and digests, for the page's script."""
        return {
            "version": VERSION,
            "script": "play/mujoco.js",
            "script_integrity": integrity(self.script),
            "wasm": "play/mujoco.wasm.packed",
            "wasm_integrity": integrity(self.wasm),
        }

    def files(self) -> dict[str, bytes]:
        """The files by their paths in the site."""
        facts = self.facts()
        return {
            facts["script"]: self.script,
            facts["wasm"]: self.wasm,
            "play/LICENSE-mujoco.txt": self.license,
        }


def integrity(content: bytes) -> str:
    """The digest of a file as browsers check it (Subresource Integrity)."""
    return f"sha256-{base64.b64encode(hashlib.sha256(content).digest()).decode()}"


def load(folder: Path) -> Simulator | None:
    """The files of a folder; None if there is no such folder.

    Raises ``BenchError`` if a file is missing, or is not the pinned one.
    """
    if not folder.is_dir():
        return None
    script, packed = (read_file(folder / name) for name in ("mujoco.js", "mujoco.wasm.gz"))
    try:
        wasm = gzip.decompress(packed)
    except (OSError, EOFError, zlib.error) as error:
        raise BenchError("bad-asset", f"It is no gzip file: {error}.", str(folder), HINT) from error
    for name, content in (("mujoco.js", script), ("mujoco.wasm", wasm)):
        check(name, content, folder)
    return Simulator(script, packed, license_of("mujoco"))


def license_of(package: str) -> bytes:
    """The licence that an installed package comes with."""
    text = metadata.distribution(package).read_text("licenses/LICENSE")
    return (text or f"See the package {package}.\n").encode()


def read_file(path: Path) -> bytes:
    """The content of a file. Raises ``BenchError`` if it cannot be read."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise BenchError("bad-asset", f"{error.strerror or error}.", str(path), HINT) from error


def check(name: str, content: bytes, where: Path) -> None:
    """Raises ``BenchError`` if a file is not the pinned one of this name."""
    if hashlib.sha256(content).hexdigest() != SHA256[name]:
        message = f"{name} is not the one of {PACKAGE} {VERSION}."
        raise BenchError("bad-asset", message, str(where), f"Remove the folder. {HINT}")
