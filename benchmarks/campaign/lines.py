"""The file of the campaign: one JSON line a case, appended whole, read again by whoever goes on or reports."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from nospill.errors import PlanFolderError
from nospill.sweeps.lines import LinesFile, lines_file, read_lines


class Lines:
    """An open file of lines.

    Attributes:
        cases: seed -> line of the case. starts: seed -> line of its further starts.
    """

    def __init__(self, file: LinesFile) -> None:
        """Of a file and the lines that are in it."""
        self._file = file
        self.cases = {line["seed"]: line for line in file.known if "starts_from" not in line}
        self.starts = {line["seed"]: line for line in file.known if "starts_from" in line}

    def append(self, line: dict[str, Any]) -> None:
        """Add a line: one write of the whole, on the disk before this returns.

        Raises:
            PlanFolderError: the disk refuses; a part of the line that got there is cut off again.
        """
        self._file.append(line)
        (self.starts if "starts_from" in line else self.cases)[line["seed"]] = line

    @staticmethod
    def read(path: Path) -> list[dict[str, Any]]:
        """All whole lines of a file, gzipped or not, in order; a last one that was cut off by a kill does not count."""
        return read_lines(path)

    @classmethod
    @contextmanager
    def writer(cls, path: Path) -> Iterator[Lines]:
        """Open a file to go on with it, alone.

        Raises:
            SystemExit: another campaign writes into it, or it is no file of lines.
        """
        try:
            with lines_file(path) as file:
                yield cls(file)
        except PlanFolderError as error:
            raise SystemExit(str(error)) from None
