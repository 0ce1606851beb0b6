"""``gym-extensions site``: scores submissions and builds the pages of the leaderboard."""

import argparse
import subprocess
import sys
from contextlib import suppress
from functools import partial
from importlib.metadata import version
from io import TextIOWrapper
from pathlib import Path
from urllib.parse import urlsplit

from gym_extensions.errors import BenchError, reports_mistakes, working
from gym_extensions.site import SITE_ASSETS
from gym_extensions.site.paths import Source


def parser() -> argparse.ArgumentParser:
    """The command's options."""
    options = argparse.ArgumentParser(
        prog="gym-extensions site",
        description="Score submissions and build the pages of the leaderboard.",
        epilog="Exit status: 0 success, 1 built but a submission was refused or a file of it cannot be read, "
        "2 usage error.",
    )
    add = options.add_argument
    submissions = "submission folders, or folders that contain them (default: submissions/)"
    mujoco = (
        f"MuJoCo for the page Play, as `make site-assets` fetches it (default: {SITE_ASSETS}, if it exists)"
    )
    repository = "https address of the public repository, to which pages link"
    url = "https address at which the pages will be: previews of links, the feed and the page 404 name it"
    docs = "link to the documentation, which `make docsite` builds into OUT/docs"
    add("submissions", nargs="*", type=Path, default=[Path("submissions")], help=submissions)
    add("--out", type=Path, default=Path("_site"), help="output folder (default: _site)")
    add("--mujoco", type=Path, default=SITE_ASSETS, metavar="FOLDER", help=mujoco)
    add("--repository", type=address, metavar="ADDRESS", help=repository)
    add("--url", type=partial(address, path=False), metavar="ADDRESS", help=url)
    add("--docs", action="store_true", help=docs)
    groups = "also accept the custom group in this TOML file; may be repeated"
    add("--groups", action="append", default=[], metavar="FILE", help=groups)
    add("--references", type=Path, metavar="FILE", help="references of the custom groups' tasks")
    return options


def address(text: str, path: bool = True) -> str:
    """An address without a slash at the end; that of a repository has a path."""
    with suppress(ValueError):  # of an address of IPv6 that does not end
        parts = urlsplit(text)
        if parts.scheme in {"http", "https"} and parts.hostname and (not path or parts.path.strip("/")):
            return text.rstrip("/")
    raise argparse.ArgumentTypeError(f"{text!r} is no address such as https://example.org/owner/name")


def source_of(folder: Path, repository: str, url: str) -> Source:
    """The last commit of a folder and its date. Both are empty where git knows neither."""

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(folder), *arguments, "--", "."]
        try:
            return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
        except (OSError, subprocess.CalledProcessError):  # no git, no folder or no repository
            return ""

    commit, _, date = git("log", "-1", "--format=%H %cs").partition(" ")
    is_changed = bool(commit and git("status", "--porcelain"))
    return Source(repository, commit, date, is_changed, version("gym-extensions"), url)


def is_empty(folder: Path) -> bool:
    """Whether a folder has only hidden files and a README, so that no submission is meant."""
    try:
        names = [child.name for child in folder.iterdir()]
    except OSError:  # not a folder, or not readable: the scorer reports it
        return False
    return all(name.startswith(".") or name == "README.md" for name in names)


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Builds the site. Prints the problems of refused submissions and the path of the index."""
    options = parser().parse_args(argv)
    # They load pandas and scipy, for which --help and mistakes do not wait.
    from gym_extensions.scoring.output.screen import console, show_line
    from gym_extensions.scoring.pipeline import find_submissions, make_scorer, scorecards
    from gym_extensions.site.build import build_site
    from gym_extensions.site.pages import PAGES
    from gym_extensions.site.pages.page import Render
    from gym_extensions.site.play.assets import load
    from gym_extensions.submissions import diagnostics, landscapes, poses
    from gym_extensions.submissions.problem import count

    empty = [folder for folder in options.submissions if is_empty(folder)]
    folders = find_submissions([folder for folder in options.submissions if folder not in empty])
    scorer = make_scorer(options.groups, options.references)
    whole, broken = dict[str, Path](), list[str]()  # folders whose further files can be drawn
    for folder in folders:
        try:
            for read in (poses.load_submission, landscapes.landscapes_of, diagnostics.changes):
                read(folder)
            whole[folder.name] = folder
        except BenchError as error:
            broken.append(str(error))
    simulator = load(options.mujoco)
    source = source_of(options.submissions[0], options.repository or "", options.url or "")
    render = Render(scorer.references, PAGES, whole, simulator, source, options.docs)
    cards = scorecards(folders, scorer)  # starts processes: after what may fail, before a thread draws
    with working(f"building the pages of {count(len(folders), 'submission')}"):
        leaderboard = build_site(cards, render, options.out)
    if isinstance(sys.stdout, TextIOWrapper):  # a narrow encoding never stops the output
        sys.stdout.reconfigure(errors="backslashreplace")
    for folder in empty:
        print(f"{folder} contains no submissions.")
    refused = [card for card in leaderboard.submissions if card.problems]
    if refused:
        print("Refused (not on a board until all problems are fixed):")
    for card in refused:
        show_line(console(), card)
    for why in broken:
        print(f"Shown without drawings and policies, because of {why}")
    absent = [] if options.repository else ["repository (--repository ADDRESS)"]
    if absent := absent + ([] if options.url else ["address of their own (--url ADDRESS)"]):
        print(f"These pages name no {' and no '.join(absent)}.")
    print(options.out / "index.html")
    return 1 if refused or broken else 0
