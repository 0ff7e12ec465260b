"""Where the record of a motion begins and ends: at rest on its path, or joining on the motion before it."""

from __future__ import annotations

import numpy as np

from nospill.certification.replay import Replay, tray_from_joints
from nospill.certification.verdict import Trace, limit_trace
from nospill.motion.trajectory import Trajectory
from nospill.scene.initial_state import InitialState
from nospill.scene.scene import Scene

JOINS = {"position": ("m", 1e-9), "velocity": ("m/s", 1e-6), "acceleration": ("m/s^2", 1e-4)}
"""What the record may begin away from the state it goes on from: the tray, and the joints on a lever arm of 1 m."""
PROGRESS_TOLERANCE = 1e-9
"""The path parameter runs from 0 to 1 within this."""


def ends_apart(bare: Trajectory, played: Replay, scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How far both ends of a record (2,) are from where it is to begin and end.

    Args:
        bare: the record without its holds.
        played: its replay, with them.
        scene: with the state that it begins in.

    Returns:
        The path parameter; the greatest joint speed beyond what it is to be as recorded, rad/s, and as played.
    """
    state, s = scene.initial_state, bare.s
    begins, speed = (0.0, np.zeros(len(bare.joints))) if state is None else (state.s, state.joints[1])
    end = s[-1] - 1.0
    if scene.motion.stop:
        end = max(0.0, begins - s[-1], s[-1] - 1.0)
    recorded, as_played = (
        np.array([np.max(np.abs(speeds[0] - speed)), np.max(np.abs(speeds[-1]))])
        for speeds in (bare.joint_speed, played.joint_speed)
    )
    return np.abs([s[0] - begins, end]), recorded, as_played


def joining_traces(bare: Trajectory, scene: Scene, state: InitialState) -> list[Trace]:
    """Traces of a record that begins in motion: position, velocity and acceleration are those of the motion before."""
    recorded = [column[:1] for column in (bare.joint_position, bare.joint_speed, bare.joint_acceleration)]
    before = [column[None] for column in state.joints]
    ours, theirs = (tray_from_joints(scene, joints)[0] for joints in (recorded, before))
    traces = []
    for (name, (unit, limit)), own, other in zip(JOINS.items(), recorded, before, strict=True):
        tray = getattr(ours, name) - getattr(theirs, name)
        gap = max(float(np.linalg.norm(tray)), float(np.max(np.abs(own - other))))
        traces.append(limit_trace("joins on", name, unit, limit, bare.t[:1], np.array([gap])))
    return traces
