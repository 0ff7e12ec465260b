"""What the commands share: errors as one line with an exit code, JSON, a clean stdout."""

from __future__ import annotations

import functools
import json
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path

import typer

from nospill.cli.tables import say
from nospill.errors import NospillError

INTERNAL_ERROR = 70
STOPPED = 130
OUTPUT_CLOSED = 141


def reported(command: Callable[..., int]) -> Callable[..., None]:
    """Turn what a command returns or raises into one line and an exit code."""

    @functools.wraps(command)
    def run(*args: object, **kwargs: object) -> None:
        try:
            code = command(*args, **kwargs)
            sys.stdout.flush()
        except NospillError as error:
            code = error.exit_code
            say(one_line(error))
        except KeyboardInterrupt:
            code = STOPPED
            say("stopped; nothing was written")
        except BrokenPipeError:
            code = OUTPUT_CLOSED
            os.dup2(
                os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno()
            )  # or the interpreter complains when it flushes
        except Exception as error:
            code = INTERNAL_ERROR
            if os.environ.get("NOSPILL_TRACEBACK") == "1":
                traceback.print_exc()
            what = f"{type(error).__name__}: {one_line(error)}"
            say(f"internal error: {what}; please report it with the scenario (NOSPILL_TRACEBACK=1 shows where)")
        raise typer.Exit(code)

    return run


def one_line(error: Exception | str) -> str:
    """The message on one line."""
    return " ".join(str(error).split())


@contextmanager
def only_stderr() -> Iterator[None]:
    """Send everything that Python and the compiled solvers print to stderr, so that stdout stays clean for JSON."""
    import ctypes

    sys.stdout.flush()
    stdout = os.dup(1)
    os.dup2(2, 1)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        if os.name == "posix":
            ctypes.CDLL(None).fflush(None)  # what C code has printed may still wait in its own buffer
        os.dup2(stdout, 1)
        os.close(stdout)


def sibling_file(folder: Path, ending: str) -> Path:
    """The file next to a folder with the folder's name and an ending, as the folder was given: not made absolute."""
    named = folder if folder.name not in ("", "..") else folder.resolve()
    return named.with_name(f"{named.name}{ending}")


def print_json(value: object) -> None:
    """Print a value as JSON; numbers that are none raise ValueError."""
    print(json.dumps(value, indent=2, allow_nan=False))
