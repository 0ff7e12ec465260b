"""Tables of words and figures: a record that every page of a report reads, and its drawing on sheets of A4."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

from matplotlib.figure import Figure
from matplotlib.font_manager import findfont, get_font

from nospill.plots.sheets import PAPER, Placed, Sheet
from nospill.plots.style import DARK_RED, INK

_MARGIN, _LINE, _SIZE, _FOOT = 0.6, 0.128, 7.0, 0.56
_LETTER = 0.56 * _SIZE / 72
"""in; width that few letters exceed on average."""
_GUTTER = 0.12
TEXT_WIDTH = PAPER[0] - 2 * _MARGIN
"""in; between the margins of a sheet."""
_BETWEEN = 0.15
_HALF = 0.78
"""Scale of a figure that has half a sheet's width."""


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
class FigureRow:
    """Figures side by side, one or two, below a title or none."""

    figures: tuple[Figure, ...]
    title: str = ""


@dataclass(frozen=True, slots=True)
class _Line:
    """One line on paper: texts and where they begin (in from the left), bold or not, colour, space below (in)."""

    cells: tuple[tuple[float, str], ...]
    bold: bool = False
    color: str = "black"
    size: float = _SIZE
    below: float = _LINE


def text_pages(items: tuple[TextTable | FigureRow, ...], footer: str) -> list[Sheet]:
    """Tables and figures as sheets of A4, as many as they take; to be saved inside `matplotlib.rc_context(LOOK)`.

    A table that goes on over a sheet has the names of its columns again.

    Args:
        items: in order.
        footer: at the foot of every sheet, beside its number.
    """
    flow = _Flow([], 0.0)
    for item in items:
        if isinstance(item, FigureRow):
            _place(flow, item)
            continue
        lefts, letters = _layout(item)
        again = _row(item.columns, lefts, letters, bold=True) if any(item.columns) else []
        for number, block in enumerate(_blocks(item)):
            height = sum(line.below for line in block)
            lines = block
            if flow.break_before(height) and number and any(line.cells for line in block):
                lines = [*again, *block]
            for line in lines:
                _write(flow.sheets[-1].page, line, flow.y)
                flow.y += line.below
    for number, sheet in enumerate(flow.sheets, 1):
        where = f"page {number} of {len(flow.sheets)}"
        _write(sheet.page, _Line(((0.0, printable(footer)),), size=7, color=INK), PAPER[1] - _FOOT)
        _write(sheet.page, _Line(((TEXT_WIDTH - 0.75, where),), size=7, color=INK), PAPER[1] - _FOOT)
    return flow.sheets


@dataclass(slots=True)
class _Flow:
    """Sheets so far, and how far down the last one is filled, in."""

    sheets: list[Sheet]
    y: float

    def break_before(self, height: float) -> bool:
        """Begin a sheet where so much does not fit on the last one; whether that was so."""
        if self.sheets and self.y + height <= PAPER[1] - _MARGIN - 0.1:
            return False
        self.sheets.append(Sheet(Figure(figsize=PAPER)))
        self.y = _MARGIN
        return True


def _place(flow: _Flow, row: FigureRow) -> None:
    """A row of figures: one keeps its size as far as it fits, two share the width."""
    share = (TEXT_WIDTH - _BETWEEN * (len(row.figures) - 1)) / len(row.figures)
    scales = [min(share / figure.get_size_inches()[0], 1.0) for figure in row.figures]
    if len(row.figures) == 1 and row.figures[0].get_size_inches()[0] < TEXT_WIDTH:
        scales = [_HALF]
    height = max(scale * figure.get_size_inches()[1] for scale, figure in zip(scales, row.figures, strict=True))
    above = 0.24 if row.title else 0.0
    flow.break_before(height + above)
    if row.title:
        _write(flow.sheets[-1].page, _Line(((0.0, printable(row.title)),), bold=True, size=10), flow.y)
    for index, (scale, figure) in enumerate(zip(scales, row.figures, strict=True)):
        left = _MARGIN + index * (share + _BETWEEN)
        flow.sheets[-1].placed.append(Placed(figure, left, flow.y + above, scale))
    flow.y += height + above + 0.12


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
    head = [_Line(((0.0, printable(table.title)),), bold=True, size=10, below=0.2)]
    if any(table.columns):
        head += _row(table.columns, lefts, letters, bold=True)
    tail = [_Line(((0.0, text),), color=INK) for text in textwrap.wrap(printable(table.note), _across())]
    for index, row in enumerate(table.rows):
        failing = index in table.failing
        lines = head + _row(row, lefts, letters, bold=failing, color=DARK_RED if failing else "black")
        yield lines + tail if index == len(table.rows) - 1 else lines
        head = []
    yield [*([] if table.rows else head + tail), _Line((), below=0.15)]


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
