"""A group of points as it is planned: by a process of its own beside the thread that waits for it.

This is what an executor is given, threads of this machine and workers of a cluster alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nospill.sweeps.points import CRASH, OUT_OF_MEMORY, OUT_OF_TIME, Group, Line, Point
from nospill.sweeps.processes import DiedError, Limits, RequestError, TooLargeError, Worker, WorkerPool

MODULE = "nospill.sweeps.planning_process"
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NOSPILL_THREADS": "1"}

WORKERS = WorkerPool(MODULE, ONE_THREAD)
"""Of this process; they stay for the next group, with their compiled functions and the head of the last one."""


@dataclass(frozen=True, slots=True)
class Order:
    """What is to be done with groups, the same for all of a sweep.

    Attributes:
        scenario: text of the base scenario, which needs no other file.
        name: of the base scenario.
        limits: of one point.
        keep: whether plan folders are wanted.
        cold: whether these are points that have a line, planned from nothing once more.
    """

    scenario: str
    name: str
    limits: Limits
    keep: bool = False
    cold: bool = False


Planned = tuple[Line, str]
"""A line, and its plan folder as packed text, empty where none is wanted."""


def plan_group(order: Order, group: Group) -> list[Planned]:
    """The lines of a group's points; never raises for what planning does.

    Raises:
        DiedError: the process was ended by `WORKERS.stop`.
    """
    head, found = group.head, []
    with _Asker(order) as asker:
        for point in _in_order(group):
            line, folder = _planned(asker, head, point)
            found.append((line, folder))
            if head is not None and point.key == head.key and not line.figures:
                head = None  # there is no plan to start from
    return found


def _in_order(group: Group) -> list[Point]:
    """The head first where it is wanted."""
    return sorted(group.points, key=lambda point: group.head is None or point.key != group.head.key)


def _planned(asker: _Asker, head: Point | None, point: Point) -> Planned:
    warm = None if head is None or head.key == point.key else {"key": head.key, "values": head.values}
    order = asker.order
    found: dict[str, Any]
    try:
        found = asker.ask({"values": point.values, "key": point.key, "warm": warm, "keep": order.keep})
    except RequestError as error:
        endings = {TooLargeError: OUT_OF_MEMORY, DiedError: CRASH}
        found = {"ending": endings.get(type(error), OUT_OF_TIME), "reason": str(error)}
    folder = found.pop("folder", "")
    return Line(point.key, point.values, cold=order.cold, **found), folder


class _Asker:
    """The process that plans a group; another one where it ends."""

    def __init__(self, order: Order) -> None:
        self.order = order
        self._worker: Worker | None = None

    def __enter__(self) -> _Asker:
        return self

    def __exit__(self, *_: object) -> None:
        if self._worker is not None:
            WORKERS.give_back(self._worker)

    def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """The answer; of a fresh process where one dies or grows too large: points before may be to blame.

        Raises:
            RequestError: there is none.
        """
        try:
            return self._asked(request)
        except (DiedError, TooLargeError):
            if self._worker is not None and not WORKERS.knows(self._worker):
                raise
            return self._asked(request)

    def _asked(self, request: dict[str, Any]) -> dict[str, Any]:
        worker = self._worker
        if worker is None or not worker.alive:
            if worker is not None:
                WORKERS.give_back(worker)
            worker = self._worker = WORKERS.take()
        told = (self.order.scenario, self.order.name)
        if worker.kept != told:
            worker.tell({"scenario": self.order.scenario, "name": self.order.name})
            worker.kept = told
        return worker.ask(request, self.order.limits)
