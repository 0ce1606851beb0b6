"""Gets policies that lie elsewhere into a cache. Their size is enforced while they stream.

By hand any address works that urllib knows. A workflow reads only ``https`` at public addresses: it has no
credentials, follows a redirect only to such an address, and connects to the address that was checked.
"""

import http.client
import ipaddress
import os
import socket
import time
import urllib.request
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from gym_extensions.errors import BenchError
from gym_extensions.files import write_bytes
from gym_extensions.submissions import layout, run
from gym_extensions.submissions.policies import files
from gym_extensions.submissions.policies.mlp_arrays import Array

CHUNK = 2**16
LIMIT = layout.MAX_FILE_BYTES[layout.POLICIES]
IDLE_SECONDS, TOTAL_SECONDS = 30.0, 600.0
"""Longest silence of a server, and longest time for a file."""
PUBLIC_SCHEMES = ("https",)
OTHER_FILE = "policies-changed"
"""The code of the error if an address has another file, which says nothing about the run's policies."""


@dataclass(frozen=True)
class Fetcher:
    """Gets files into the folder of a cache; with ``public_only``, from public ``https`` addresses alone."""

    cache: Path
    public_only: bool = False

    def fetch(self, policies: run.PolicyFile, where: str) -> Path:
        """The path of a copy of policies that lie elsewhere, which :func:`read_copy` reads and checks.

        A stated size of 0 is not known; the limit is that of a file. ``where`` names the run in errors.

        Raises:
            BenchError: the address may not be read, there is no such file, it has another size than stated,
                or the server does not answer.
        """
        name = sha256(f"{policies.url} {policies.sha256}".encode()).hexdigest()
        path = self.cache / f"{name}.npz"
        size = min(policies.size or LIMIT, LIMIT)
        if path.is_file() and policies.size in (0, path.stat().st_size):
            return path
        hint, url = "Ask the author for the file of the run.", policies.url
        try:
            if self.public_only and urlsplit(url).scheme not in PUBLIC_SCHEMES:
                message = f"{url} may not be read here: only {' and '.join(PUBLIC_SCHEMES)} addresses are."
                hint = "Verify the submission by hand, or move the file."
                raise BenchError("policies-address", message, where, hint)
            handlers = PUBLIC_HANDLERS if self.public_only else ()
            with urllib.request.build_opener(*handlers).open(url, timeout=IDLE_SECONDS) as file:
                content = _content(file, size)
        except (OSError, http.client.HTTPException, ValueError) as error:
            reason = str(getattr(error, "reason", "") or error) or type(error).__name__
            message = f"{url} cannot be read: {reason}."
            raise BenchError("policies-missing", message, where, hint) from error
        if len(content) > size or len(content) < policies.size:
            found = f"more than {size}" if len(content) > size else str(len(content))
            message = f"{url} has {found} bytes; the run states {policies.size or 'no size'}."
            raise BenchError("policies-size", message, where, hint)
        write_bytes(path, content)
        return path


def read_copy(path: Path, sha256: str, where: str) -> dict[str, Array]:
    """The arrays of a fetched copy, by their full names. One with another content leaves the cache.

    A stranger's file is read in a process with limits. Raises ``BenchError`` with ``where`` if it has another
    digest.
    """
    try:
        arrays = files.npz_arrays(path.read_bytes())
        files.require_digest(arrays, sha256)
    except BenchError as error:
        path.unlink(missing_ok=True)
        message = f"The address has another file than the run states. {error.message}"
        raise BenchError(OTHER_FILE, message, where, "Ask the author for the file of the run.") from error
    return arrays


def cache_folder() -> Path:
    """The user's folder for files that can be made again."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gym-extensions"


def _content(file: Any, size: int) -> bytes:
    """The bytes of a file, of which no more are read than one beyond the stated size."""
    parts, length, end = [], 0, time.monotonic() + TOTAL_SECONDS
    # read1 gives what is there, without waiting for more.
    while length <= size and (part := file.read1(min(CHUNK, size + 1 - length))):
        parts.append(part)
        length += len(part)
        if time.monotonic() > end:
            raise TimeoutError(f"It was not finished after {TOTAL_SECONDS:.0f} seconds")
    return b"".join(parts)


def is_public(address: str) -> bool:
    """Whether an IP address can be reached by everybody, and is none of this machine or its network."""
    ip = ipaddress.ip_address(address)
    mapped = getattr(ip, "ipv4_mapped", None)
    return (mapped or ip).is_global and not ip.is_multicast


class _Connection(http.client.HTTPConnection):
    """A connection to the address that was checked."""

    def connect(self) -> None:
        found = socket.getaddrinfo(self.host, self.port, type=socket.SOCK_STREAM)
        addresses = [str(each[4][0]) for each in found]
        if not addresses or not all(map(is_public, addresses)):
            raise PermissionError(f"{self.host} is not at a public address")
        self.sock = socket.create_connection((addresses[0], self.port), self.timeout)


class _TlsConnection(http.client.HTTPSConnection, _Connection):
    """The same, with TLS."""


class _Handler(urllib.request.HTTPHandler, urllib.request.HTTPSHandler):
    def http_open(self, req: urllib.request.Request) -> Any:
        return self.do_open(_Connection, req)

    def https_open(self, req: urllib.request.Request) -> Any:
        return self.do_open(_TlsConnection, req)


class _Redirects(urllib.request.HTTPRedirectHandler):
    max_redirections = 3

    def redirect_request(self, *arguments: Any) -> urllib.request.Request | None:
        url = str(arguments[-1])
        if urlsplit(url).scheme not in PUBLIC_SCHEMES:
            raise PermissionError(f"It redirects to {url}")
        return super().redirect_request(*arguments)


PUBLIC_HANDLERS = (urllib.request.ProxyHandler({}), _Handler, _Redirects)
