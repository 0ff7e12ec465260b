"""Tables as TOML: short lists on one line, and the same when they are read again."""

from __future__ import annotations

import tomllib

from nospill.core.toml_text import toml_text

TABLE = {
    "at": ["-92 mm", "-69 mm"],
    "long": list(range(100)),
    "odd": ["a]", "b, c"],
    "path": {"start": [0.6, -0.4, 0.5], "points": [[0.0, 1.0], [1.0, 0.0]]},
    "leg": [{"unload": ["far"], "none": []}],
}


def test_short_lists_stand_on_one_line_and_others_are_the_same() -> None:
    text = toml_text(TABLE)
    assert tomllib.loads(text) == TABLE
    for line in ('at = ["-92 mm", "-69 mm"]', "start = [0.6, -0.4, 0.5]", "    [0.0, 1.0],", 'unload = ["far"]'):
        assert f"\n{line}\n" in f"\n{text}"
    assert max(map(len, text.splitlines())) < 100


def test_a_text_that_looks_like_a_list_stays_as_it_is() -> None:
    table = TABLE | {"said": "x = [\n    1,\n]\n"}
    assert tomllib.loads(toml_text(table)) == table
