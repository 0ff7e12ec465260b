"""The errors a user can meet, each with the exit code the command line returns."""

from __future__ import annotations

from dataclasses import dataclass


class NospillError(Exception):
    """Base of every error nospill raises on purpose: one line that says what, where, the value and what to try."""

    exit_code = 2


class ScenarioError(NospillError):
    """The input is wrong: a scenario, a robot, a path or a file it names."""


class PlanFolderError(NospillError):
    """A plan folder is missing, incomplete or was changed so that it cannot be read."""


class ModelError(NospillError):
    """A physical model is asked beyond its validity, for example liquid in a cup that is not pressed down."""


@dataclass(frozen=True, slots=True)
class Change:
    """A single change of a scenario that lets a motion be found.

    Attributes:
        what: what is in the way, for people. place: key in the scenario. value: its new value, SI.
        text: the change in words.
    """

    what: str
    place: str
    value: float
    text: str


class NoSolutionError(NospillError):
    """No motion was found; the message names what stands in the way and the smallest change that helps.

    Attributes:
        kind: "slow motion" (impossible even nearly at rest), "in motion", or "not converged".
        changes: single changes, smallest first; empty where none was found.
    """

    exit_code = 3

    def __init__(self, message: str, kind: str = "not converged", changes: tuple[Change, ...] = ()) -> None:
        super().__init__(message)
        self.kind = kind
        self.changes = changes


class MissingExtraError(NospillError):
    """An optional library is needed for this call; the message says which extra installs it."""
