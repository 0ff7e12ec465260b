"""A judged motion of joints as a record: its tray, tilt and liquids as the judge saw them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nospill.certification.certificate import Judgement
from nospill.certification.tracks import judged_tracks
from nospill.core.attitudes import quaternions, tilt_of
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene


def recorded(judgement: Judgement, scene: Scene) -> Trajectory:
    """The motion that was judged at the scene's rate; s is the part of the way of the tray's centre that is behind.

    Args:
        judgement: of joints alone.
        scene: by which they were judged.
    """
    played = judgement.replay
    picked = slice(None, None, max(round(played.rate / scene.output_rate), 1))
    t, tray = played.t[picked], played.tray
    steps = np.linalg.norm(np.diff(tray.position[picked], axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    s = way / way[-1] if way[-1] > 0.0 else np.zeros_like(way)
    tilt = np.column_stack(tilt_of(tray.rotation[picked]))
    (s_rate, tilt_rate) = (np.gradient(values, t, axis=0) for values in (s, tilt))
    record = Trajectory(
        t=t,
        s=s,
        s_rate=s_rate,
        s_acceleration=np.gradient(s_rate, t),
        tilt=tilt,
        tilt_rate=tilt_rate,
        tilt_acceleration=np.gradient(tilt_rate, t, axis=0),
        joints=scene.robot.joints,
        joint_position=played.joint_position[picked],
        joint_speed=played.joint_speed[picked],
        joint_acceleration=played.joint_acceleration[picked],
        tray_position=tray.position[picked],
        tray_quaternion=quaternions(tray.rotation[picked]),
        slosh={},
    )
    return replace(record, slosh=judged_tracks(record, scene, played, judgement.traces))
