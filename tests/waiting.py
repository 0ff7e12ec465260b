"""Waits of the tests: bounded by a generous time, and when it has passed they say what did not come.

The only place of the tests that reads a clock or names a time-out: how long something takes depends on the machine and
on what else runs there, so no test is about seconds (tests/repository/test_clocks.py). What is to be fast is counted.
"""

from __future__ import annotations

import select
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pytest

PATIENCE = 240.0
"""s; some hundred times of what the slowest of the waits takes on an idle machine."""


def wait_until(condition: Callable[[], object], what: str, *, pause: Callable[[float], object] = time.sleep) -> None:
    """Wait until a condition holds.

    Args:
        condition: looked at again and again.
        what: names what is waited for, for the message.
        pause: lets so many s pass; a browser's page has its own.
    """
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            pytest.fail(f"waited {PATIENCE:g} s in vain: {what}")
        pause(0.02)


def finished(process: subprocess.Popen[str], what: str) -> tuple[str, str]:
    """Output and errors of a process, once it has ended; it is killed when it does not."""
    try:
        return process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        out, errors = process.communicate()
        pytest.fail(f"waited {PATIENCE:g} s in vain: {what} has not ended; it said {out!r} and {errors!r}")


def first_line(process: subprocess.Popen[str], what: str) -> str:
    """The first line that a process prints; it is killed when none comes."""
    assert process.stdout is not None
    ready, _, _ = select.select([process.stdout], [], [], PATIENCE)
    if not ready:
        process.kill()
        pytest.fail(f"waited {PATIENCE:g} s in vain: {what} has printed nothing")
    return process.stdout.readline()


def run_python(
    *arguments: str,
    check: bool = False,
    cwd: Path | None = None,
    env: Mapping[str, str] | None = None,
) -> subprocess.CompletedProcess[str]:
    """Run this interpreter with arguments, in a process of its own, to its end.

    Raises:
        CalledProcessError: `check`, and it ends with another code than 0.
    """
    command: Sequence[str] = [sys.executable, *arguments]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=cwd, env=env and dict(env)
    )
    out, errors = finished(process, f"python {' '.join(arguments)[:80]!r}")
    done = subprocess.CompletedProcess(command, process.returncode, out, errors)
    if check:
        done.check_returncode()
    return done
