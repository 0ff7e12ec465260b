"""One case as a process with a time limit; whatever becomes of the process, a line comes back."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_LAST_WORDS = 400
_PATIENCE = 5.0
"""Time that may pass over the processor time of a process: the machine may have other work to do."""


ROOT = str(Path(__file__).parents[2])
"""Where the package `benchmarks` is found: a folder, or the archive that a cluster's worker was sent."""

CASE = "benchmarks.campaign.case"


@dataclass(frozen=True, slots=True)
class Job:
    """What a process does.

    Attributes:
        seed: of the case. limit: longest processor time, s; five times as long may pass meanwhile.
        folder: where the package is taken from; None: the one that is installed.
        starts: number of further random starts; 0: the case itself.
        table: its scenario; drawn from the seed where there is none.
        module: that is run.
        compiled: whether functions may be compiled and kept for the next job.
        threads: how many may work at once, and as many processes.
    """

    seed: int
    limit: float
    folder: str | None = None
    starts: int = 0
    table: dict[str, Any] | None = None
    module: str = CASE
    compiled: bool = False
    threads: int = 1


def run_job(job: Job) -> dict[str, Any]:
    """Run a job in a process of its own and return its line; never raises for what the process does."""
    command = [sys.executable, "-m", job.module, str(job.seed)]
    command += ["--processor-time", str(math.ceil(job.limit))]
    command += ["--starts", str(job.starts)] if job.starts else []
    command += ["--given"] if job.table is not None else []
    began = time.perf_counter()
    with subprocess.Popen(
        command,
        env=environment(job.folder, compiled=job.compiled, threads=job.threads),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            out, errors = process.communicate(
                json.dumps(job.table) if job.table is not None else "", timeout=_PATIENCE * job.limit
            )
            late = False
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            out, errors = process.communicate()
            late = True
    return line_of(job, out, errors, None if late else process.returncode) | {"seconds": time.perf_counter() - began}


def environment(folder: str | None, *, compiled: bool = False, threads: int = 1) -> dict[str, str]:
    """Of a process: its threads, no compiler unless structures come again, the package of a folder first."""
    settings = {"OMP_NUM_THREADS": "1", "NOSPILL_THREADS": str(threads)} | (
        {} if compiled else {"NOSPILL_COMPILE": "off"}
    )
    return os.environ | settings | {"PYTHONPATH": os.pathsep.join(filter(None, (folder, ROOT)))}


def line_of(job: Job, out: str, errors: str, code: int | None) -> dict[str, Any]:
    """The line of a process from what it printed and how it ended (None: it was stopped)."""
    printed = [_parsed(line) for line in out.splitlines()]
    found = [line for line in printed if line is not None]
    head = {"seed": job.seed}
    if job.table is None and found:
        head |= found.pop(0)
    if code is None or -code == signal.SIGXCPU:
        failed = {"kind": "out of time", "reason": f"no answer within {job.limit:g} s"}
    else:
        words = (errors.strip().splitlines() or ["no message"])[-1][:_LAST_WORDS]
        failed = {"kind": "crash", "reason": f"exit code {code}: {words}", "traceback": errors[-4000:]}
    if job.starts:
        return head | ({"kind": "starts"} if code == 0 else failed) | {"starts_from": found, "asked": job.starts}
    kept = {} if job.table is None else {"scenario": job.table}
    return head | kept | (found[0] if code == 0 and found else failed)


def _parsed(line: str) -> dict[str, Any] | None:
    """A line of JSON; None for anything else, such as what a library prints or half a line."""
    try:
        value = json.loads(line)
    except ValueError:
        return None
    return value if isinstance(value, dict) else None
