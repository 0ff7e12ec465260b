"""Which starting motions a search tries, in which order and how."""

from __future__ import annotations

from dataclasses import dataclass

from nospill.planning.task import Task
from nospill.transcription.solvers.options import FROM_AFAR, Options
from nospill.transcription.starting_motions import Start, starting_motions

_FIRST_STARTS, _LAST_STARTS = 3, 4
STEP_BY_STEP = {**FROM_AFAR, "max_iterations": 150}
_ADAPTIVE = {"kkt_error_globalization": True, "max_iterations": 150}
_PATIENT = {"max_iterations": 500}


@dataclass(frozen=True, slots=True)
class Attempt:
    """A start and how it is tried.

    Attributes:
        start: the motion.
        options: of the solve.
        all_rows: whether all rows take part from the beginning.
    """

    start: Start
    options: Options
    all_rows: bool = False


def first_attempts(task: Task) -> int:
    """How many of its attempts a brief search makes: without those for when nothing is found."""
    return max(task.searched_scene.planning.starts, _FIRST_STARTS)


def attempts(task: Task) -> tuple[Attempt, ...]:
    """The attempts of a search, one after the other.

    Starts alternate between two barrier strategies: a problem that stalls under one often converges under the other; on
    planes the adaptive one comes first. Where none of the first leads anywhere, a random start with more iterations
    often does; then come, with all rows, the usual two again and further random ones.
    """
    turns, count = [STEP_BY_STEP, _ADAPTIVE], first_attempts(task)
    starts = list(enumerate(starting_motions(task.searched_scene, count + _LAST_STARTS)))
    first = [Attempt(start, turns[(index + task.leads_past) % 2]) for index, start in starts[:count]]
    last = [Attempt(start, turns[index % 2] | _PATIENT, all_rows=index > count) for index, start in starts[count:]]
    again = [Attempt(starts[1][1], _ADAPTIVE, all_rows=True), Attempt(starts[0][1], STEP_BY_STEP, all_rows=True)]
    return (*first, last[0], *again, *last[1:])
