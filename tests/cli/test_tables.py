"""What a terminal shows: whole names at any width, colour for a verdict there only, breaks at words."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from nospill.cli import tables
from nospill.cli.listings import examples, robots
from nospill.cli.tables import print_lines, print_table, print_verdict
from nospill.robots.description.catalog import robot_table
from nospill.scenario.examples import EXAMPLES


@pytest.fixture(params=[80, 60])
def width(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """A terminal as wide as this."""
    monkeypatch.setattr(tables, "terminal_width", lambda _: request.param)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    yield request.param


def lines_of(text: str) -> list[str]:
    return [line.rstrip() for line in text.splitlines()]


def test_names_are_whole_and_lines_fit(width: int, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    robots()
    examples()
    out = capsys.readouterr().out
    assert "…" not in out
    assert max(map(len, lines_of(out))) <= width
    for name in (*EXAMPLES, *(str(entry["name"]) for entry in robot_table())):
        assert name in out


def test_no_row_takes_two_lines_and_numbers_end_below_each_other(width: int, capsys) -> None:
    rows = [
        ("approach recorded acceleration", "shoulder_lift", "99.9 %", 12.3456, None),
        ("tip", "c1", "5.0 %", 1.0, 2.0),
    ]
    print_table(("constraint", "of", "use", "value", "more"), rows, right=("use",), drop=("more",))
    head, rule, first, second = lines_of(capsys.readouterr().out)
    assert set(rule) == {"\u2500"}
    assert ("more" in head) == (width == 80)
    for shown in ("99.9 %", "12.3"):
        other = {"99.9 %": "5.0 %", "12.3": " 1"}[shown]
        assert first.index(shown) + len(shown) == second.index(other) + len(other)


def test_too_narrow_a_terminal_cuts_nothing(monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.setattr(tables, "terminal_width", lambda _: 20)
    print_table(("constraint", "of"), [("recorded acceleration", "shoulder_lift")])
    assert "recorded acceleration" in capsys.readouterr().out


@pytest.mark.parametrize("no_colour", [True, False])
def test_verdict_in_colour_on_a_terminal_unless_it_is_not_wanted(
    width: int, no_colour: bool, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    if no_colour:
        monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("FORCE_COLOR", "1")  # what is written to here is no terminal
    print_verdict("certified: all", True)
    print_verdict("not certified: 1", False)
    out = capsys.readouterr().out
    assert ("\x1b[1;32mcertified: all" in out) == ("\x1b[1;31mnot certified: 1" in out) == (not no_colour)


def test_without_a_terminal_lines_are_plain(capsys) -> None:
    long = "joint " * 60
    print_verdict("certified: all", True)
    print_lines(long)
    assert capsys.readouterr().out == f"certified: all\n{long}\n"


def test_sentences_break_at_words(width: int, capsys) -> None:
    print_lines("tea.toml: " + "base_position " * 12)
    lines = lines_of(capsys.readouterr().out)
    assert len(lines) > 1 and max(map(len, lines)) <= width
    assert all(line.endswith("base_position") for line in lines)
