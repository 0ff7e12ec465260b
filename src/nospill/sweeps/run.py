"""Planning a sweep: what has no line yet, group by group, wherever the executor plans it."""

from __future__ import annotations

import base64
import hashlib
import io
import shutil
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, as_completed
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from nospill.errors import ClusterError, PlanFolderError
from nospill.sweeps.definition import SweepDefinition
from nospill.sweeps.executors import cluster, this_machine
from nospill.sweeps.groups import WORKERS, Order, plan_group
from nospill.sweeps.lines import LinesFile, lines_file
from nospill.sweeps.points import CRASH, OF_THE_MACHINE, Group, Line, grouped
from nospill.sweeps.record import Sweep

LINES_FILE = "lines.jsonl"
PLANS_FOLDER = "plans"


@dataclass(frozen=True, slots=True)
class SweepProgress:
    """Where a sweep stands.

    Attributes:
        done: points with a line. total: of the sweep.
        certified: of those that are done.
        left_s: time left, s, as far as it can be told; None before the first line.
        again: whether points are planned from nothing once more.
    """

    done: int
    total: int
    certified: int
    left_s: float | None
    again: bool = False


OnProgress = Callable[[SweepProgress], None]


def run_sweep(
    definition: SweepDefinition,
    *,
    folder: Path | None = None,
    jobs: int = 1,
    scheduler: str | None = None,
    plans: bool = False,
    retry: bool = False,
    progress: OnProgress | None = None,
) -> Sweep:
    """Plan the points that have no line yet; see `sweep` for the arguments.

    Raises:
        ScenarioError, ClusterError, MissingExtraError, PlanFolderError: as `sweep`.
    """
    groups = grouped(definition.points, definition.axes)
    with _lines(folder) as (place, file):
        wanted = {point.key for point in definition.points}
        found = _known(file, wanted)
        if retry:
            found = {key: line for key, line in found.items() if key[1] or line.ending not in OF_THE_MACHINE}
        order = Order(definition.text, definition.base.name, definition.limits, keep=plans)
        where = this_machine(jobs, WORKERS.stop) if scheduler is None else cluster(scheduler)
        todo = list(_left(groups, found))
        meter = _Meter(progress, definition, found, sum(len(group.points) for group in todo))
        with _opened(where, todo, scheduler) as executor:

            def planned(order: Order, groups: Sequence[Group]) -> None:
                for group, answers in _answers(executor, order, groups, scheduler):
                    for line, packed in answers:
                        if packed:
                            _unpack(packed, place / PLANS_FOLDER / line.key)
                        file.append(line.to_dict())
                        found[line.key, line.cold] = line
                    meter.passed(len(group.points), again=order.cold)

            planned(order, todo)
            again = _again(definition, found)
            meter.begin(sum(len(group.points) for group in again))
            planned(replace(order, cold=True, keep=False), again)
    return _record(definition, found)


Known = dict[tuple[str, bool], Line]
"""Key of a point, and whether it is the line from nothing once more -> line."""


@contextmanager
def _lines(folder: Path | None) -> Iterator[tuple[Path, LinesFile]]:
    """The file of lines in a folder, or in one that lasts as long as the run."""
    with tempfile.TemporaryDirectory() as passing:
        place = Path(passing) if folder is None else folder
        with lines_file(place / LINES_FILE) as file:
            yield place, file


def _known(file: LinesFile, wanted: set[str]) -> Known:
    found: Known = {}
    for entry in file.known:
        try:
            line = Line.from_dict(entry)
        except TypeError:
            raise PlanFolderError(f"{LINES_FILE}: has lines that no sweep wrote; name another folder") from None
        if line.key in wanted:
            found[line.key, line.cold] = line  # the last one counts
    return found


def _left(groups: Iterable[Group], found: Known) -> Iterator[Group]:
    """Groups with the points that have no line; without a head where that is known to have no motion."""
    for group in groups:
        points = tuple(point for point in group.points if (point.key, False) not in found)
        head = None if group.head is None else found.get((group.head.key, False))
        if points:
            yield Group(None if head is not None and not head.figures else group.head, points)


def _again(definition: SweepDefinition, found: Known) -> list[Group]:
    """Points planned warm that are planned from nothing too: the best, and a sample by the hash of their keys."""
    record = _record(definition, found)
    warm = [point for point in definition.points if (line := found.get((point.key, False))) and line.warm_from]
    chosen = sorted(warm, key=lambda point: hashlib.sha256(point.key.encode()).digest())[: definition.again_cold]
    best = record.best
    if best is not None and best.warm_from and definition.again_cold:
        chosen = [point for point in warm if point.key == best.key] + [one for one in chosen if one.key != best.key]
    return [Group(None, (point,)) for point in chosen if (point.key, True) not in found]


def _record(definition: SweepDefinition, found: Known) -> Sweep:
    lines = [found.get((point.key, False)) for point in definition.points]
    cold = [found.get((point.key, True)) for point in definition.points]
    return Sweep(definition, tuple(line for line in lines if line), tuple(line for line in cold if line))


@contextmanager
def _opened(
    where: AbstractContextManager[Executor], todo: Sequence[Group], scheduler: str | None
) -> Iterator[Executor | None]:
    """The executor; none is opened where everything has its line, unless a cluster was named, which may be wrong."""
    if not todo and scheduler is None:
        with this_machine(1, WORKERS.stop) as executor:
            yield executor
        return
    with where as executor:
        yield executor


def _answers(
    executor: Executor | None, order: Order, groups: Sequence[Group], scheduler: str | None
) -> Iterator[tuple[Group, list[tuple[Line, str]]]]:
    """Groups with their lines, as they are done."""
    assert executor is not None
    futures = {executor.submit(plan_group, order, group): group for group in groups}
    for future in as_completed(futures):
        group = futures[future]
        try:
            yield group, future.result()
        except CancelledError:
            raise ClusterError(
                f"--scheduler {scheduler}: went away; what has a line is kept, and the same command goes on"
            ) from None
        except Exception as error:
            if scheduler is None:
                raise
            reason = f"its worker died: {' '.join(str(error).split())[:200]}"
            yield group, [(Line(point.key, point.values, CRASH, reason, cold=order.cold), "") for point in group.points]


def _unpack(packed: str, place: Path) -> None:
    partial = place.with_name(f".{place.name}.partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    with zipfile.ZipFile(io.BytesIO(base64.b64decode(packed))) as archive:
        archive.extractall(partial)
    shutil.rmtree(place, ignore_errors=True)
    partial.rename(place)


class _Meter:
    """Counts points and time."""

    def __init__(self, progress: OnProgress | None, definition: SweepDefinition, found: Known, left: int) -> None:
        self._progress, self._total, self._found = progress, len(definition.points), found
        self.begin(left)

    def begin(self, left: int) -> None:
        """So many points are left, of this pass."""
        self._began, self._passed, self._left = time.monotonic(), 0, left
        if left:
            self._say(None, again=False)

    def passed(self, count: int, *, again: bool) -> None:
        """So many more are done."""
        self._passed += count
        pace = (time.monotonic() - self._began) / self._passed
        self._say(pace * (self._left - self._passed), again=again)

    def _say(self, left: float | None, *, again: bool) -> None:
        if self._progress is not None:
            lines = [line for (_, cold), line in self._found.items() if not cold]
            certified = sum(line.certified for line in lines)
            self._progress(SweepProgress(len(lines), self._total, certified, left, again))
