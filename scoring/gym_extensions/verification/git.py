"""Reads commits with git's plumbing commands. Nothing is checked out, and no hook or filter is run."""

import contextlib
import os
import subprocess
import sys
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from gym_extensions.errors import BenchError
from gym_extensions.submissions import layout, manifest
from gym_extensions.submissions.problem import Problem

OPTIONS = (
    "--no-pager",
    *("-c", "core.hooksPath=/dev/null"),
    *("-c", "core.fsmonitor=false"),
    *("-c", "protocol.allow=never"),
    *("-c", "core.packedGitWindowSize=64m"),
    *("-c", "core.packedGitLimit=512m"),
)
"""No hooks, no file watcher, no network, and less memory than the limit for large repositories."""
ENVIRONMENT = {
    "GIT_NO_LAZY_FETCH": "1",
    "GIT_NO_REPLACE_OBJECTS": "1",
    "GIT_OPTIONAL_LOCKS": "0",
    "GIT_TERMINAL_PROMPT": "0",
    "LC_ALL": "C",
}
MAX_MEMORY = 2 * 2**30
MAX_CPU_SECONDS = 120
"""Limits of one git command: a small commit can stand for billions of files."""
LIMIT = f'ulimit -v "$0" 2>/dev/null; ulimit -t {MAX_CPU_SECONDS}; exec "$@"'
"""Runs a command with these limits. A system without a limit on memory (macOS) skips that one."""
PARTIAL = r"^remote\..*\.promisor$|^extensions\.partialclone$"
"""The settings of a clone that lacks contents that its remote has."""
LACKING = ("lazy fetching disabled", "could not fetch", "missing", "unable to read", "bad object")
"""Parts of git's errors about a content that is not in the clone."""
MACHINE_ERRORS = (
    *("no-git", "no-repository", "distrusted-clone", "partial-clone", "shallow-clone", "git-failed"),
    *("missing-extra", "no-box", "box-as-root"),
)
"""Codes of errors that are about this clone or machine, and not about the commits."""
NOT_FOUND = 127
NO_GIT = BenchError("no-git", "The command git was not found.", hint="Install git.")
SUBMODULE = "160000"
"""The mode of a submodule."""
REDIRECTIONS = ("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_OBJECT_DIRECTORY")
"""Variables with which git would read another repository; git sets some of them for hooks."""


class TreeEntry(NamedTuple):
    """A file of a commit. ``size`` is None for a submodule, and where sizes were not asked for."""

    mode: str
    object_id: str
    size: int | None
    path: str


