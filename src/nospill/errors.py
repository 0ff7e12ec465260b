"""The errors a user can meet, each with the exit code the command line returns."""

from __future__ import annotations

from dataclasses import dataclass

REST, ROBOT, MOTION, NOT_CONVERGED = "at rest", "robot", "in motion", "not converged"
"""Kinds of reasons: proven impossible even standing still; the arm cannot follow the path; no motion keeps the limits
in the time allowed; no motion was found, and nothing says that there is none."""

Setting = float | str | list[float] | list[str]
"""A value in a scenario file, SI where it is a number."""


_IN_PLACE_OF = {"motion.path_jerk_limit": "motion.max_jerk"}
"""Key of a change -> the other key for the same limit."""


@dataclass(frozen=True, slots=True)
class Change:
    """A single change of a scenario that lets a motion be found; `scene.changed(change.values)` makes it.

    Attributes:
        what: what is in the way, for people.
        place: key in the scenario, as "tray.friction", "cargo.c2.mass" (by the object's name) or
            "cargo.*.max_slosh_height" (every object that states the key, or all).
        value: its new value, SI.
        text: the change in words.
        constraint: of the certificate whose limit it widens, as a row names it; empty where it is about no limit.
        subject: that needs it most, likewise.
    """

    what: str
    place: str
    value: Setting
    text: str
    constraint: str = ""
    subject: str = ""

    @classmethod
    def of_limit(cls, constraint: str, subject: str, place: str, value: Setting, text: str) -> Change:
        """A change that widens the limit of a constraint on a subject."""
        return cls(f"{constraint} of {subject}", place, value, text, constraint, subject)

    @property
    def values(self) -> dict[str, Setting | None]:
        """What `Scene.changed` takes: the value at its place, and None for the key that it takes the place of."""
        other = _IN_PLACE_OF.get(self.place)
        return {self.place: self.value} | ({} if other is None else {other: None})


@dataclass(frozen=True, slots=True)
class Reason:
    """Why there is no motion, for programs.

    Attributes:
        kind: `REST`, `ROBOT`, `MOTION` or `NOT_CONVERGED`.
        constraint: what is in the way: a constraint of the certificate ("slip"), "reach", "singularity",
            "layout", "fill", "payload", "approach ..." or "planning".
        subject: which object, joint or robot.
        at_s: where on the path, from 0 to 1; None where no place can be named.
        excess: by how much, in `unit`.
        unit: of `excess`: "m", "rad", "kg", or "1" for a fraction of the limit.
        changes: single changes that help, smallest first; empty where none was found.
    """

    kind: str
    constraint: str
    subject: str
    at_s: float | None = None
    excess: float | None = None
    unit: str = "1"
    changes: tuple[Change, ...] = ()


class NospillError(Exception):
    """Base of every error nospill raises on purpose: one line that says what, where, the value and what to try.

    Attributes:
        reason: why there is no motion; None where the error is about something else, or nothing more is known.
    """

    exit_code = 2

    def __init__(self, message: str = "", reason: Reason | None = None) -> None:
        super().__init__(message)
        self.reason = reason

    @property
    def kind(self) -> str:
        """The kind of the reason; "not converged" where none is known."""
        return NOT_CONVERGED if self.reason is None else self.reason.kind

    @property
    def changes(self) -> tuple[Change, ...]:
        """Single changes of the scenario that help, smallest first; empty where none was found."""
        return () if self.reason is None else self.reason.changes


class ScenarioError(NospillError):
    """The input is wrong: a scenario, a robot, a path or a file it names."""


class PlanFolderError(NospillError):
    """A plan folder is missing, incomplete or was changed so that it cannot be read."""


class ModelError(NospillError):
    """A physical model beyond its validity, for example liquid in a cup that is not pressed down."""


class NoSolutionError(NospillError):
    """No motion was found; the message names what stands in the way and the smallest change that helps."""

    exit_code = 3


class MissingExtraError(NospillError):
    """An optional library is needed for this call; the message says which extra installs it."""


class ClusterError(NospillError):
    """A cluster cannot be used: nobody there, another version, a worker without the package."""
