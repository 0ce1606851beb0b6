"""Every rule about the documents of runs reports its mistake."""

from typing import Any

from ..examples import DOCUMENT, HALF, LOG, POLICIES, Table, document, edit, put, remove

CURVE = {"stage": 1, "task": HALF, "steps": [100, 200], "returns": [1.0, 2.0]}
POINTER = b"version https://git-lfs.github.com/spec/v1\n"


def curve(**changes: object) -> Any:
    return document(curves=[CURVE | changes])


def key(name: str) -> str:
    return f"{DOCUMENT}, {name}"


CURVES, EVALUATIONS = (key(f"{name} of stage 1, {HALF}") for name in ("curves", "evaluations"))
PRINTS = key("fingerprints")

EXAMPLES: Table = {
    "malformed-document": [
        ("a key with a typing error", document(comand="x"), DOCUMENT, "`comand`"),
        ("not JSON", put(DOCUMENT, b"{"), DOCUMENT, "truncated"),
        ("text for a number", document(steps="many"), DOCUMENT, "$.steps"),
        ("a NaN", edit('"curves": [', '"curves": [NaN', DOCUMENT), DOCUMENT, "JSON"),
        ("steps without returns", curve(returns=[1.0]), DOCUMENT, "2 steps and 1 returns"),
    ],
    "misplaced-document": [
        ("another run's", document(run=1), key("run"), "is 1; the file is that of 0"),
        ("another protocol's", document(protocol="joint"), key("protocol"), "'joint'"),
        ("another group's", document(group="pusher-v0"), key("group"), "'pusher-v0'"),
    ],
    "wrong-order": [
        ("that of a balanced run", document(order=[HALF]), key("order"), "sequential run 0 states no order"),
    ],
    "different-log": [("a changed log", edit("false", "true"), LOG, "the document states")],
    "different-policies": [
        ("lost", remove(POLICIES), key("policies"), "write null in the key policies"),
        ("without Git LFS", put(POLICIES, POINTER), POLICIES, "git lfs pull", ("malformed-policies",)),
        ("hidden", document(policies=None), POLICIES, "no policies"),
    ],
    "foreign-version": [
        ("another simulator", document(versions__mujoco="3.0"), key("versions.mujoco"), "'3.0'"),
    ],
    "repeated-package": [("numpy", document(packages={"numpy": "1"}), key("packages"), "'numpy'")],
    "control-character-in-document": [
        ("an escape sequence", document(command="train \x1b[31m"), key("command"), "control or invisible"),
        (
            *("a fingerprint", document(**{f"fingerprints__{HALF}": "a\x1b"}), key(f"fingerprints, {HALF}")),
            *("control", ("foreign-fingerprint",)),
        ),
    ],
    "foreign-fingerprint": [
        ("another task under the name", document(**{f"fingerprints__{HALF}": "0" * 16}), PRINTS, HALF),
        ("none", document(fingerprints={}), PRINTS, "missing", (), 5),
    ],
    "over-budget": [
        ("steps of the run", document(steps=10**9), key("steps"), "'smoke'"),
        ("a curve", curve(steps=[10, 10**8]), CURVES, "Step 100000000 exceeds"),
    ],
    "foreign-curve": [
        ("of no task", curve(task="x"), key("curves of stage 1, x"), "'x' is not a task"),
        ("another task's stage", curve(stage=2), key(f"curves of stage 2, {HALF}"), "trains"),
        ("before training", curve(stage=0), key(f"curves of stage 0, {HALF}"), "no training"),
        ("twice", document(curves=[CURVE, CURVE]), CURVES, "two of them"),
    ],
    "curve-order": [("a step twice", curve(steps=[5, 5]), CURVES, "do not increase")],
    "impossible-curve-return": [("scaled", curve(returns=[1.0, 1e9]), CURVES, "1000000000.0 is impossible")],
    "impossible-evaluation": [
        (
            *("at the end", document(evaluations=[CURVE | {"episodes": 3, "steps": [1, 10**4]}])),
            *(EVALUATIONS, "before the end"),
        ),
    ],
}
