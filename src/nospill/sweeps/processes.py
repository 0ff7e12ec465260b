"""Processes that answer requests within limits of time and memory; whatever becomes of one, an answer comes back."""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_LOOK = 0.1
"""s between two looks at the memory of a process."""
_LAST_WORDS = 300
_PAGE = os.sysconf("SC_PAGE_SIZE") if hasattr(os, "sysconf") else 4096


@dataclass(frozen=True, slots=True)
class Limits:
    """What one request may take.

    Attributes:
        seconds: of the clock.
        memory: of the process, bytes; 0 for no limit.
    """

    seconds: float
    memory: int = 0


class RequestError(Exception):
    """There is no answer; the message says why in one sentence."""


class TooSlowError(RequestError):
    """No answer within the time."""


class TooLargeError(RequestError):
    """The process grew over its memory."""


class DiedError(RequestError):
    """The process ended before it answered."""


class Worker:
    """A process that reads requests and writes answers, one line of JSON each. Not thread-safe."""

    def __init__(self, module: str, environment: Mapping[str, str]) -> None:
        """Start it.

        Args:
            module: of Python, run as a program.
            environment: beside that of this process.
        """
        self.kept: object = None
        """For the caller: what the process was told last."""
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - as long as the process
        self._rest = b""
        self._process = subprocess.Popen(
            [sys.executable, "-m", module],
            env=os.environ | environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            start_new_session=True,  # Ctrl-C is for whoever started it
        )

    @property
    def alive(self) -> bool:
        """Whether it takes requests."""
        return self._process.poll() is None

    def tell(self, message: Mapping[str, Any]) -> None:
        """Send what needs no answer; raises DiedError."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(message).encode() + b"\n")
            self._process.stdin.flush()
        except OSError:
            raise self._died() from None

    def ask(self, message: Mapping[str, Any], limits: Limits) -> dict[str, Any]:
        """Send a request and wait for its answer.

        Raises:
            RequestError: there is none; the process has ended then.
        """
        self.tell(message)
        end = time.monotonic() + limits.seconds
        while b"\n" not in self._rest:
            left = end - time.monotonic()
            if left <= 0.0:
                self.stop()
                raise TooSlowError(f"no answer within {limits.seconds:g} s")
            self._receive(min(left, _LOOK))
            if limits.memory and (used := self.memory()) > limits.memory:
                self.stop()
                raise TooLargeError(
                    f"{used / 1e6:.0f} MB of memory were in use; at most {limits.memory / 1e6:.0f} MB are allowed"
                )
        line, _, self._rest = self._rest.partition(b"\n")
        return dict(json.loads(line))

    def _receive(self, seconds: float) -> None:
        assert self._process.stdout is not None
        ready, _, _ = select.select([self._process.stdout], [], [], seconds)
        if ready:
            received = os.read(self._process.stdout.fileno(), 1 << 20)
            if not received:
                raise self._died()
            self._rest += received

    def memory(self) -> int:
        """Resident memory, bytes; 0 where the system does not tell."""
        try:
            return int(Path(f"/proc/{self._process.pid}/statm").read_text().split()[1]) * _PAGE
        except (OSError, IndexError, ValueError):
            return 0

    def stop(self) -> None:
        """End it now."""
        with contextlib.suppress(OSError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout, self._errors):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()

    def _died(self) -> DiedError:
        try:
            code: int | None = self._process.wait(timeout=5.0)
        except subprocess.TimeoutExpired:
            code = None
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace").strip().splitlines()
        self.stop()
        how = f"signal {-code}" if code is not None and code < 0 else f"exit code {code}"
        words = f": {said[-1][:_LAST_WORDS]}" if said else ""
        return DiedError(f"the planning process ended with {how}{words}")


class WorkerPool:
    """Workers that wait for the next request, whichever thread has it."""

    def __init__(self, module: str, environment: Mapping[str, str]) -> None:
        """As a `Worker`; none is started."""
        self._module, self._environment = module, environment
        self._lock = threading.Lock()
        self._idle: list[Worker] = []
        self._all: set[Worker] = set()

    def take(self) -> Worker:
        """One for the caller alone."""
        with self._lock:
            while self._idle:
                worker = self._idle.pop()
                if worker.alive:
                    return worker
                self._all.discard(worker)
            worker = Worker(self._module, self._environment)
            self._all.add(worker)
            return worker

    def give_back(self, worker: Worker) -> None:
        """It may be taken again, if it lives."""
        with self._lock:
            if worker.alive:
                self._idle.append(worker)
            else:
                self._all.discard(worker)

    def knows(self, worker: Worker) -> bool:
        """Whether `stop` has not been called since it was taken."""
        with self._lock:
            return worker in self._all

    def stop(self) -> None:
        """End all of them, whatever they do."""
        with self._lock:
            workers, self._all, self._idle = self._all, set(), []
        for worker in workers:
            worker.stop()
