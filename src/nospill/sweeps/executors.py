"""Where groups are planned: threads of this machine or a Dask cluster, both as an `Executor`."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from nospill.core.units import as_written
from nospill.errors import ClusterError, MissingExtraError, ScenarioError

_PATIENCE = 10.0
"""s for a scheduler to answer, and for its first worker to come."""
_MOST_JOBS = 1024


@contextmanager
def this_machine(jobs: int, stop: Callable[[], None]) -> Iterator[Executor]:
    """So many threads, each of which waits for a process.

    Args:
        jobs: how many.
        stop: ends what the threads wait for, when the block is left.

    Raises:
        ScenarioError: no such number.
    """
    if isinstance(jobs, bool) or not isinstance(jobs, int) or not 1 <= jobs <= _MOST_JOBS:
        raise ScenarioError(f"jobs = {as_written(jobs)} must be a whole number from 1 to {_MOST_JOBS}")
    executor = ThreadPoolExecutor(jobs)
    try:
        yield executor
    finally:
        executor.shutdown(wait=False, cancel_futures=True)
        stop()
        executor.shutdown(wait=True)


@contextmanager
def cluster(address: str, *, packages: Sequence[Path] = ()) -> Iterator[Executor]:
    """The workers of a Dask scheduler; those that come later join.

    Compiled functions of this machine are sent to every worker once, as it comes.

    Args:
        address: of the scheduler, as tcp://host:8786.
        packages: archives from which the workers import besides, as what they are to run may.

    Raises:
        MissingExtraError: dask.distributed is not installed.
        ClusterError: nobody answers there, no worker comes, or the versions differ.
    """
    try:
        from distributed import Client
    except ImportError:
        raise MissingExtraError(
            f"--scheduler {address}: a cluster needs dask.distributed; install nospill[cluster]"
        ) from None
    from nospill.sweeps.cluster_set_up import require_alike, sent_functions

    try:
        client = Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError, TimeoutError) as error:
        reason = " ".join(str(error).split())[:160] or type(error).__name__
        raise ClusterError(
            f"--scheduler {address}: nobody answers there ({reason}); start one with `dask scheduler` and give the "
            "address that it prints"
        ) from None
    # Where a scheduler goes away it would print what it tries in vain; the error says it in one line.
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    with client:
        require_alike(client, address, patience=_PATIENCE)
        client.register_plugin(sent_functions())
        for archive in packages:
            client.upload_file(str(archive))
        yield client.get_executor(pure=False)


def usual_jobs() -> int:
    """As many processes as this one may run at once."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
