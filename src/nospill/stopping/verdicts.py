"""The verdict on a stop: as its receiver plays it, from a few samples of the plan before it to a second of rest after.

Every limit is judged while the arm stands after the end too: liquids may swing on. Of the stop itself every row has to
leave what a finer grid may find, as rows of a plan do: a verdict on the whole motion from rest has another grid.
What breaks one of the limits themselves is not looked at further: distances between bodies are left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.by_flow import steep_flows
from nospill.certification.certificate import Judgement, judge_first, judge_motion, judge_roughly
from nospill.certification.tracks import judged_tracks
from nospill.certification.verdict import Row, Trace, worst_row
from nospill.errors import ModelError
from nospill.laws.constraints.base import RowId
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.plans.state import rest_of
from nospill.scene.scene import Scene
from nospill.stopping.physics import stays
from nospill.stopping.splices import Splice

_SWINGS_ON = 1.0
"""s after the end, over which every limit is judged: three swings of a liquid of 35 mm, and the highest are first."""
_OVERSHOOTS = 3
"""Samples after the instant, within which what breaks is a matter of the jump of the jerk: a twelfth of it is left."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What is found of a stop.

    Attributes:
        record: of the stop, where every row holds with the liquids that the judge finds.
        judgement: from its first instant on, on its own clock; its replay begins with what was judged.
        at_splice: use of the limits that plan and stop together break where the stop takes over.
        stays: whether objects stay by the whole physics, where every row holds.
        doubted: liquids whose flow is in doubt, steeper than waves that stand, where every row holds.
    """

    record: Trajectory
    judgement: Judgement
    at_splice: dict[RowId, float]
    stays: bool
    doubted: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether every row holds, before the stop too, and those of the stop leave what a finer grid may find."""
        return not self.at_splice and self.judgement.leaves_margin


def swinging_on(scene: Scene) -> Scene:
    """The scene with the time after the end in which liquids are looked at."""
    return replace(scene, motion=replace(scene.motion, hold_after=_SWINGS_ON))


def looked_at(record: Trajectory, scene: Scene, splice: Splice | None) -> Verdict | None:
    """What a rough look finds of the samples of a stop, which then is going to be changed, or the verdict on them.

    None where its liquids have no answer. Arguments as of `judged_stop`.
    """
    played = _Played.of(record, scene, splice)
    try:
        found = played.verdict(judge_roughly(played.record, played.scene, motion=played.motion))
    except (ModelError, np.linalg.LinAlgError):
        return None
    return played.judged() if found.ok else found


def judged_stop(record: Trajectory, scene: Scene, splice: Splice | None) -> Verdict | None:
    """The verdict on the samples of a stop; None where its liquids have no answer.

    Args:
        record: on a clock that begins with the stop.
        scene: of the stop, with its rest; it begins in a state of the plan.
        splice: where the stop takes over from its plan; None where no motion is known before it.
    """
    return _Played.of(record, scene, splice).judged()


@dataclass(frozen=True, slots=True)
class _Played:
    """A stop as its receiver plays it: the record that is judged, and where in it the stop begins, s."""

    stop: Trajectory
    record: Trajectory
    scene: Scene
    motion: JointMotion | None
    wait: float
    early: float

    @classmethod
    def of(cls, record: Trajectory, scene: Scene, splice: Splice | None) -> _Played:
        if splice is None:
            return cls(record, record, scene, None, 0.0, 0.0)
        joined, motion = splice.joined(record)
        return cls(record, joined, splice.scene, motion, splice.wait, splice.wait + _OVERSHOOTS / record.rate)

    def judged(self) -> Verdict | None:
        """The verdict; None where liquids or joints have no answer."""
        try:
            first = judge_first(self.record, self.scene, motion=self.motion)
            if not (found := self.verdict(first)).ok:
                return found
            whole = judge_motion(self.record, self.scene, motion=self.motion, first=first)
        except (ModelError, np.linalg.LinAlgError):
            return None
        tracks = judged_tracks(self.record, self.scene, whole.replay, whole.traces)
        slosh = rest_of(replace(self.record, slosh=tracks), self.wait).slosh
        kept = whole.certificate.ok and stays(self.record, self.scene, motion=self.motion, since=self.wait)
        record, doubted = replace(self.stop, slosh=slosh), tuple(steep_flows(self.scene, whole.replay))
        return replace(self.verdict(whole), record=record, stays=kept, doubted=doubted)

    def verdict(self, judgement: Judgement) -> Verdict:
        """What a judgement says of the stop, of which it does not say that it stays."""
        return Verdict(self.stop, _since(judgement, self.wait), _at_splice(judgement, self.early), stays=False)


def _at_splice(judgement: Judgement, early: float) -> dict[RowId, float]:
    """Use of the limits that are broken before a time, s."""
    return {row.id: row.use for row in judgement.certificate.rows if not row.ok and row.at_s < early}


def _since(judgement: Judgement, wait: float) -> Judgement:
    """A verdict from an instant on, on a clock that begins there."""
    cuts = {id(trace): _cut(trace, wait) for trace in (*judgement.traces, *judgement.fullest.values())}
    fullest = {key: cut for key, trace in judgement.fullest.items() if (cut := cuts[id(trace)]) is not None}
    distances = [_later(row, wait) for row in judgement.certificate.rows if row.id not in judgement.fullest]
    rows = (*map(worst_row, fullest.values()), *distances)
    ok = all(row.ok for row in rows) and not judgement.certificate.unjudged
    return replace(
        judgement,
        certificate=replace(judgement.certificate, ok=ok, rows=rows),
        traces=tuple(cut for trace in judgement.traces if (cut := cuts[id(trace)]) is not None),
        end_time=judgement.end_time - wait,
        corners=(),
        corner_use={},
        fullest=fullest,
    )


def _cut(trace: Trace, wait: float) -> Trace | None:
    """A trace from an instant on; None where it has none of those."""
    late = slice(int(np.searchsorted(trace.t, wait - 1e-9)), None)
    if late.start == len(trace.t):
        return None
    columns = {name: getattr(trace, name)[late] for name in ("t", "value", "limit", "margin")}
    columns["t"] = columns["t"] - wait
    return replace(trace, **columns, linear=None if trace.linear is None else trace.linear[late])


def _later(row: Row, wait: float) -> Row:
    return replace(row, at_s=row.at_s - wait)
