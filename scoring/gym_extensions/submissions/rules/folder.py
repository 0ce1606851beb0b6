"""Rules about the folder: which files a submission may contain, their names and sizes, and which runs."""

import re
from collections.abc import Iterator

from gym_extensions.catalog.protocol import FIRST_REFERENCE_RUN, PROTOCOLS
from gym_extensions.errors import did_you_mean
from gym_extensions.submissions import layout
from gym_extensions.submissions.layout import MANIFEST, Folder, run_file
from gym_extensions.submissions.problem import RULES, Finding, Rule, quote, rule

READABLE = "Add read permission, or copy it again."
IRREGULAR = {
    "link": ("It is a symbolic link.", "Replace it by the file or folder itself."),
    "device": ("It is neither a file nor a folder.", "Replace it by the file itself."),
    "unreadable": ("The folder cannot be read.", READABLE),
    "unreadable file": ("The file cannot be read.", READABLE),
}
"""Message and hint by kind of item."""
RENAME = "Remove it, or rename it as described in docs/rollout-log.md."
OTHER_FOLDERS = (layout.AGENT, *layout.WRITTEN)
"""The folders that are no groups."""
GROUP = rf"(?!(?:{'|'.join(OTHER_FOLDERS)})/)[^/]+/(?:{'|'.join(PROTOCOLS)})"
TRAINED = layout.TRAINED_VERSION.pattern
DOCUMENTS = "|".join((layout.POSES, layout.LANDSCAPES, layout.DIAGNOSTICS))
WRITTEN = rf"(?:{DOCUMENTS})/[A-Za-z0-9][A-Za-z0-9._-]{{0,99}}\.json|{TRAINED}\.toml"
CODE = rf"{layout.AGENT}/[A-Za-z_][A-Za-z0-9_]{{0,63}}\.py"
TOP = "|".join(map(re.escape, (MANIFEST, layout.README, layout.REVIEW)))
EXPECTED = {
    "folder": re.compile(rf"[^/]+|{GROUP}|{TRAINED}"),
    "file": re.compile(rf"{TOP}|{CODE}|{WRITTEN}|{GROUP}/{layout.RUN_FILE.pattern}"),
}
"""The paths of a submission by kind of item; unknown groups are a rule of their own."""


@rule("folder")
def not_a_submission(folder: Folder) -> Iterator[Finding]:
    """A submission is a folder that contains submission.toml."""
    kinds = {item.path: item.kind for item in folder.items}
    root = kinds.get(layout.ROOT)
    if root in ("missing", "no folder"):
        problem = "does not exist" if root == "missing" else "is not a folder"
        yield Finding(folder.name, f"'{folder.name}' {problem}.", f"Name a folder that contains {MANIFEST}.")
    elif root is None and kinds.get(MANIFEST, "folder") == "folder":  # not_a_regular_file reports other roots
        hint = f"Write {MANIFEST} as described in docs/rollout-log.md, or name the folder that contains it."
        if list(kinds) == [layout.PROGRESS]:
            hint = "It contains only unfinished runs: repeat the command that trains them."
        yield Finding(folder.name, f"The folder contains no {MANIFEST}.", hint)


@rule("folder")
def folder_name(folder: Folder) -> Iterator[Finding]:
    """The folder's name has 1 to 64 letters, digits, dots, dashes and underscores and starts with a letter or
    digit, because it becomes part of a URL. No system reserves it (CON, NUL, …), and it does not end in a
    dot."""
    if not layout.NAME.fullmatch(folder.name) or layout.is_reserved(folder.name):
        yield Finding(folder.name, f"The folder's name is '{folder.name}'.", layout.NAME_HINT)


@rule("folder")
def not_a_regular_file(folder: Folder) -> Iterator[Finding]:
    """A submission contains only folders and regular files: no symbolic links, no devices."""
    for item in folder.items:
        if item.kind in IRREGULAR:
            path = folder.name if item.path == layout.ROOT else item.path
            yield Finding(path, *IRREGULAR[item.kind])


@rule("folder")
def unknown_group(folder: Folder) -> Iterator[Finding]:
    """Each folder in a submission is named after a published group, without its version.
    (`score --groups` adds custom groups.)"""
    for item in folder.items:
        is_top = item.kind == "folder" and "/" not in item.path
        if is_top and item.path not in (*folder.groups, *OTHER_FOLDERS):
            closest = did_you_mean(item.path, folder.groups)
            custom = "For a custom group, pass its TOML file: --groups FILE, in Python groups=[FILE]."
            hint = f"{closest} {custom}".lstrip()
            yield Finding(item.path, f"Unknown group '{item.path}'.", hint)


