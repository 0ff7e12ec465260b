"""Why there is no motion, and the smallest single change that would give one: at rest, for the robot, in motion."""

from nospill.diagnosis.certification import infeasible_with_more as infeasible_with_more
from nospill.diagnosis.certification import not_playable as not_playable
from nospill.diagnosis.motion import last_resort as last_resort
from nospill.diagnosis.quasi_static import is_hopeless as is_hopeless
from nospill.diagnosis.reach import advised as advised
from nospill.diagnosis.search import Searcher as Searcher
from nospill.path_search.branches import free_paths as free_paths
from nospill.path_search.free_path import freest_way as freest_way
from nospill.path_search.free_path import paths_along as paths_along

__all__ = ["Searcher", "advised", "is_hopeless", "last_resort"]
