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
        named: whether the file has a header; columns are numbered else.
    """

    origin: str
    columns: Mapping[str, np.ndarray]
    units: Mapping[str, str]
    wrong: Mapping[str, tuple[int, str]]
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
        raise ScenarioError(f"{origin}: {error}; give a joint log as CSV or as a ROS bag") from None
    numbered = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1)]
    numbered = [(number, line) for number, line in numbered if line and not line.startswith("#")]
    if not numbered:
        raise ScenarioError(f"{origin}: is empty; give a joint log as CSV or as a ROS bag")
    separator = next((sign for sign in (";", "\t", ",") if sign in numbered[0][1]), None)
    rows = [(number, _cells(line, separator)) for number, line in numbered]
    header = rows[0][1]
    named = _number(header[0], separator) is None and header[0].lower() not in _MISSING
    body = rows[1:] if named else rows
    for number, cells in body:
        if len(cells) != len(header):
            last = "; the log stops in the middle of a line" if number == body[-1][0] else ""
            raise ScenarioError(f"{origin}: row {number} has {len(cells)} values where {len(header)} are needed{last}")
    if not named:
        header = [f"q{number + 1}" for number in range(len(header))]
    names, units = zip(*map(_name_and_unit, header), strict=True)
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ScenarioError(f"{origin}: two columns are named {twice[0]}; give each its own name")
    columns, wrong = {}, {}
    for index, name in enumerate(names):
        values, fault = _values(body, index, separator)
        columns[name] = values
        if fault is not None:
            wrong[name] = fault
    return TextTable(origin, columns, dict(zip(names, units, strict=True)), wrong, named)


def _cells(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]


def _number(cell: str, separator: str | None) -> float | None:
    if separator != "," and _DECIMAL_COMMA.fullmatch(cell):
        cell = cell.replace(",", ".")
    return number_written(cell)


def _values(
    body: Sequence[tuple[int, list[str]]], index: int, separator: str | None
) -> tuple[np.ndarray, tuple[int, str] | None]:
    """A column as numbers, and its first cell that is neither a number nor empty, with the line."""
    fault, values = None, np.full(len(body), np.nan)
    for row, (number, cells) in enumerate(body):
        cell = cells[index]
        value = _number(cell, separator)
        if value is not None and math.isfinite(value):
            values[row] = value
        elif value is None and fault is None and cell.lower() not in _MISSING:
            fault = (number, cell)
    return values, fault


def _name_and_unit(cell: str) -> tuple[str, str]:
    match = _UNIT.fullmatch(cell.strip().strip('"'))
    if match is None:
        return cell.lower(), ""
    written = (match[2] or match[3] or "").lower()
    return match[1].strip().lower(), _SPELLED.get(written, written)