@rule("folder")
def unexpected_name(folder: Folder) -> Iterator[Finding]:
    """A submission contains only the files and folders that docs/rollout-log.md lists."""
    for item in folder.items:
        parts = item.path.split("/")
        is_known = parts[0] in (*folder.groups, *OTHER_FOLDERS) or len(parts) == 1
        if not is_known:
            continue  # unknown_group reports it
        if item.kind not in EXPECTED or EXPECTED[item.kind].fullmatch(item.path):
            continue
        near = {("folder", 2): PROTOCOLS, ("file", 1): (MANIFEST, layout.README)}
        closest = did_you_mean(parts[-1], near.get((item.kind, len(parts)), ()))
        other = "Remove it." if item.kind == "folder" else RENAME
        yield Finding(item.path, f"Unexpected {item.kind}.", closest if closest.startswith("Did") else other)


@rule("folder")
def no_runs(folder: Folder) -> Iterator[Finding]:
    """Each group folder contains at least one run, in a folder of a protocol."""
    with_runs = {group for group, _ in folder.runs}
    for item in folder.items:
        if item.kind == "folder" and item.path in folder.groups and item.path not in with_runs:
            hint = "Add the files of its runs, or remove the folder."
            yield Finding(item.path, "The group folder contains no run.", hint)


@rule("folder")
def missing_file(folder: Folder) -> Iterator[Finding]:
    """Every run has a log (run3.csv) and a document (run3.json)."""
    paths = {item.path for item in folder.items}
    for (group, protocol), runs in folder.runs.items():
        for run, suffixes in runs.items():
            for path in (run_file(group, protocol, run, suffix) for suffix in (layout.LOG, layout.DOCUMENT)):
                if path not in paths:
                    others = ", ".join(run_file(group, protocol, run, other) for other in sorted(suffixes))
                    hint = "Add it, or remove all files of the run."
                    yield Finding(path, f"The file is missing; the run has {others}.", hint)


@rule("folder")
def gaps_in_runs(folder: Folder) -> Iterator[Finding]:
    """The runs of a group and protocol are numbered from 0, at most to 99. Those after a gap are not scored
    until the missing ones are there, so that no runs can be selected by their results. (Seeds from 1000 are
    reserved for the reference agents.)"""
    for (group, protocol), found in folder.runs.items():
        runs, where = list(found), f"{group}/{protocol}"
        if runs[-1] >= layout.MAX_RUNS:
            hint = f"Submit the runs 0 to {layout.MAX_RUNS - 1}."
            if runs[-1] >= FIRST_REFERENCE_RUN:
                hint = f"Train with seeds from 0; those from {FIRST_REFERENCE_RUN} are reserved."
            yield Finding(where, f"There is a run {runs[-1]}; the last is {layout.MAX_RUNS - 1}.", hint)
        elif runs[0] != 0:
            hint = "Train run 0; no run may be left out."
            yield Finding(where, f"The runs are {quote(runs)}; run 0 is missing.", hint)


@rule("folder")
def too_large(folder: Folder) -> Iterator[Finding]:
    """A submission keeps to the limits on the size of a file, the total size and the number of files."""
    for item in folder.files.values():
        limit = layout.max_bytes(item.path)
        if item.size > limit:
            message = f"The file has {item.size} bytes; the limit is {limit}."
            yield Finding(item.path, message, "Leave out everything that the format does not need.")
    if not folder.is_within_limits:
        count, total = len(folder.files), sum(item.size for item in folder.files.values())
        message = f"The submission has {count} files and {total} bytes; the limits are {layout.LIMITS}."
        hint = "Submit fewer runs, or let the policies lie elsewhere (docs/rollout-log.md)."
        yield Finding(folder.name, message, hint)


BROKEN_FILES = {
    "unreadable-file": ("Every file of a submission can be read.", READABLE),
    "malformed-toml": (
        "submission.toml is TOML in UTF-8, with at most 20,000 characters in a line.",
        "Correct the syntax; the format is described at https://toml.io.",
    ),
    "malformed-document": (
        "The document of a run is JSON with the keys that docs/rollout-log.md lists, and no others.",
        "Restore the file; gym_extensions.submissions.run.write_run writes it.",
    ),
    "malformed-log": (
        "The log of a run is a CSV file with the header "
        "stage,task,episode,seed,length,return,terminated,success and at least one row; cells have letters, "
        r"digits and . / _ + - only, and are of their column's kind; lines end with \n. A file that breaks "
        "this rule is reported once, with its first wrong line.",
        "Restore the file; gym_extensions.submissions.log.write_log writes it.",
    ),
    "malformed-review": (
        "review.toml, which the base branch writes, has the tables of gym_extensions.submissions.review.",
        "Restore the file: gym-extensions verify and maintain decide write it, nobody else.",
    ),
    "malformed-training": (
        "The record of a training (trained/1.toml), which the base branch writes, has the tables of "
        "gym_extensions.submissions.review.",
        "Restore the file: gym-extensions maintain train-here writes it, nobody else.",
    ),
    "malformed-policies": (
        "The policies of a run are an .npz file as numpy writes it, without pickles, of at most 64 MiB and "
        "unpacked 256 MiB, or an ONNX file of at most 64 MiB per stage.",
        "Restore the files of the run, which are written together.",
    ),
}
"""Text and hint of the rules about files that cannot be read, by name."""
for _name, (_text, _) in BROKEN_FILES.items():
    RULES[_name] = Rule(_name, "file", _text)
