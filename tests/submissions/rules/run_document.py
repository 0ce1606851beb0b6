"""Every rule about the documents of runs reports its mistake."""

from typing import Any

from ..examples import DOCUMENT, HALF, LOG, POLICIES, Example, document, edit, put, remove

CURVE = {"stage": 1, "task": HALF, "steps": [100, 200], "returns": [1.0, 2.0]}
EVALUATION = CURVE | {"episodes": 3}


def curve(**changes: object) -> Any:
    return document(curves=[CURVE | changes])


def evaluation(**changes: object) -> Any:
    return document(evaluations=[EVALUATION | changes])


def key(name: str) -> str:
    return f"{DOCUMENT}, {name}"


CURVES, EVALUATIONS = (key(f"{name} of stage 1, {HALF}") for name in ("curves", "evaluations"))

EXAMPLES = (
    Example("malformed-document", "a key with a typing error", document(comand="x"), DOCUMENT, "`comand`"),
    Example("malformed-document", "not JSON", put(DOCUMENT, b"{"), DOCUMENT, "truncated"),
    Example("malformed-document", "text for a number", document(steps="many"), DOCUMENT, "$.steps"),
    Example("malformed-document", "a NaN", edit('"curves": [', '"curves": [NaN', DOCUMENT), DOCUMENT, "JSON"),
    Example(
        "malformed-document", "steps without returns", curve(returns=[1.0]), DOCUMENT, "2 steps and 1 returns"
    ),
    Example(
        "misplaced-document", "another run's", document(run=1), key("run"), "is 1; the file is that of 0"
    ),
    Example(
        "misplaced-document", "another group's", document(group="pusher-v0"), key("group"), "'pusher-v0'"
    ),
    Example(
        *("wrong-order", "an ascending run with the order of a balanced one", document(order=[HALF])),
        *(key("order"), "document of sequential run 0 states no order"),
    ),
    Example("different-log", "a changed log", edit("false", "true"), LOG, "the document states"),
    Example(
        "different-policies",
        "the policies are lost",
        remove(POLICIES),
        key("policies"),
        "write null in the key policies",
    ),
    Example(
        "different-policies",
        "a clone without Git LFS",
        lambda folder: (folder / POLICIES).write_text("version https://git-lfs.github.com/spec/v1\n"),
        POLICIES,
        "git lfs pull",
        also=("malformed-policies",),
    ),
    Example(
        "different-policies",
        "policies that the document hides",
        document(policies=None),
        POLICIES,
        "no policies",
    ),
    Example(
        "foreign-version",
        "another simulator",
        document(versions__mujoco="3.0"),
        key("versions.mujoco"),
        "'3.0'",
    ),
    Example("repeated-package", "numpy twice", document(packages={"numpy": "1"}), key("packages"), "'numpy'"),
    Example(
        "control-character-in-document",
        "an escape sequence",
        document(command="train \x1b[31m"),
        key("command"),
        "control or invisible",
    ),
    Example("control-character-in-document", "its donor", document(by="A\x1b"), key("by"), "control"),
    Example(
        "foreign-fingerprint",
        "another task under the name",
        document(**{f"fingerprints__{HALF}": "0" * 16}),
        key("fingerprints"),
        HALF,
    ),
    Example(
        "foreign-fingerprint", "none", document(fingerprints={}), key("fingerprints"), "missing", count=5
    ),
    Example("over-budget", "steps of the run", document(steps=10**9), key("steps"), "'smoke'"),
    Example("over-budget", "a curve", curve(steps=[10, 10**8]), CURVES, "Step 100000000 exceeds"),
    Example("foreign-curve", "of no task", curve(task="x"), key("curves of stage 1, x"), "'x' is not a task"),
    Example(
        "foreign-curve", "another task's stage", curve(stage=2), key(f"curves of stage 2, {HALF}"), "trains"
    ),
    Example(
        "foreign-curve", "before training", curve(stage=0), key(f"curves of stage 0, {HALF}"), "no training"
    ),
    Example("foreign-curve", "twice", document(curves=[CURVE, CURVE]), CURVES, "two of them"),
    Example("curve-order", "a step twice", curve(steps=[5, 5]), CURVES, "do not increase"),
    Example("curve-order", "from 0", evaluation(steps=[0, 5]), EVALUATIONS, "from 1 on"),
    Example(
        "impossible-curve-return", "scaled", curve(returns=[1.0, 1e9]), CURVES, "1000000000.0 is impossible"
    ),
    Example(
        "impossible-evaluation", "too many episodes", evaluation(episodes=21), EVALUATIONS, "21 episodes"
    ),
    Example(
        "impossible-evaluation", "at the end", evaluation(steps=[1, 10**4]), EVALUATIONS, "before the end"
    ),
)
