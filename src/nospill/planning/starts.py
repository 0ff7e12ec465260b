"""Which starting motions a search tries, in which order, and when their answers agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from nospill.scene.scene import Scene
from nospill.transcription.starting_motions import Start, starting_motions

COARSE_ITERATIONS = 150
SECOND_ITERATIONS = 60
"""Of a start once there is an answer."""

_LAST_ITERATIONS = 500
_LAST_STARTS = 4
_SAME = 1e-3
_ALIKE = 5e-3


@dataclass(frozen=True, slots=True)
class Attempt:
    """A start and how it is tried.

    Attributes:
        start: the motion. iterations: how many it gets at most, as long as there is no answer.
        by_error: whether its steps count by their error (`SolveOptions`). all_rows: whether all rows take part.
    """

    start: Start
    iterations: int = COARSE_ITERATIONS
    by_error: bool = False
    all_rows: bool = False


def attempts(scene: Scene, *, briefly: bool) -> tuple[Attempt, ...]:
    """What a search tries one after the other; `briefly`: only what the scenario asks for.

    What one way of accepting steps wanders on without end, the other often solves at once: they take turns. Those
    beyond the number that is asked for are for when nothing is found: a random start with more patience, which often
    suffices; then, with all rows, the usual two again and further random ones.
    """
    count = scene.planning.starts
    starts = list(starting_motions(scene, further=_LAST_STARTS))
    turns = [index % 2 == 1 for index in range(len(starts))]
    asked = [Attempt(start, by_error=turn) for start, turn in zip(starts[:count], turns, strict=False)]
    if briefly:
        return tuple(asked)
    patient = Attempt(starts[count], _LAST_ITERATIONS, turns[count])
    again = [Attempt(starts[1], by_error=True, all_rows=True), Attempt(starts[0], all_rows=True)]
    further = [
        Attempt(start, _LAST_ITERATIONS, turn, all_rows=True)
        for start, turn in zip(starts[count + 1 :], turns[count + 1 :], strict=True)
    ]
    return (*asked, patient, *again, *further)


def agreed(scene: Scene, durations: Sequence[float]) -> bool:
    """Whether two answers of these durations are the same.

    That is enough, except for perfectly still liquids, which have poor local minima.
    """
    if scene.motion.end == "still" and any(cargo.filling for cargo in scene.cargo):
        return False
    return sum(duration <= min(durations) * (1 + _SAME) for duration in durations) >= 2


def alike(durations: Sequence[float]) -> int:
    """How many answers, by their durations, come to nearly the best of them; told in the report of a plan."""
    return sum(duration <= min(durations) * (1 + _ALIKE) for duration in durations)
