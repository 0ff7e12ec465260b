"""Tables of text as recorders and spreadsheets write them: columns of numbers by name, whatever separates them."""

from __future__ import annotations

import csv
import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nospill.core.files import UnreadableError, bounded_text
from nospill.core.units import number_written
from nospill.errors import ScenarioError

_LARGEST_FILE = 200_000_000
_MISSING = frozenset(("", "nan", "null", "none", "na", "n/a", "-"))
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(e[+-]?\d+)?", re.IGNORECASE)
_UNIT = re.compile(
    r"(.+?)(?:[_ .]?[\[(]\s*(rad|deg|°|s|sec|ms|us|µs|ns)\s*[\])]|[_.](rad|deg|s|ms|us|ns))?", re.IGNORECASE
)
_SPELLED = {"sec": "s", "µs": "us", "°": "deg"}


@dataclass(frozen=True, slots=True, eq=False)
class TextTable:
    """A table of text.

    Attributes:
        origin: the file, as messages name it.
        columns: name in small letters without its unit -> (m,), as written; NaN where a cell is empty or no number.
        units: likewise the unit that the name ends with, "" where it has none.
        wrong: of columns with cells that are neither numbers nor empty, the first such cell and its line.
        lines: (m,) numbers of the rows' lines in the file.
        named: whether the file has a header; columns are q1, q2 ... else.
    """

    origin: str
    columns: Mapping[str, np.ndarray]
    units: Mapping[str, str]
    wrong: Mapping[str, tuple[int, str]]
    lines: np.ndarray
    named: bool


def read_text_table(path: str | os.PathLike[str]) -> TextTable:
    """Read a table of text.

    Columns are separated by commas, semicolons, tabs or spaces; numbers may have a decimal comma where no comma
    separates. Lines that begin with # are left out. A header names the columns, with a unit at the end perhaps (q1_deg,
    "joint_a [rad]", t_ms).

    Raises:
        ScenarioError: the file cannot be read, is empty, has rows of unlike length or two columns of one name; names
            the line.
    """
    origin = os.fsdecode(path)
    try:
        text = bounded_text(path, _LARGEST_FILE)
    except UnreadableError as error:
        raise ScenarioError(f"{origin}: {error}; give a table of text (CSV)") from None
    numbered = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1)]
    numbered = [(number, line) for number, line in numbered if line and not line.startswith("#")]
    if not numbered:
        raise ScenarioError(f"{origin}: is empty; give a table of text (CSV)")
    separator = next((sign for sign in (";", "\t", ",") if sign in numbered[0][1]), None)
    header = _cells(numbered[0][1], separator)
    named = _number(header[0], separator) is None and header[0].lower() not in _MISSING
    body = numbered[1:] if named else numbered
    if not named:
        header = [f"q{number + 1}" for number in range(len(header))]
    names, units = zip(*map(_name_and_unit, header), strict=True)
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ScenarioError(f"{origin}: two columns are named {twice[0]}; give each its own name")
    values, wrong = _plain(body, separator, len(header)), dict[str, tuple[int, str]]()
    if values is None:
        values, wrong = _values(body, separator, names, origin)
    lines = np.array([number for number, _ in body], dtype=int)
    return TextTable(
        origin, dict(zip(names, values, strict=True)), dict(zip(names, units, strict=True)), wrong, lines, named
    )


def _plain(body: Sequence[tuple[int, str]], separator: str | None, count: int) -> np.ndarray | None:
    """The columns (count, m) of a table that is numbers throughout, ten times as fast; None where it is not."""
    if not body:
        return None
    try:
        table = np.loadtxt([line for _, line in body], delimiter=separator, ndmin=2, comments=None)
    except ValueError:
        return None
    return table.T if table.shape == (len(body), count) and np.all(np.isfinite(table)) else None


def _values(
    body: Sequence[tuple[int, str]], separator: str | None, names: Sequence[str], origin: str
) -> tuple[np.ndarray, dict[str, tuple[int, str]]]:
    """The columns (n, m) cell by cell, and of each the first cell that is neither a number nor empty, with its line."""
    values, wrong = np.full((len(names), len(body)), np.nan), dict[str, tuple[int, str]]()
    for row, (number, line) in enumerate(body):
        cells = _cells(line, separator)
        if len(cells) != len(names):
            last = "; the file stops in the middle of a line" if row == len(body) - 1 else ""
            raise ScenarioError(f"{origin}: row {number} has {len(cells)} values where {len(names)} are needed{last}")
        for index, cell in enumerate(cells):
            value = _number(cell, separator)
            if value is not None and math.isfinite(value):
                values[index, row] = value
            elif value is None and cell.lower() not in _MISSING:
                wrong.setdefault(names[index], (number, cell))
    return values, wrong


def _cells(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]


def _number(cell: str, separator: str | None) -> float | None:
    if separator != "," and _DECIMAL_COMMA.fullmatch(cell):
        cell = cell.replace(",", ".")
    return number_written(cell)


def _name_and_unit(cell: str) -> tuple[str, str]:
    match = _UNIT.fullmatch(cell.strip().strip('"'))
    if match is None:
        return cell.lower(), ""
    written = (match[2] or match[3] or "").lower()
    return match[1].strip().lower(), _SPELLED.get(written, written)
