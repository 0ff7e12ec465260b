"""The segment from where the arm is to where the motion starts: planned, kept as a file, and judged.

The way is not led round obstacles; where the scenario states any, the judge looks whether it keeps away from them.
"""

from nospill.approach.judge import judge_segment
from nospill.approach.profile import Profile, jerk_limited, require_ruckig
from nospill.approach.search import Approach, find_approach
from nospill.approach.segment import Segment, read_segment, segment_text

__all__ = [
    "Approach",
    "Profile",
    "Segment",
    "find_approach",
    "jerk_limited",
    "judge_segment",
    "read_segment",
    "require_ruckig",
    "segment_text",
]
