"""What planning took in the place of what was asked for: one sentence for each, so that no fallback is silent."""

from __future__ import annotations

from nospill.planning.candidate import Candidate
from nospill.planning.log import Log
from nospill.transcription.resampling import fine_intervals

REST_INSTEAD = "no faster motion from this state was certified: what is left of the motion before was taken"
_COARSER = 0.75
"""Part of the intervals of the fine grid; the coarse grid and the one halfway have less, and rounding takes few."""


def on_path_instead(why: str) -> str:
    """That the tray keeps to its path though it may leave it; `why` the first other motion was not certified."""
    reason = why.removesuffix(".")
    return f"no faster motion off the path was certified: {reason}; the motion on the path itself was taken"


def fallbacks(taken: Candidate, log: Log, *sentences: str) -> tuple[str, ...]:
    """All that is to be said of a motion.

    Args:
        taken: the motion.
        log: of the call.
        sentences: known already; empty ones are left out.
    """
    scene, stages, planning = taken.active.task.scene, taken.stages, taken.active.task.scene.planning
    texts = [sentence for sentence in sentences if sentence]
    wanted = fine_intervals(taken.active.scene, stages.duration)
    if stages.intervals < _COARSER * wanted:
        texts.append(
            f"no solve on {wanted} intervals converged: the motion on {stages.intervals} was taken, which may be slower"
        )
    if taken.active.task.passage.level and scene.motion.without_freedom() != scene.motion:
        texts.append("no motion past the singularity was found but with a level tray on its path: that one was taken")
    if taken.active.task.smooth_alone:
        texts.append(
            "no motion that stills waves of second order by their timing was certified: one that stills them by "
            "smoothness was taken, which is slower"
        )
    if not taken.has_converged:
        texts.append(
            f"the last solve ended before it converged ({taken.solution.status}): its motion was taken, and a faster "
            "one may exist"
        )
    if log.out_of_time:
        texts.append(
            f"planning ended at planning.max_plan_time = {planning.max_plan_time:g} s: the best motion until then was "
            "taken; allow more"
        )
    return tuple(texts)
