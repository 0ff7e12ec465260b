"""Tables and lines on a terminal: names whole, numbers right-aligned, colour for a verdict only."""

from __future__ import annotations

import shutil
import sys
import textwrap
from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:  # heavy to import, and half of all calls print no table
    from rich.console import Console

_USUAL_WIDTH = 120
"""Letters of a line that no terminal shows."""
_GAP = 1
"""Letters between columns besides the one of the rule."""
_LEAST_NUMBER = 1e-3
"""Smaller positive numbers are not told apart."""
_LEAST_TEXT = 24
"""Letters that a column of sentences needs at least."""


def print_table(
    columns: Sequence[str],
    rows: Iterable[Sequence[object]],
    *,
    right: Collection[str] = (),
    drop: Sequence[str] = (),
    failing: Collection[int] = (),
) -> None:
    """Print rows under their column names; real numbers have three digits, None is a dash.

    No cell is cut. Where a line is too narrow, columns are left out; sentences of the last column go on below.

    Args:
        columns: names.
        rows: cells.
        right: columns of text that are aligned as numbers are.
        drop: columns that may be left out, the first one first.
        failing: indices of rows that are printed in red.
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    given = [list(row) for row in rows]
    numeric = {
        name
        for index, name in enumerate(columns)
        if all(row[index] is None or isinstance(row[index], int | float) for row in given)
    }
    cells = [[_cell(value) for value in row] for row in given]
    shown = _fitting_columns(columns, cells, drop)
    widths = [_widest(columns, cells, index) for index in shown]
    last = shown[-1]
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, _GAP, 0, 0), collapse_padding=True)
    for index, width in zip(shown, widths, strict=True):
        side = "right" if columns[index] in numeric or columns[index] in right else "left"
        wraps = index == last and width > _LEAST_TEXT
        least = _LEAST_TEXT if wraps else width
        # Text: names and units in brackets may be what rich takes for markup.
        table.add_column(Text(columns[index]), justify=side, no_wrap=not wraps, min_width=least)
    for number, row in enumerate(cells):
        table.add_row(*(Text(row[index]) for index in shown), style="red" if number in failing else None)
    least = sum(widths[:-1]) + min(widths[-1], _LEAST_TEXT) + (_GAP + 1) * len(shown)
    console(width=max(_width(), least)).print(table)


def print_lines(*lines: str) -> None:
    """Print sentences on stdout, on a terminal broken at words."""
    for line in lines:
        print(_break_line(line, sys.stdout))


def print_verdict(line: str, ok: bool) -> None:
    """Print a verdict, on a terminal in green or red unless NO_COLOR is set."""
    from rich.text import Text

    console(width=_width()).print(Text(line), style="bold green" if ok else "bold red", soft_wrap=True)


def say(line: str) -> None:
    """Print a line on stderr at once, on a terminal broken at words."""
    print(_break_line(line, sys.stderr), file=sys.stderr, flush=True)


def console(*, width: int) -> Console:
    """Where tables go: stdout as it is now, in colour on a terminal only."""
    from rich.console import Console

    return Console(width=width, highlight=False)


def terminal_width(stream: TextIO) -> int | None:
    """Letters of a line of the terminal that a stream goes to; None where it goes elsewhere."""
    return shutil.get_terminal_size().columns if stream.isatty() else None


def _width() -> int:
    return terminal_width(sys.stdout) or _USUAL_WIDTH


def _break_line(line: str, stream: TextIO) -> str:
    """A line as it is, on a terminal with its breaks at spaces."""
    width = terminal_width(stream)
    if width is None:
        return line
    return textwrap.fill(line, width, break_long_words=False, break_on_hyphens=False)


def _fitting_columns(columns: Sequence[str], cells: Sequence[Sequence[str]], drop: Sequence[str]) -> list[int]:
    """Columns that fit on a line, in their order."""
    shown = list(range(len(columns)))

    def needed() -> int:
        widths = [_widest(columns, cells, index) for index in shown]
        return sum(widths[:-1]) + min(widths[-1], _LEAST_TEXT) + (_GAP + 1) * (len(shown) - 1)

    for name in drop:
        if needed() > _width():
            shown.remove(columns.index(name))
    return shown


def _widest(columns: Sequence[str], cells: Sequence[Sequence[str]], index: int) -> int:
    from rich.cells import cell_len

    return max(map(cell_len, [columns[index], *(row[index] for row in cells)]))


def _cell(value: object) -> str:
    if value is None:
        return "-"
    if isinstance(value, float) and 0.0 < value < _LEAST_NUMBER:
        return f"< {_LEAST_NUMBER:g}"
    return f"{value:.3g}" if isinstance(value, float) else str(value)
