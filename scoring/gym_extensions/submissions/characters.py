"""Characters that cannot be seen, cover others or look like others, in the texts of strangers."""

import unicodedata

INVISIBLE = ("Cc", "Cf", "Cs", "Zl", "Zp")
"""Unicode categories of control, format and surrogate characters, and of line and paragraph separators."""
JOINERS = frozenset("\u180b\u180c\u180d\u180f\u200c\u200d\ufe0e\ufe0f")
"""Characters without a glyph that Mongolian, Persian, Hindi and emoji need."""
IGNORABLE = (range(0x180B, 0x1810), range(0xFE00, 0xFE10), range(0xFFF0, 0xFFF9), range(0xE0000, 0xE1000))
BLANK = frozenset("\u034f\u115f\u1160\u17b4\u17b5\u2065\u2800\u3164\uffa0").union(
    chr(code) for codes in IGNORABLE for code in codes
)
"""Characters without a glyph, with which one text can look like another, or hide a third one."""
SCRIPTS = (
    *("LATIN", "CYRILLIC", "GREEK", "ARMENIAN", "GEORGIAN", "HEBREW", "ARABIC", "THAANA", "ETHIOPIC"),
    *("DEVANAGARI", "BENGALI", "GURMUKHI", "GUJARATI", "ORIYA", "TAMIL", "TELUGU", "KANNADA", "MALAYALAM"),
    *("SINHALA", "THAI", "LAO", "TIBETAN", "MYANMAR", "KHMER", "MONGOLIAN"),
)
"""Scripts of which a word may have one, as Unicode's names of letters begin. Some others, such as Lisu and
Cherokee, have letters that look like Latin ones."""
BESIDE = frozenset(
    ("CJK", "IDEOGRAPHIC", "HIRAGANA", "KATAKANA", "KATAKANA-HIRAGANA", "BOPOMOFO", "HANGUL", "MODIFIER")
)
"""Beginnings of the names of letters that may stand in a word with any of them."""
LOOKALIKES = str.maketrans(
    "АВЕЅІЈКМНОРСТУХаеѕіјорсухһԁԛԝΑΒΕΖΗΙΚΜΝΟΡΤΥΧαονριυχօսհոցı",
    "ABESIJKMHOPCTYXaesijopcyxhdqwABEZHIKMNOPTYXaovpiuxouhngi",
)
"""Some letters that look like those of ASCII, from Unicode's table of confusables
(https://www.unicode.org/reports/tr39/#Confusable_Detection)."""
MAX_MARKS = 5
"""Most combining marks in a row: more leave the line and cover other texts."""


def first_invisible(text: str) -> str:
    """The first invisible character of a text, or nothing. A joiner may stand beside one beyond ASCII."""
    if text.isascii() and text.isprintable():
        return ""
    for before, char, after in zip(f" {text}", text, f"{text[1:]} ", strict=False):
        is_hidden = char in BLANK or unicodedata.category(char) in INVISIBLE
        if is_hidden and (char not in JOINERS or "".join({before, after} - JOINERS).isascii()):
            return char
    return ""


def has_stacked_marks(text: str) -> bool:
    """Whether combining marks are at the start of a text, or more than ``MAX_MARKS`` in a row."""
    if text.isascii():
        return False
    in_a_row = MAX_MARKS
    for char in text:
        in_a_row = in_a_row + 1 if unicodedata.category(char)[0] == "M" else 0
        if in_a_row > MAX_MARKS:
            return True
    return False


def is_visible(text: str) -> bool:
    """Whether a text has a visible character other than a mark."""
    kinds = [unicodedata.category(char) for char in text if char not in BLANK]
    return any(kind[0] not in "CMZ" or kind == "Cn" for kind in kinds)  # "Cn": newer than Python's Unicode


def scripts_of(word: str) -> set[str]:
    """The scripts of the letters of a word, named as in ``SCRIPTS``, less those that may stand beside any."""
    return {unicodedata.name(char, "").split(" ")[0] for char in word} - BESIDE


def skeleton(text: str) -> str:
    """What a text looks like, in any letter case: texts of equal skeletons may be taken for each other.

    >>> skeleton("TRP0 I") == skeleton("trpo l")
    True
    """
    letters = unicodedata.normalize("NFKD", text).translate(LOOKALIKES).casefold()
    letters = letters.translate(str.maketrans("i1|0", "lllo")).replace("rn", "m")
    # A text of symbols has no letters that could look alike.
    return "".join(char for char in letters if char.isalnum()) or unicodedata.normalize("NFKC", text)
