"""Work shared out with a forked process: results as by one process, whatever becomes of the fork."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pytest

from nospill.core import processes
from nospill.core.processes import shared_out

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="forks are made on Linux alone")

ITEMS = range(12)


@pytest.fixture(autouse=True)
def two_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NOSPILL_THREADS", "2")


@pytest.fixture(autouse=True)
def no_process_left(two_at_once: None) -> Iterator[None]:
    yield
    assert not multiprocessing.active_children()


def in_fork() -> bool:
    """Whether it is called in a forked process."""
    return multiprocessing.parent_process() is not None


def beside_fork(work: Callable[[int], Any]) -> Callable[[int], Any]:
    """Work that begins here only when the fork has begun an item, however long that takes on a busy machine."""
    begun = multiprocessing.get_context("fork").Event()

    def waited(item: int) -> Any:
        if in_fork():
            begun.set()
        else:
            assert begun.wait(60.0)
        return work(item)

    return waited


def worker_of(item: int) -> tuple[int, int]:
    time.sleep(0.01)
    return item, os.getpid()


def test_results_are_in_the_order_of_the_items_and_two_processes_work() -> None:
    found = shared_out(beside_fork(worker_of), ITEMS)
    assert [item for item, _ in found] == [*ITEMS]
    workers = {process for _, process in found}
    assert os.getpid() in workers
    assert len(workers) == 2


def test_what_is_not_of_the_module_is_shared_out_too_and_arrays_come_back() -> None:
    factor = np.arange(100_000.0)  # more than a pipe holds
    found = shared_out(beside_fork(lambda item: (time.sleep(0.01), item * factor)[1]), ITEMS)
    for item, values in zip(ITEMS, found, strict=True):
        np.testing.assert_array_equal(values, item * factor)


@pytest.mark.parametrize("items", [(), (3,), range(10_001)])
def test_nothing_is_forked_for_few_items_or_too_many(items: Sequence[int]) -> None:
    assert shared_out(lambda item: (item, os.getpid()), items) == [(item, os.getpid()) for item in items]


def test_as_many_items_as_are_shared_out_at_most() -> None:
    assert shared_out(lambda item: -item, range(10_000)) == [-item for item in range(10_000)]


def test_one_thread_is_one_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NOSPILL_THREADS", "1")
    assert {process for _, process in shared_out(worker_of, ITEMS)} == {os.getpid()}


def test_no_fork_off_the_main_thread() -> None:
    found: list[tuple[int, int]] = []
    thread = threading.Thread(target=lambda: found.extend(shared_out(worker_of, ITEMS)))
    thread.start()
    thread.join()
    assert found == [(item, os.getpid()) for item in ITEMS]


def test_no_fork_of_a_fork() -> None:
    found = shared_out(beside_fork(lambda _: (os.getpid(), shared_out(worker_of, range(3)))), range(4))
    forked = [(process, within) for process, within in found if process != os.getpid()]
    assert forked
    for process, within in forked:
        assert within == [(item, process) for item in range(3)]


@pytest.mark.parametrize("end", [lambda: os.kill(os.getpid(), signal.SIGKILL), lambda: 1 / 0, lambda: os._exit(0)])
def test_items_of_a_fork_that_ends_are_done_here(end: Callable[[], None]) -> None:
    def work(item: int) -> tuple[int, int]:
        if in_fork():
            end()
        return worker_of(item)

    assert shared_out(beside_fork(work), ITEMS) == [(item, os.getpid()) for item in ITEMS]


def test_items_are_done_here_where_the_system_refuses_a_fork(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse() -> int:
        raise OSError("out of memory")

    monkeypatch.setattr(os, "fork", refuse)
    assert shared_out(worker_of, ITEMS) == [(item, os.getpid()) for item in ITEMS]


def test_items_of_a_silent_fork_are_done_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "_PATIENCE", 0.1)

    def work(item: int) -> tuple[int, int]:
        if in_fork():
            time.sleep(600.0)
        return worker_of(item)

    assert shared_out(beside_fork(work), ITEMS) == [(item, os.getpid()) for item in ITEMS]


def test_a_result_that_cannot_be_sent_is_worked_out_here() -> None:
    found = shared_out(beside_fork(lambda item: (time.sleep(0.01), lambda: item)[1]), ITEMS)
    assert [result() for result in found] == [*ITEMS]


@pytest.mark.parametrize("bad", [0, 7, 11])
def test_an_error_of_an_item_is_raised_here_wherever_it_was_met(bad: int) -> None:
    def work(item: int) -> int:
        time.sleep(0.01)
        if item == bad:
            raise ValueError(f"item {item}")
        return item

    with pytest.raises(ValueError, match=f"^item {bad}$"):
        shared_out(work, ITEMS)


def test_an_interrupt_ends_both() -> None:
    def work(item: int) -> int:
        if in_fork():
            time.sleep(600.0)
        time.sleep(0.05)
        if item == 5:
            signal.raise_signal(signal.SIGINT)
        return item

    with pytest.raises(KeyboardInterrupt):
        shared_out(beside_fork(work), ITEMS)


def test_the_fork_leaves_an_interrupt_to_its_parent() -> None:
    def work(item: int) -> tuple[int, int]:
        time.sleep(0.01)
        if in_fork():
            os.kill(os.getpid(), signal.SIGINT)
        return worker_of(item)

    assert {process for _, process in shared_out(beside_fork(work), ITEMS)} > {os.getpid()}


def test_no_descriptor_is_left_open() -> None:
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(3):
        shared_out(worker_of, ITEMS)
    assert len(os.listdir("/proc/self/fd")) == before
