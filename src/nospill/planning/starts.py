"""Which starting motions a search tries, in which order and how."""

from __future__ import annotations

from dataclasses import dataclass

from nospill.transcription.starting_motions import Start, starting_motions
from nospill.transcription.task import Task

_FIRST_STARTS, _FIRST_ITERATIONS = 3, 150
_LAST_STARTS, _LAST_ITERATIONS = 4, 500


@dataclass(frozen=True, slots=True)
class Attempt:
    """A start and how it is tried.

    Attributes:
        start: the motion.
        iterations: most of them.
        kkt_error_globalization: whether steps are accepted by the error of the optimality conditions (`SolveOptions`).
        all_rows: whether all rows take part from the beginning.
    """

    start: Start
    iterations: int = _FIRST_ITERATIONS
    kkt_error_globalization: bool = False
    all_rows: bool = False


def attempts(task: Task, *, brief: bool) -> tuple[Attempt, ...]:
    """The attempts of a search, one after the other; brief: without those for when nothing is found.

    Starts alternate between IPOPT's two globalisations: a problem that stalls under one often converges under the
    other; on planes the filter comes second. Where none of the first leads anywhere, a random start with more
    iterations often does; then come, with all rows, the usual two again and further random ones.
    """
    scene, filter_first = task.searched_scene, not task.keeps_apart
    count = max(scene.planning.starts, _FIRST_STARTS)
    starts = list(enumerate(starting_motions(scene, count + _LAST_STARTS)))
    first = [Attempt(start, kkt_error_globalization=index % 2 == filter_first) for index, start in starts[:count]]
    if brief:
        return tuple(first)
    last = [Attempt(start, _LAST_ITERATIONS, index % 2 == 1, all_rows=index > count) for index, start in starts[count:]]
    again = [Attempt(starts[1][1], kkt_error_globalization=True, all_rows=True), Attempt(starts[0][1], all_rows=True)]
    return (*first, last[0], *again, *last[1:])
