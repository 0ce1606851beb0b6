"""Policies that lie elsewhere: a local server that is honest, slow, too large, or leads somewhere else."""

import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from gym_extensions.submissions import fetch
from gym_extensions.submissions.fetch import Fetcher, is_public
from gym_extensions.submissions.run import PolicyFile

from ..conftest import refused

CONTENT = b"policies" * 100
DIGEST = "a" * 64
THE_END = threading.Event()


class Server(BaseHTTPRequestHandler):
    """Answers by the path."""

    def do_GET(self) -> None:
        """The file, a redirect, or silence."""
        port = int(self.headers["Host"].rpartition(":")[2])
        if self.path == "/hanging":
            THE_END.wait(60)
            return
        if self.path == "/missing":
            self.send_error(404)
            return
        if self.path.startswith("/to/"):
            self.send_response(302)
            self.send_header("Location", f"http://{self.path.removeprefix('/to/')}:{port}/file")
            self.end_headers()
            return
        self.send_response(200)
        self.end_headers()
        try:
            while True:
                self.wfile.write(CONTENT)
                if self.path != "/endless":
                    return
        except OSError:
            return

    def log_message(self, *_: object) -> None:
        """Nothing."""


@pytest.fixture
def server() -> Iterator[str]:
    httpd = ThreadingHTTPServer(("127.0.0.1", 0), Server)
    threading.Thread(target=httpd.serve_forever, daemon=True).start()
    THE_END.clear()
    yield f"http://127.0.0.1:{httpd.server_address[1]}"
    THE_END.set()
    httpd.shutdown()
    httpd.server_close()


def policies(url: str, size: int = len(CONTENT)) -> PolicyFile:
    return PolicyFile(sha256=DIGEST, size=size, url=url)


def is_refused(fetcher: Fetcher, file: PolicyFile, code: str, *facts: str) -> None:
    with refused(code, *facts, where="hopper-wall/sequential/run0"):
        fetcher.fetch(file, "hopper-wall/sequential/run0")
    assert list(fetcher.cache.glob("*")) == []


def test_a_file_is_fetched_once(server: str, tmp_path: Path) -> None:
    fetcher = Fetcher(tmp_path)
    path = fetcher.fetch(policies(f"{server}/file"), "run")
    assert path.read_bytes() == CONTENT
    stamp = path.stat().st_mtime_ns
    assert fetcher.fetch(policies(f"{server}/file"), "run").stat().st_mtime_ns == stamp


def test_what_is_missing_or_does_not_answer_is_named(
    server: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, reason, seconds in (("missing", "Not Found", 60.0), ("hanging", "timed out", 0.2)):
        monkeypatch.setattr(fetch, "IDLE_SECONDS", seconds)
        is_refused(Fetcher(tmp_path), policies(f"{server}/{name}"), "policies-missing", reason)


@pytest.mark.parametrize(("name", "size"), [("endless", len(CONTENT)), ("file", 10), ("file", 10_000)])
def test_another_size_than_stated_is_refused_while_it_streams(
    server: str, tmp_path: Path, name: str, size: int
) -> None:
    is_refused(Fetcher(tmp_path), policies(f"{server}/{name}", size), "policies-size")


def test_no_more_is_read_than_a_file_may_have_whatever_is_stated(
    server: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fetch, "LIMIT", 10_000)
    is_refused(Fetcher(tmp_path), policies(f"{server}/endless", 10**12), "policies-size")


@pytest.mark.parametrize("public_only", [True, False])
def test_an_address_that_is_none_is_named(tmp_path: Path, public_only: bool) -> None:
    is_refused(Fetcher(tmp_path, public_only), policies("https://[x"), "policies-missing", "https://[x")


@pytest.mark.parametrize("url", ["http://example.org/x", "file:///etc/passwd", "s3://bucket/x", "ftp://x/y"])
def test_a_workflow_reads_nothing_but_https(tmp_path: Path, url: str) -> None:
    is_refused(Fetcher(tmp_path, public_only=True), policies(url), "policies-address")


def test_a_workflow_connects_to_no_private_address_and_follows_no_redirect_to_one(
    server: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fetch, "PUBLIC_SCHEMES", ("http",))
    fetcher = Fetcher(tmp_path, public_only=True)
    is_refused(fetcher, policies(f"{server}/file"), "policies-missing", "public address")
    monkeypatch.setattr(fetch, "is_public", lambda address: address == "127.0.0.1")
    is_refused(fetcher, policies(f"{server}/to/127.0.0.2"), "policies-missing", "public address")
    assert fetcher.fetch(policies(f"{server}/to/127.0.0.1"), "run").read_bytes() == CONTENT


@pytest.mark.parametrize(
    ("address", "expected"),
    [
        ("93.184.216.34", True),
        ("2606:2800:220:1:248:1893:25c8:1946", True),
        *((private, False) for private in ("127.0.0.1", "10.1.2.3", "169.254.169.254", "192.168.0.1")),
        *((private, False) for private in ("::1", "fe80::1", "fd00::1", "::ffff:127.0.0.1", "224.0.0.1")),
    ],
)
def test_which_addresses_are_public(address: str, expected: bool) -> None:
    assert is_public(address) is expected
