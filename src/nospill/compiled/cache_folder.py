"""Where compiled functions are kept, and whether anything is compiled.

A library is executed as it is, and its hash is no seal: who can write the one can write the other. A folder that
belongs to another user, or to which group or others may write, is therefore neither read nor written; a warning says
so, and functions are interpreted.

NOSPILL_COMPILE = background (default) | wait | off; NOSPILL_CACHE = folder, else the user's cache folder.
"""

from __future__ import annotations

import hashlib
import os
import stat
import warnings
from pathlib import Path

from nospill.compiled.compilers import compiler_path


def cache_folder() -> Path:
    """Where compiled functions are kept."""
    own = os.environ.get("NOSPILL_CACHE")
    if own:
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "nospill"


def is_private(folder: Path) -> bool:
    """Whether a folder is there and only this user can put libraries into it; warns where others can."""
    try:
        status = folder.stat()
    except OSError:
        return False
    if status.st_uid == os.getuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return True
    warnings.warn(
        f"NOSPILL_CACHE = {folder}: compiled functions are not used, planning is slower: the folder belongs to another "
        "user or others may write to it; make it yours alone (chmod go-w) or name another one",
        RuntimeWarning,
        stacklevel=1,
    )
    return False


def compiles() -> bool:
    """Whether functions are compiled here: not switched off, and a compiler and a folder for them are at hand."""
    return mode() != "off" and compiler_path() is not None


def mode() -> str:
    """NOSPILL_COMPILE: background, wait or off."""
    chosen = os.environ.get("NOSPILL_COMPILE", "background") if os.name == "posix" else "off"
    return chosen if chosen in ("wait", "off") else "background"


def is_whole(library: Path) -> bool:
    """Whether a library is there with its own hash beside it: half of one would end the process that loads it."""
    try:
        stored = library.with_suffix(".sum").read_text(encoding="utf-8")
        return stored == hashlib.sha256(library.read_bytes()).hexdigest()
    except (OSError, ValueError):
        return False
