"""Why a motion that was found could not be brought to a certificate."""

from __future__ import annotations

from nospill.certification.verdict import Row
from nospill.certification.wording import describe
from nospill.errors import MOTION, NOT_CONVERGED, ModelError, NoSolutionError, Reason
from nospill.scene.scene import Scene


def not_playable(scene: Scene, duration: float, intervals: int, error: ModelError) -> NoSolutionError:
    """The error where the joints cannot follow a motion of `duration` s between its nodes."""
    return NoSolutionError(
        f"No motion found: one of {duration:.3f} s on {intervals} intervals cannot be played, {error}. "
        "Try another planning.intervals or a path away from singularities.",
        Reason(NOT_CONVERGED, "singularity", scene.robot.name),
    )


def infeasible_with_more(worst: Row, duration: float) -> NoSolutionError:
    """The error where a motion of `duration` s was found for some objects and variants, and none for more of them.

    Args:
        worst: what that motion breaks.
        duration: of that motion, s.
    """
    advice = "Narrow the tolerance or the range of speeds, state" if worst.variant else "State"
    return NoSolutionError(
        f"No motion found, though there is one of {duration:.3g} s for some of the objects and variants: "
        f"there {describe(worst)}. {advice} a longer motion.duration or relax that limit.",
        Reason(MOTION, worst.constraint, worst.subject, excess=worst.use - 1.0),
    )