@dataclass(frozen=True)
class Repository:
    """A git repository, by any folder of one of its work trees."""

    folder: Path

    def _command(self, *arguments: str) -> list[str]:
        limited = () if sys.platform == "win32" else ("sh", "-c", LIMIT, f"{MAX_MEMORY // 1024}")
        return [*limited, "git", *OPTIONS, "-C", str(self.folder), *arguments]

    def run(
        self, *arguments: str, statuses: Collection[int] = (0,), refusal: BenchError | None = None
    ) -> bytes:
        """The output of a git command.

        Raises ``BenchError``, if given this one, unless it ends with one of these statuses.
        """
        command = self._command(*arguments)
        try:
            result = subprocess.run(command, input=b"", capture_output=True, check=False, env=_environment())
        except FileNotFoundError:
            raise NO_GIT from None
        if result.returncode == NOT_FOUND:
            raise NO_GIT
        errors = result.stderr.decode(errors="replace").strip() or "git failed."
        if result.returncode < 0 or "out of memory" in errors.lower():
            message = f"git {arguments[0]} reached its limit of memory or processor time."
            raise BenchError("git-limit", message, hint="The commit has far too many files.")
        if result.returncode not in statuses:
            self._explain(errors)
            where = f"git {arguments[0]} in {self.folder}"
            raise refusal or BenchError("git-failed", errors.splitlines()[-1], where)
        return result.stdout

    def _explain(self, errors: str) -> None:
        """Raises the error of a clone that git distrusts, or that lacks what was asked for."""
        if "dubious ownership" in errors:
            message = "git reads no repository whose folder belongs to another owner."
            hint = f"Run: git config --global --add safe.directory {self.folder.resolve()}"
            raise BenchError("distrusted-clone", message, str(self.folder), hint)
        is_lacking = any(text in errors for text in LACKING)
        if is_lacking and self.run("config", "--get-regexp", PARTIAL, statuses=(0, 1)):
            message = "This is a partial clone (--filter). It lacks file contents that the command needs."
            hint = "Run: git sparse-checkout add submissions/NAME; for all: git fetch --refetch --no-filter"
            raise BenchError("partial-clone", message, str(self.folder), hint)

    @cached_property
    def top(self) -> Path:
        """The top folder of the work tree. Raises ``BenchError`` if the folder is in none."""
        hint = "Run the command in a clone of the repository."
        refusal = BenchError("no-repository", "It is not a git work tree.", str(self.folder), hint)
        folder = self.run("rev-parse", "--show-toplevel", refusal=refusal)
        return Path(os.fsdecode(folder.removesuffix(b"\n")))

    def commit(self, name: str) -> str:
        """The id of the commit that a branch, tag or id names. Raises ``BenchError`` if there is none."""
        hint = "Name a branch, a tag or a commit of this clone; `git fetch` may be needed."
        refusal = BenchError("unknown-commit", f"There is no commit {name!r}.", hint=hint)
        words = ("--verify", "--quiet", "--end-of-options", f"{name}^{{commit}}")
        return self.run("rev-parse", *words, refusal=refusal).decode().strip()

    def tree(self, commit: str, *folders: str, sizes: bool = False) -> tuple[TreeEntry, ...]:
        """All files of a commit below folders (the whole tree by default), with full paths.

        Sizes need the contents of the files, which a clone may lack; without them they are None.
        """
        paths = (f"{folder}/" for folder in folders)
        output = self.run("ls-tree", "-z", "--full-tree", "-r", *["-l"] * sizes, commit, *paths)
        found = []
        for line in filter(None, output.split(b"\0")):
            meta, _, path = line.partition(b"\t")
            mode, _, object_id, *size = meta.decode().split()
            if size == ["BAD"]:  # newer versions of git go on; older ones fail
                self._explain("missing")
            known = int(size[0]) if size and size[0].isdigit() else None
            found.append(TreeEntry(mode, object_id, known, os.fsdecode(path)))
        return tuple(found)

    def blobs(self, object_ids: Iterable[str]) -> Iterator[bytes]:
        """The contents of files by object id, in that order. Raises ``BenchError`` if one is not a file."""
        command, pipe, none = self._command("cat-file", "--batch"), subprocess.PIPE, subprocess.DEVNULL
        with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=none, env=_environment()) as process:
            requests, answers = process.stdin, process.stdout
            assert requests is not None
            assert answers is not None
            for object_id in object_ids:
                requests.write(f"{object_id}\n".encode())
                requests.flush()
                header = answers.readline().split()
                if not header or header[1:] == [b"missing"]:  # git ends if it may not fetch
                    self._explain("missing")
                if len(header) != 3 or header[1] != b"blob":
                    message = f"The object {object_id} is not a file."
                    raise BenchError("git-failed", message, str(self.folder))
                content = answers.read(int(header[2]) + 1)
                yield content[:-1]

    def file(self, commit: str, path: str) -> bytes | None:
        """The content of a file of a commit; None without such a file."""
        listed = self.run("ls-tree", "-z", "--full-tree", commit, path)
        mode, _, object_id = listed.partition(b"\t")[0].decode().split() or ("", "", "")
        return next(self.blobs([object_id]), None) if mode.startswith("100") else None

    def require_history(self) -> None:
        """Raises ``BenchError`` if the clone lacks older commits."""
        if self.run("rev-parse", "--is-shallow-repository") == b"true\n":
            message = "The clone lacks older commits."
            raise BenchError("shallow-clone", message, str(self.folder), "Run: git fetch --unshallow")

    def last_change(self, commit: str, paths: Sequence[str]) -> str:
        """The last commit of the first-parent history that changed one of these paths; empty if none did.

        For a merged pull request it is the merge commit, which its author did not know. Raises ``BenchError``
        if the clone lacks older commits.
        """
        self.require_history()
        specs = [f":(top,literal){path}" for path in paths]
        return self.run("rev-list", "--first-parent", "--max-count=1", commit, "--", *specs).decode().strip()

    def inside(self, folder: Path) -> str:
        """The path of a folder inside the repository."""
        return folder.resolve().relative_to(self.top.resolve()).as_posix()

    def fixed(self, folder: Path, names: Sequence[str]) -> str:
        """The commit that fixed some files of a folder: the :meth:`last_change` of HEAD that changed one.

        Raises ``BenchError`` if one is not committed as it is, or the clone lacks older commits.
        """
        inside = self.inside(folder)
        paths = [f"{inside}/{name}".removeprefix("./") for name in names]
        specs = (f":(top,literal){path}" for path in paths)
        changed = self.run("status", "--porcelain", "--untracked-files=all", "--", *specs)
        commit = "" if changed else self.last_change(self.commit("HEAD"), paths)
        if not commit:
            where = os.fsdecode(changed.partition(b"\n")[0][3:]) or inside
            message = "It is not committed in its present form, so no commit determines its seeds."
            raise BenchError("not-committed", message, where, "Commit it, or pass public seeds to verify.")
        return commit

    def code(self, commit: str, submission: str) -> tuple[object, ...]:
        """What makes a version of the code of a submission, by its path in the repository: the files of
        agent/, and the entry in the manifest. It is empty without files.
        """
        files, entry = self.tree(commit, f"{submission}/{layout.AGENT}"), ""
        data = self.file(commit, f"{submission}/{layout.MANIFEST}") if files else None
        if data and len(data) <= layout.max_bytes(layout.MANIFEST):
            with contextlib.suppress(ValueError, KeyError, TypeError):  # a problem of the submission
                entry = str(manifest.parse(data)["agent"]["entry"])
        return (files, entry) if files else ()

    def code_commit(self, commit: str, submission: str) -> str:
        """The commit of the first-parent history that brought the code of a submission as it is; empty
        without code. (What else changes in the manifest makes no version.)
        """
        code, found = self.code(commit, submission), ""
        last = self.last_change(commit, [f"{submission}/{layout.AGENT}"]) if code else ""
        spec = f":(top,literal){submission}/{layout.MANIFEST}"
        edits = self.run("rev-list", "--first-parent", f"{last}..{commit}", "--", spec) if last else b""
        for each in (*edits.decode().split(), last):
            if not each or self.code(each, submission) != code:
                break
            found = each
        return found

    def not_merged(self, commit: str) -> Problem | None:
        """The problem of seeds from a commit that is no merge: its author may have known its id before."""
        if self.run("rev-list", "--no-walk", "--merges", commit):
            return None
        message = "It is no merge but a fast-forward or a direct commit: its author may have known the seeds."
        hint = "Verify with --seeds HEX, or train with --value HEX: a public value that is newer than it."
        return Problem("no-merge", f"commit {commit[:12]}", message, hint)


def _environment() -> dict[str, str]:
    return {name: value for name, value in os.environ.items() if name not in REDIRECTIONS} | ENVIRONMENT
