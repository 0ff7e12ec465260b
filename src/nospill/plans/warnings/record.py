"""A warning, what it is made from, and its line for people."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from nospill.certification.certificate import Judgement
from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class PlanWarning:
    """Something that a certified plan rests on and that a user should know.

    Attributes:
        name: what it is about; the same for all subjects.
        subject: object, joint or robot.
        text: one sentence with value and limit, and what to try.
        value: SI, or None where there is no figure.
        limit: SI; beyond it the warning is given. None where there is none.
    """

    name: str
    subject: str
    text: str
    value: float | None = None
    limit: float | None = None


@dataclass(frozen=True, slots=True)
class Facts:
    """What warnings are made from.

    Attributes:
        scene: the task.
        judgement: of the motion, with its replay.
        backoff: fraction of the budget kept from the optimiser, by "constraint | subject".
        fallbacks: what planning took in the place of what was asked for, a sentence each.
    """

    scene: Scene
    judgement: Judgement
    backoff: Mapping[str, float]
    fallbacks: Sequence[str] = ()


_NAMED = 6
"""Others that a line names."""

Warn = Callable[[Facts], Iterator[PlanWarning]]
"""One kind of warning: a warning for each subject that gives cause."""


def warning_lines(warnings: Sequence[PlanWarning]) -> list[str]:
    """One line for each kind: the first subject's sentence, and the names of the others."""
    return [": ".join(row) for row in warning_rows(warnings)]


def warning_rows(warnings: Sequence[PlanWarning]) -> list[tuple[str, str, str]]:
    """The same in parts: what about, the first subject, its sentence and the names of the others."""
    kinds: dict[str, list[PlanWarning]] = {}
    for warning in warnings:
        kinds.setdefault(warning.name, []).append(warning)
    return [_row(kind) for kind in kinds.values()]


def _row(kind: Sequence[PlanWarning]) -> tuple[str, str, str]:
    first, *others = kind
    names = list(dict.fromkeys(other.subject for other in others if other.subject != first.subject))
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    also = f" Likewise: {', '.join(names[:_NAMED])}{more}." if names else ""
    return first.name, first.subject, f"{first.text}{also}"
