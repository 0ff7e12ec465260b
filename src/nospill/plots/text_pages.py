"""Tables of words and figures: a record that every page of a report reads, and its drawing on sheets of A4."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

from matplotlib.figure import Figure
from matplotlib.font_manager import findfont, get_font

from nospill.plots.style import DARK_RED, INK

PAPER = (8.27, 11.69)
"""in; A4 upright."""

_MARGIN, _LINE, _SIZE = 0.6, 0.145, 7.5
_LETTER = 0.56 * _SIZE / 72
"""in; width that few letters exceed on average."""
_GUTTER = 0.12


@dataclass(frozen=True, slots=True)
class TextTable:
    """A titled table.

    Attributes:
        title: above it.
        columns: names of the columns; empty for a list of (what, value) or of sentences.
        rows: cells as text, all of one length.
        note: a sentence below, or empty.
        failing: indices of rows that say no.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""
    failing: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class _Line:
    """One line on paper: texts and where they begin (in from the left), bold or not, colour, room below (in)."""

    cells: tuple[tuple[float, str], ...]
    bold: bool = False
    color: str = "black"
    size: float = _SIZE
    below: float = _LINE


def text_pages(tables: tuple[TextTable, ...], heading: str) -> list[Figure]:
    """Tables as sheets of A4, as many as they take; to be saved inside `matplotlib.rc_context(LOOK)`.

    Args:
        tables: in order.
        heading: at the head of every sheet.
    """
    pages: list[Figure] = []
    y = 0.0
    for block in (line for table in tables for line in _blocks(table)):
        height = sum(line.below for line in block)
        if not pages or y + height > PAPER[1] - _MARGIN:
            pages.append(Figure(figsize=PAPER))
            _write(pages[-1], _Line(((0.0, printable(heading)),), size=8, color=INK), 0.35)
            y = _MARGIN + 0.15
        for line in block:
            _write(pages[-1], line, y)
            y += line.below
    return pages


def printable(text: str) -> str:
    """Text as the figures' font can print it: on one line, a box for letters that it lacks."""
    letters = _letters()
    return "".join(c if ord(c) in letters else "\u25a1" for c in " ".join(text.split()))


@lru_cache(maxsize=1)
def _letters() -> frozenset[int]:
    return frozenset(get_font(findfont("DejaVu Sans")).get_charmap())


def _blocks(table: TextTable) -> Iterator[list[_Line]]:
    """Lines that stay on one sheet: the title with the first row, the note with the last, other rows by themselves."""
    lefts, letters = _layout(table)
    head = [_Line(((0.0, printable(table.title)),), bold=True, size=10, below=0.22)]
    if any(table.columns):
        head += _row(table.columns, lefts, letters, bold=True)
    tail = [_Line(((0.0, text),), color=INK) for text in textwrap.wrap(printable(table.note), _across())]
    for index, row in enumerate(table.rows):
        failing = index in table.failing
        lines = head + _row(row, lefts, letters, bold=failing, color=DARK_RED if failing else "black")
        yield lines + tail if index == len(table.rows) - 1 else lines
        head = []
    yield [*([] if table.rows else head + tail), _Line((), below=0.2)]


def _row(
    cells: tuple[str, ...], lefts: list[float], letters: list[int], *, bold: bool, color: str = "black"
) -> list[_Line]:
    wrapped = [textwrap.wrap(printable(cell), width) or [""] for cell, width in zip(cells, letters, strict=True)]
    lines = []
    for depth in range(max(len(cell) for cell in wrapped)):
        present = [(left, cell[depth]) for left, cell in zip(lefts, wrapped, strict=True) if depth < len(cell)]
        lines.append(_Line(tuple(present), bold=bold, color=color))
    return lines


def _across() -> int:
    return int((PAPER[0] - 2 * _MARGIN) / _LETTER)


def _layout(table: TextTable) -> tuple[list[float], list[int]]:
    """Where every column begins, in, and how many letters it holds: as it needs, the widest cut until all fit."""
    everything = [row for row in (table.columns, *table.rows) if row]
    count = max((len(row) for row in everything), default=1)
    needs = [max((len(row[i]) for row in everything), default=1) + 1 for i in range(count)]
    total = int((PAPER[0] - 2 * _MARGIN - (count - 1) * _GUTTER) / _LETTER)
    while sum(needs) > total and max(needs) > 6:
        needs[needs.index(max(needs))] -= 1
    lefts = [sum(needs[:i]) * _LETTER + i * _GUTTER for i in range(count)]
    return lefts, needs


def _write(figure: Figure, line: _Line, y: float) -> None:
    for left, text in line.cells:
        figure.text(
            (_MARGIN + left) / PAPER[0],
            1 - y / PAPER[1],
            text.replace("$", r"\$"),  # after wrapping, which would part the two letters
            size=line.size,
            weight="bold" if line.bold else "normal",
            color=line.color,
            va="top",
        )
