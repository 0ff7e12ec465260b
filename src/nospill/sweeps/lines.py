"""A file of JSON lines, each appended whole and on the disk before the next, read again by whoever goes on."""

from __future__ import annotations

import fcntl
import gzip
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from nospill.errors import PlanFolderError


class LinesFile:
    """An open file of lines.

    Attributes:
        known: the lines that were in it when it was opened.
    """

    def __init__(self, path: Path, descriptor: int, known: list[dict[str, Any]]) -> None:
        """Of a descriptor open for appending, and the lines that are in the file."""
        self._path, self._descriptor = path, descriptor
        self.known = known

    def append(self, line: dict[str, Any]) -> None:
        """Add a line: one write of the whole, on the disk before this returns.

        Raises:
            PlanFolderError: the disk refuses; a part of the line that got there is cut off again.
        """
        data = (json.dumps(line) + "\n").encode()
        end = os.fstat(self._descriptor).st_size
        try:
            if os.write(self._descriptor, data) != len(data):
                raise OSError(f"only a part of {len(data)} bytes was written")
            os.fsync(self._descriptor)
        except OSError as error:
            os.ftruncate(self._descriptor, end)
            raise PlanFolderError(
                f"{self._path}: a line cannot be written ({error.strerror or error}); those that are there are "
                "whole: make room and start again"
            ) from error


def read_lines(path: Path) -> list[dict[str, Any]]:
    """All whole lines of a file, gzipped or not, in order; a last one that was cut off by a kill does not count.

    Raises:
        PlanFolderError: the file cannot be read, or has a line that is no JSON object.
    """
    try:
        with gzip.open(path) if path.suffix == ".gz" else path.open("rb") as file:
            found = [json.loads(line) for line in file if line.endswith(b"\n")]
    except OSError as error:
        raise PlanFolderError(f"{path}: cannot be read ({error.strerror or error})") from error
    except ValueError as error:
        raise PlanFolderError(f"{path}: is no file of JSON lines ({error}); name another one") from None
    if not all(isinstance(line, dict) for line in found):
        raise PlanFolderError(f"{path}: is no file of JSON objects; name another one")
    return found


@contextmanager
def lines_file(path: Path) -> Iterator[LinesFile]:
    """Open a file to go on with it, alone; it is made where there is none.

    Raises:
        PlanFolderError: another process writes into it, it cannot be opened, or is no file of lines.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o644)
    except OSError as error:
        raise PlanFolderError(f"{path}: cannot be written ({error.strerror or error}); name another place") from error
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise PlanFolderError(
                f"{path}: another run is writing into it; wait for it, or name another place"
            ) from None
        known = read_lines(path)
        os.ftruncate(descriptor, path.read_bytes().rfind(b"\n") + 1)
        yield LinesFile(path, descriptor, known)
    finally:
        os.close(descriptor)
