"""Why there is no motion, and the smallest single change that would give one: at rest, for the robot, in motion."""

from nospill.diagnosis.certification import infeasible_with_more as infeasible_with_more
from nospill.diagnosis.certification import not_playable as not_playable
from nospill.diagnosis.leaning import MOST_LEAN as MOST_LEAN
from nospill.diagnosis.leaning import require_bearable_lean as require_bearable_lean
from nospill.diagnosis.motion import last_resort as last_resort
from nospill.diagnosis.quasi_static import is_hopeless as is_hopeless
from nospill.diagnosis.reach import advised as advised
from nospill.diagnosis.search import Answer as Answer
from nospill.diagnosis.search import Searcher as Searcher
from nospill.diagnosis.search import Trial as Trial

__all__ = [
    "MOST_LEAN",
    "Answer",
    "Searcher",
    "Trial",
    "advised",
    "infeasible_with_more",
    "is_hopeless",
    "last_resort",
    "not_playable",
    "require_bearable_lean",
]
