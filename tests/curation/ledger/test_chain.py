"""The chain of the ledger: what a line holds, what may follow it, and which bytes are refused."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from gym_extensions.curation.ledger.append import Author, append, repeated
from gym_extensions.curation.ledger.chain import FILE, parse, read, states
from gym_extensions.curation.ledger.line import MAX_LINE, START, Event, LedgerLine
from gym_extensions.errors import BenchError

LINE = LedgerLine(
    previous=START,
    date="2026-01-01",
    event="accepted",
    entry="entry",
    reason="A reason.",
    digest="a" * 64,
    level="replayed",
    replayed=75,
    episodes=3500,
    scorer="1.0.0",
    references="b" * 64,
    value="",
    salt="",
)
Edit = Callable[[bytes], bytes]


def line(event: Event = "accepted", **changes: object) -> LedgerLine:
    return replace(LINE, event=event, **changes)  # type: ignore[arg-type]


def chain(*lines: LedgerLine) -> bytes:
    """The bytes of a ledger with these lines, linked."""
    data: list[bytes] = []
    for item in lines:
        previous = hashlib.sha256(data[-1]).hexdigest() if data else START
        data.append(replace(item, previous=previous).encode())
    return b"".join(data)


def refused(data: bytes) -> BenchError:
    with pytest.raises(BenchError) as error:
        parse(data)
    return error.value


def test_a_line_is_one_line_of_ascii_json_with_sorted_keys() -> None:
    text = replace(LINE, reason="Für alle.").encode().decode("ascii")
    assert text.startswith('{"date":"2026-01-01","digest":"aaaa')
    assert '"reason":"F\\u00fcr alle."' in text
    assert text.endswith('"scorer":"1.0.0","value":""}\n')


def test_each_line_holds_the_hash_of_the_line_before_with_its_line_end() -> None:
    first, second = parse(chain(line(), line("challenged")))
    assert (first.previous, second.previous) == ("0" * 64, hashlib.sha256(first.encode()).hexdigest())


@pytest.mark.parametrize(
    ("edit", "code", "where"),
    [
        (lambda data: data.split(b"\n", 1)[1], "ledger-chain", "ledger.jsonl, row 1"),
        (lambda data: data[:-1], "ledger-line", "ledger.jsonl"),
        (lambda data: b"\n" + data, "ledger-line", "ledger.jsonl, row 1"),
        (lambda data: b"\xff\n", "ledger-line", "ledger.jsonl, row 1"),
        (lambda data: b"[" * 8000 + b"\n", "ledger-line", "ledger.jsonl, row 1"),
    ],
)
def test_bytes_that_are_not_lines_of_a_chain_are_refused(edit: Edit, code: str, where: str) -> None:
    error = refused(edit(chain(line(), line("challenged"))))
    assert (error.code, error.where) == (code, where)


@pytest.mark.parametrize(
    ("old", "new", "code", "row"),
    [
        ("A reason.", "B reason.", "ledger-chain", 2),
        ('"replayed":75', '"replayed":76', "ledger-chain", 2),
        ('{"date"', '{ "date"', "ledger-line", 1),
        ('{"date"', '{"date":"2026-01-01","date"', "ledger-line", 1),
        ('"scorer"', '"rank":1,"scorer"', "ledger-line", 1),
        ('"accepted"', '"praised"', "ledger-line", 1),
        ("2026-01-01", "2026-02-30", "ledger-line", 1),
        ('"entry":"entry"', '"entry":"../entry"', "ledger-line", 1),
        ('"replayed":75', '"replayed":3501', "ledger-line", 1),
        ('"replayed":75', '"replayed":0', "ledger-line", 1),
        ("A reason.", "A\\u202ereason.", "ledger-line", 1),
        ('"salt":""', f'"salt":"{"a" * 64}"', "ledger-line", 1),
        ('"salt":""', '"salt":"ABC"', "ledger-salt", 1),
        ('"salt":""', f'"salt":"{"A" * 64}"', "ledger-salt", 1),
    ],
)
def test_an_edited_first_line_is_a_named_problem(old: str, new: str, code: str, row: int) -> None:
    error = refused(chain(line(), line("challenged")).replace(old.encode(), new.encode(), 1))
    assert (error.code, error.where) == (code, f"ledger.jsonl, row {row}")


def test_a_long_line_is_refused_before_it_is_parsed() -> None:
    assert "the limit is 8192" in refused(b"x" * (MAX_LINE + 1) + b"\n").message


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([line("rescored")], "The entry 'entry' is not on the boards, so it cannot be rescored."),
        ([line(), line()], "The entry 'entry' was accepted already."),
        (
            [line(), line("withdrawn"), line("challenged")],
            "The entry 'entry' is not on the boards, so it cannot be challenged.",
        ),
        (
            [line(), line("rescored", digest="c" * 64)],
            "The digest cccccccccccc… is not that of the accepted files of 'entry'.",
        ),
        ([line(), line(entry="Entry")], "The names 'entry' and 'Entry' differ only in case."),
    ],
)
def test_an_event_that_cannot_follow_is_refused(lines: list[LedgerLine], message: str) -> None:
    error = refused(chain(*lines))
    assert (error.code, error.message) == ("ledger-order", message)


def test_dates_do_not_decrease() -> None:
    error = refused(chain(line(), line("challenged", date="2025-12-31")))
    assert (error.code, error.message) == ("ledger-date", "2025-12-31 is before 2026-01-01.")


def test_an_entry_that_left_the_boards_can_be_accepted_with_other_files() -> None:
    state = states(
        parse(chain(line(), line("superseded"), line(digest="c" * 64), line("challenged", digest="c" * 64)))
    )
    assert (state["entry"].active, state["entry"].accepted.digest) == (True, "c" * 64)
    assert not states(parse(chain(line(), line("withdrawn"))))["entry"].active


def test_appending_links_the_lines_and_keeps_the_old_bytes(tmp_path: Path) -> None:
    append(tmp_path, [line()])
    before = (tmp_path / FILE).read_bytes()
    append(tmp_path, [repeated(LINE, "withdrawn", Author("2026-01-02", "Asked for by the author."))])
    assert (tmp_path / FILE).read_bytes().startswith(before)
    assert [item.event for item in read(tmp_path)] == ["accepted", "withdrawn"]


@pytest.mark.parametrize("wrong", [line("rescored", entry="other"), line("challenged", reason="a\nb")])
def test_a_line_that_cannot_follow_leaves_the_file_unchanged(tmp_path: Path, wrong: LedgerLine) -> None:
    append(tmp_path, [line()])
    before = (tmp_path / FILE).read_bytes()
    with pytest.raises(BenchError):
        append(tmp_path, [wrong])
    assert (tmp_path / FILE).read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == [FILE]
