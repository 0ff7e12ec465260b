"""Writing that leaves the old file or folder, or the new one, never half of either; reading that knows a bound."""

from __future__ import annotations

import ctypes
import errno
import glob
import json
import os
import re
import secrets
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from nospill.errors import PlanFolderError

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None

_JUST_MADE = 60.0
"""s; a partial folder younger than this may be another run's that has not locked it yet."""

_SWAP_ATTEMPTS = 50
"""How often another writer may win the place between our two renames before we give up."""

Replaceable = Callable[[set[str]], bool]
"""Judges by the names in a folder that is not empty whether it may be thrown away."""


def require_writable(path: Path) -> None:
    """Check, before any long work and without writing, that `atomic_file` may write a file.

    Raises:
        PlanFolderError: there is no folder for it, it is a folder itself, or nothing may be written there.
    """
    if not path.parent.is_dir():
        raise PlanFolderError(f"cannot write {path}: there is no folder {path.parent}; make it first")
    if path.is_dir():
        raise PlanFolderError(f"cannot write {path}: it is a folder; name a file")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise PlanFolderError(f"cannot write {path}: no permission to write in {path.parent}; name another place")


def require_replaceable(target: str | Path, *, replaceable: Replaceable) -> Path:
    """Check, before any long work and without writing, that `atomic_folder` may write `target`.

    Args:
        target: the folder to be; it may be missing, empty or one that `replaceable` accepts.
        replaceable: whether a folder that is not empty may be thrown away.

    Returns:
        The absolute target with symbolic links followed.

    Raises:
        PlanFolderError: `target` holds something else, is no folder, is the folder we stand in, or cannot be written.
    """
    try:
        place = Path(target).expanduser().resolve()
        _refuse_foreign(place, replaceable)
        if Path.cwd().is_relative_to(place):
            raise PlanFolderError(f"{place} holds the folder you are in and cannot be replaced; name another folder")
        ground = next(parent for parent in place.parents if parent.exists())
        if not os.access(ground, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, f"no permission to write in {ground}")
    except (OSError, RuntimeError) as error:  # RuntimeError: "~name" without such a user, or links in a circle
        raise _cannot_write(Path(target), error) from error
    return place


@contextmanager
def atomic_folder(target: str | Path, *, replaceable: Replaceable) -> Iterator[Path]:
    """Fill a new folder and put it in the place of the old one when it is complete.

    The body writes into a hidden sibling of `target`. When it ends, everything is flushed to the disk, the two folders
    exchange names and the old one is deleted. A run that is killed leaves the old or the new folder under the name
    `target`, and perhaps a hidden sibling ".NAME.*.partial", which the next run into the same folder deletes, or
    ".NAME.*.old", that can be deleted. (Where the system
    cannot exchange names the old folder is renamed away first, and killed just then leaves none of that name.) Of two
    writers at once the later wins.

    Args:
        target: the folder to be, as for `require_replaceable`; missing parents are made.
        replaceable: whether a folder that is not empty may be thrown away.

    Yields:
        The temporary folder to write into; it exists and is empty.

    Raises:
        PlanFolderError: `target` must not be replaced, or the disk refuses (full, read-only, no permission).
    """
    place = require_replaceable(target, replaceable=replaceable)
    sibling = f".{place.name}.{secrets.token_hex(4)}"
    partial = place.with_name(f"{sibling}.partial")
    lock = None
    try:
        partial.mkdir(parents=True)
        lock = _lock(partial)
        _clear_abandoned(place)
        yield partial
        _flush_tree(partial)
        _swap(partial, place, place.with_name(f"{sibling}.old"), replaceable)
    except OSError as error:
        raise _cannot_write(place, error) from error
    finally:
        if lock is not None:
            os.close(lock)
        shutil.rmtree(partial, ignore_errors=True)


def atomic_text(path: str | Path, text: str) -> None:
    """Write a text file (UTF-8, line ends as they are in `text`) so that readers see the old or the new content.

    Raises:
        PlanFolderError: the disk refuses, or `path` is a folder.
    """
    atomic_bytes(path, text.encode("utf-8"))


def atomic_bytes(path: str | Path, content: bytes) -> None:
    """Write a file so that readers see the old or the new content; raises as `atomic_text`."""
    with atomic_file(path) as partial:
        partial.write_bytes(content)


@contextmanager
def atomic_file(path: str | Path) -> Iterator[Path]:
    """Fill a new file and put it in the place of the old one when the block ends; raises as `atomic_text`.

    Yields:
        A hidden sibling of `path` with the same ending, which libraries choose a format by. It does not exist yet.
    """
    place = Path(path)
    partial = place.with_name(f".{place.stem}.{secrets.token_hex(4)}.partial{place.suffix}")
    try:
        yield partial
        _flush(partial)
        partial.replace(place)
        _flush(place.parent)
    except OSError as error:
        raise _cannot_write(place, error) from error
    finally:
        with suppress(OSError):
            partial.unlink()


