"""Why there is no motion, and the smallest single change that would give one: at rest, for the robot, in motion."""

from nospill.reasons.changes import changed_table as changed_table
from nospill.reasons.changes import with_change as with_change
from nospill.reasons.motion import last_resort as last_resort
from nospill.reasons.reach import advised as advised
from nospill.reasons.search import Searcher as Searcher
from nospill.reasons.slow import is_hopeless as is_hopeless

__all__ = ["Searcher", "advised", "changed_table", "is_hopeless", "last_resort", "with_change"]
