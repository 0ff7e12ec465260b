"""Work on independent items, shared out between this process and a forked one.

A fork shares all memory as it stands, so that items need not be copied and nothing is imported twice; only results are
sent back. Which process works on an item does not change its result, and whatever goes wrong in the fork is done again
here: an error of an item is raised from here, and a fork that is refused, dies or is silent costs time only.
"""

from __future__ import annotations

import os
import signal
import struct
import sys
import threading
import time
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeVar

from nospill.core.batches import thread_count

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

Item = TypeVar("Item")
Result = TypeVar("Result")

_MOST_ITEMS = 10_000
"""Their numbers fit into a pipe."""
_NUMBER = struct.Struct("=I")
_PATIENCE = 10.0
"""s; a fork is waited for as long as the work here took, but for so long at least, before its items are done here."""


def shared_out(function: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """`[function(item) for item in items]`, by two processes where two may work at once (`NOSPILL_THREADS`).

    By this process alone off the main thread, in a daemonic process and on systems other than Linux, where a fork is
    not possible or not safe.

    Args:
        function: its result depends on the item only and can be pickled.
        items: what it is called with; at most 10,000 are shared out.
    """
    if not 1 < len(items) <= _MOST_ITEMS or not _may_fork():
        return [function(item) for item in items]
    import multiprocessing  # 7 ms, which no start-up needs

    numbers, source = os.pipe()
    os.write(source, b"".join(map(_NUMBER.pack, range(len(items)))))
    os.close(source)
    ours, theirs = multiprocessing.Pipe(duplex=False)
    fork = multiprocessing.get_context("fork").Process(
        target=_help, args=(function, items, numbers, theirs), daemon=True
    )
    began = time.monotonic()
    try:
        with warnings.catch_warnings(), suppress(OSError):
            # from Python 3.12 on a fork beside other threads warns; those here take no lock that the fork needs
            warnings.simplefilter("ignore", DeprecationWarning)
            fork.start()
        theirs.close()
        found = _taken(function, items, numbers)
        with suppress(EOFError, OSError):
            if ours.poll(max(_PATIENCE, time.monotonic() - began)):
                found |= ours.recv()
    finally:
        if fork.pid is not None:
            fork.kill()
            fork.join()
        os.close(numbers)
        ours.close()
    return [found[number] if number in found else function(item) for number, item in enumerate(items)]


def _may_fork() -> bool:
    """Whether a second process may work, and a fork is safe here."""
    if sys.platform != "linux" or thread_count() == 1 or threading.current_thread() is not threading.main_thread():
        return False
    import multiprocessing

    return not multiprocessing.current_process().daemon


def _taken(function: Callable[[Item], Result], items: Sequence[Item], numbers: int) -> dict[int, Result]:
    """Results by the numbers of the items, one number after the other read from a pipe that all processes share."""
    found = {}
    while read := os.read(numbers, _NUMBER.size):
        (number,) = _NUMBER.unpack(read)
        found[number] = function(items[number])
    return found


def _help(function: Callable[[Any], Any], items: Sequence[Any], numbers: int, results: Connection) -> None:
    """What the fork does; it leaves an interrupt to its parent, and an error to be met there."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(Exception):
        results.send(_taken(function, items, numbers))
