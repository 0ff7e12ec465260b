"""The errors a user can meet, each with the exit code the command line returns."""

from __future__ import annotations


class NospillError(Exception):
    """Base of every error nospill raises on purpose: one line that says what, where, the value and what to try."""

    exit_code = 2


class ScenarioError(NospillError):
    """The input is wrong: a scenario, a robot, a path or a file it names."""


class PlanFolderError(NospillError):
    """A plan folder is missing, incomplete or was changed so that it cannot be read."""


class ModelError(NospillError):
    """A physical model is asked beyond its validity, for example liquid in a cup that is not pressed down."""


class NoSolutionError(NospillError):
    """No motion was found; the message names the constraint that stands in the way."""

    exit_code = 3


class MissingExtraError(NospillError):
    """An optional library is needed for this call; the message says which extra installs it."""
