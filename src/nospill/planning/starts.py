"""Which starting motions a search tries, in which order and how, and when their answers agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from nospill.scene.scene import Scene
from nospill.transcription.starting_motions import Start, starting_motions

COARSE_ITERATIONS = 150
SECOND_ITERATIONS = 60
"""Of a start once there is an answer."""

_FIRST_STARTS = 3
_LAST_ITERATIONS = 500
_LAST_STARTS = 4
_SAME = 1e-3


@dataclass(frozen=True, slots=True)
class Attempt:
    """A start and how it is tried.

    Attributes:
        start: the motion.
        iterations: most of them as long as there is no answer.
        kkt_error_globalization: whether steps are accepted by the error of the optimality conditions (`SolveOptions`).
        all_rows: whether all rows take part from the beginning.
    """

    start: Start
    iterations: int = COARSE_ITERATIONS
    kkt_error_globalization: bool = False
    all_rows: bool = False


def attempts(scene: Scene, *, brief: bool) -> tuple[Attempt, ...]:
    """The attempts of a search, one after the other; brief: without those for when nothing is found.

    Starts alternate between IPOPT's two globalisations: a problem that stalls under one often converges under the
    other. Where none of the first leads anywhere, a random start with more iterations often does; then come, with all
    rows, the usual two again and further random ones.
    """
    count = max(scene.planning.starts, _FIRST_STARTS)
    starts = list(starting_motions(scene, count + _LAST_STARTS))
    turns = [index % 2 == 1 for index in range(len(starts))]
    first = [Attempt(start, kkt_error_globalization=turn) for start, turn in zip(starts[:count], turns, strict=False)]
    if brief:
        return tuple(first)
    patient = Attempt(starts[count], _LAST_ITERATIONS, turns[count])
    again = [Attempt(starts[1], kkt_error_globalization=True, all_rows=True), Attempt(starts[0], all_rows=True)]
    further = [
        Attempt(start, _LAST_ITERATIONS, turn, all_rows=True)
        for start, turn in zip(starts[count + 1 :], turns[count + 1 :], strict=True)
    ]
    return (*first, patient, *again, *further)


def agreed(scene: Scene, durations: Sequence[float]) -> bool:
    """Whether two answers of these durations are the same.

    That is enough, except for perfectly still liquids, which have poor local minima.
    """
    if scene.motion.end == "still" and any(cargo.filling for cargo in scene.cargo):
        return False
    return sum(duration <= min(durations) * (1 + _SAME) for duration in durations) >= 2
