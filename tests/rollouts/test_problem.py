"""Problems: how values are quoted, and how many problems are listed."""

from __future__ import annotations

from gym_extensions.rollouts.problem import Problem, escape, quote, summarize


def problem(rule: str, where: str) -> Problem:
    return Problem(rule, where, "It is wrong.", "Mend it.")


def test_unprintable_characters_are_escaped() -> None:
    assert escape("plain: ü 強") == "plain: ü 強"
    assert escape("a\n\x1b[31m\u202e\udcff") == "a\\n\\x1b[31m\\u202e\\udcff"


def test_a_problem_is_printable() -> None:
    escaped = Problem("rule", "a\nb", "\x1b[31m", "\u202e")
    assert (escaped.where, escaped.message, escaped.hint) == ("a\\nb", "\\x1b[31m", "\\u202e")


def test_a_quoted_value_has_at_most_80_characters() -> None:
    assert quote("short") == "'short'"
    assert quote("x" * 10**6) == f"'{'x' * 79}…"
    assert quote([1] * 1000) == f"[{'1, ' * 26}1…"
    assert quote(10**6000) == "An integer with too many digits to print"


def test_up_to_twenty_problems_per_rule_are_listed_in_order() -> None:
    problems = [problem(rule, str(number)) for number in range(20) for rule in "ab"]
    assert summarize(problems, "entry") == tuple(problems)


def test_further_problems_are_counted_per_rule_after_the_listed_ones() -> None:
    problems = [
        *(problem("a", str(number)) for number in range(22)),
        *(problem("b", str(number)) for number in range(21)),
        problem("c", "0"),
    ]
    assert summarize(problems, "entry") == (
        *problems[:20],
        *problems[22:42],
        problems[43],
        Problem("a", "entry", "2 more problems of this rule.", "Mend it."),
        Problem("b", "entry", "1 more problem of this rule.", "Mend it."),
    )
