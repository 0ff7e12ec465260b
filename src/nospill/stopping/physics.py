"""Whether what stands on the tray stays there with the whole physics and nothing in reserve.

Published equations leave out the inertia of objects against tilting and that sliding and turning share one friction;
the reserves of a scenario make up for that while an object presses with most of its weight. A stop may relieve it of
most of that: then what is left out decides, and no reserve on friction is enough.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nospill.certification.replay import MINIMUM_RATE, replay
from nospill.certification.traces import constraint_traces
from nospill.errors import ModelError
from nospill.laws.constraints.base import EvaluationPoint, Role
from nospill.motion.holds import held_trajectory
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene


def stays(record: Trajectory, scene: Scene, *, motion: JointMotion | None = None, since: float = 0.0) -> bool:
    """Whether no object lifts, slides, tips or twists by the equations of full fidelity, with nothing in reserve.

    At full fidelity the certificate says so already, and more; nothing is computed.

    Args:
        record: of a certified motion.
        scene: its own, with the time for which the arm stands after it.
        motion: what the joints do; the quintic spline through the record when left out.
        since: s, from when on it is asked.
    """
    if scene.fidelity == "full":
        return True
    bare = replace(scene, fidelity="full", cargo=tuple(map(_without_reserves, scene.cargo)))
    held = held_trajectory(record, scene.motion)
    try:
        played = replay(held, bare, motion=motion, rate=MINIMUM_RATE)
        traces = constraint_traces(held, bare, played, points=[EvaluationPoint.OBJECT])
    except (ModelError, np.linalg.LinAlgError):
        return False
    return all(
        float(np.max(trace.use[trace.t >= since - 1e-9])) <= 1.0
        for trace in traces
        if trace.known is not None and trace.known.role is Role.CONTACT
    )


def _without_reserves(item: Cargo) -> Cargo:
    return replace(item, friction_reserve=0.0, footprint_reserve=0.0)
