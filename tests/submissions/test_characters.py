"""Characters that cannot be seen, and those that look like others."""

import pytest

from gym_extensions.submissions.characters import first_invisible, skeleton


@pytest.mark.parametrize("text", ["می\u200cخواهم", "क\u094d\u200dष", "🏳\ufe0f\u200d🌈", "1\ufe0f\u20e3"])
def test_joiners_stand_where_scripts_and_emoji_need_them(text: str) -> None:
    assert first_invisible(text) == ""


def test_texts_that_look_alike_have_one_skeleton() -> None:
    same = ["TRPO", "trp0", "ТRРО", "ΤRΡΟ", "T R P O"]
    assert {skeleton(text) for text in same} == {"trpo"}
    assert skeleton("modern l2") == skeleton("modem I2") != skeleton("modern l1")
