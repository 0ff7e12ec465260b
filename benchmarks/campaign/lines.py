"""The file of the campaign: one JSON line a case, appended whole, read again by whoever goes on or reports."""

from __future__ import annotations

import fcntl
import gzip
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


class Lines:
    """An open file of lines.

    Attributes:
        cases: seed -> line of the case. starts: seed -> line of its further starts.
    """

    def __init__(self, descriptor: int, known: list[dict[str, Any]]) -> None:
        """Of a descriptor open for appending, and the lines that are in the file."""
        self._descriptor = descriptor
        self.cases = {line["seed"]: line for line in known if "starts_from" not in line}
        self.starts = {line["seed"]: line for line in known if "starts_from" in line}

    def append(self, line: dict[str, Any]) -> None:
        """Add a line: one write of the whole, on the disk before this returns.

        Raises:
            OSError: the disk refuses; a part of the line that got there is cut off again.
        """
        end = os.fstat(self._descriptor).st_size
        data = (json.dumps(line) + "\n").encode()
        try:
            if os.write(self._descriptor, data) != len(data):
                raise OSError(f"only a part of {len(data)} bytes was written")
        except OSError:
            os.ftruncate(self._descriptor, end)
            raise
        os.fsync(self._descriptor)
        (self.starts if "starts_from" in line else self.cases)[line["seed"]] = line

    @staticmethod
    def read(path: Path) -> list[dict[str, Any]]:
        """All whole lines of a file, gzipped or not, in order; a last one that was cut off by a kill does not count."""
        with gzip.open(path) if path.suffix == ".gz" else path.open("rb") as file:
            return [json.loads(line) for line in file if line.endswith(b"\n")]

    @classmethod
    @contextmanager
    def writer(cls, path: Path) -> Iterator[Lines]:
        """Open a file to go on with it, alone.

        Raises:
            SystemExit: another campaign writes into it.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o644)
        try:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise SystemExit(f"{path}: another campaign is writing into it; name another file") from None
            content = path.read_bytes()
            os.ftruncate(descriptor, content.rfind(b"\n") + 1)
            yield cls(descriptor, cls.read(path))
        finally:
            os.close(descriptor)