def parsed_json(text: str) -> Any:
    """What JSON text holds.

    Raises:
        ValueError: it is not JSON, or nested more deeply than can be read.
    """
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("nested too deeply") from None


class UnreadableError(Exception):
    """A file of the user's that cannot be read; the message is the reason, without its name."""


class MissingFileError(UnreadableError):
    """A file that does not exist."""


def bounded_text(path: str | os.PathLike[str], largest: int) -> str:
    """Content of a text file (UTF-8, with or without a byte order mark) of at most so many bytes.

    Raises:
        MissingFileError: there is none.
        UnreadableError: it is no regular file (a device may never end), larger, or not such text.
    """
    place = Path(path)
    try:
        if place.is_dir():
            raise UnreadableError("is a folder")
        size = place.stat().st_size
        if not place.is_file():
            raise UnreadableError("is not a regular file")
        if size > largest:
            raise UnreadableError(f"is too large ({size} bytes; at most {largest} are read)")
        return place.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise MissingFileError("does not exist") from None
    except UnicodeDecodeError as error:
        raise UnreadableError(f"is not UTF-8 text (byte {error.start + 1}); save it as UTF-8") from None
    except (OSError, ValueError) as error:  # ValueError: a NUL character in the path
        reason = (error.strerror if isinstance(error, OSError) else None) or str(error)
        raise UnreadableError(f"cannot be read: {reason}") from None


def _refuse_foreign(place: Path, replaceable: Replaceable) -> None:
    # Looked at twice: another writer may be taking the old folder away just now, and half of it is seen.
    if all(_is_foreign(place, replaceable) for _ in range(2)):
        raise PlanFolderError(f"{place} holds files that nospill did not write; name a new or an empty folder")


def _is_foreign(place: Path, replaceable: Replaceable) -> bool:
    try:
        names = set(os.listdir(place))
    except FileNotFoundError:
        return False
    return bool(names) and not replaceable(names)


def _swap(partial: Path, place: Path, old: Path, replaceable: Replaceable) -> None:
    """Put `partial` in the place of `place`.

    Where the system can exchange two names in one step there is no moment without a folder of that name. Elsewhere
    the old one is renamed to `old` and deleted, and all is done again when another writer came between.
    """
    for _ in range(_SWAP_ATTEMPTS):
        _refuse_foreign(place, replaceable)
        if _exchange(partial, place):  # the old one is the partial one now, and deleted like it
            _flush(place.parent)
            return
        try:
            with suppress(FileNotFoundError):
                place.rename(old)
            partial.rename(place)
        except BaseException as error:
            if isinstance(error, OSError) and error.errno in (errno.ENOTEMPTY, errno.EEXIST):
                shutil.rmtree(old, ignore_errors=True)
                continue
            if old.exists() and not place.exists():
                old.rename(place)
            raise
        _flush(place.parent)
        shutil.rmtree(old, ignore_errors=True)
        return
    raise PlanFolderError(f"{place} is being written by other runs all the time; name another folder")


def _lock(folder: Path) -> int | None:
    """A descriptor that locks a folder as long as it is open, at most until the process ends; None without locks."""
    if fcntl is None:
        return None
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:  # another run looks at it, or a file system without locks
        os.close(descriptor)
        return None
    return descriptor


def _clear_abandoned(place: Path) -> None:
    """Delete the partial folders of runs into `place` that were killed: those that nobody locks any more.

    A folder that has just been made may not be locked yet, so those of the last minute stay.
    """
    if fcntl is None:
        return
    for folder in place.parent.glob(f".{glob.escape(place.name)}.*.partial"):
        with suppress(OSError):
            unmistakable = re.fullmatch(r"[0-9a-f]{8}", folder.name.removesuffix(".partial")[-8:]) and folder.is_dir()
            if not unmistakable or folder.is_symlink() or time.time() - folder.stat().st_mtime < _JUST_MADE:
                continue
            lock = _lock(folder)
            if lock is not None:
                shutil.rmtree(folder, ignore_errors=True)
                os.close(lock)


def _exchange(one: Path, other: Path) -> bool:
    """Exchange the names of two folders in one step (Linux); False where that is not possible."""
    if not sys.platform.startswith("linux"):
        return False
    call = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if call is None:
        return False
    here, exchange = ctypes.c_int(-100), ctypes.c_uint(2)  # AT_FDCWD, RENAME_EXCHANGE
    return call(here, os.fsencode(one), here, os.fsencode(other), exchange) == 0


def _flush(path: Path) -> None:
    """Flush one file, or the entries of one folder, to the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _flush_tree(folder: Path) -> None:
    for parent, _, names in os.walk(folder):
        for name in names:
            _flush(Path(parent, name))
        _flush(Path(parent))


def _cannot_write(place: Path, error: Exception) -> PlanFolderError:
    reason = (error.strerror if isinstance(error, OSError) else None) or str(error) or type(error).__name__
    return PlanFolderError(f"cannot write {place}: {reason}; make room, ask for permission or name another place")
