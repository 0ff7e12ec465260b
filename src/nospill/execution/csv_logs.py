"""Joint logs as tables of text: CSV in any order and unit, recordings of UR's RTDE, the laboratory's joint files."""

from __future__ import annotations

import os
from pathlib import Path

from nospill.core.text_tables import read_text_table
from nospill.core.units import as_written
from nospill.errors import ScenarioError
from nospill.execution.log import RawLog


def read_table(path: str | os.PathLike[str], *, joints: int) -> RawLog:
    """Read a table of joint positions over time.

    Without a header there are as many columns as joints, and no time.

    Args:
        path: the file.
        joints: of the robot.

    Raises:
        ScenarioError: the file cannot be read, or is no such table; names the line.
    """
    table = read_text_table(path)
    if not table.named and len(table.columns) != joints:
        raise ScenarioError(
            f"{table.origin}: {len(table.columns)} columns without a header where the robot has {joints} joints, which "
            f"would be all of them; where one is of times, add the header line t_s,q1_rad,...,q{joints}_rad"
        )
    wrong = {
        name: f"row {number}: {as_written(cell)} in column {name} is not a number"
        for name, (number, cell) in table.wrong.items()
    }
    return RawLog(table.origin, table.columns, table.units, named=table.named, wrong=wrong)


def is_table(path: Path) -> bool:
    """Whether a file is read as a table, by its name."""
    return path.is_file() and path.suffix.lower() not in (".bag", ".mcap", ".db3")
