"""The scene of a motion that goes on from where a recorded one ended: with the swing that its joints have left."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from nospill.certification.full_model import full_scene
from nospill.certification.replay import replay
from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.execution.log import JointLog
from nospill.execution.motion import Span, recorded_motion, samples, stopping_time
from nospill.execution.observer import Gauge, ObservedLiquid, observed_liquids
from nospill.plans.swings import swing_table
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.scene import Scene

_RATE, _BEFORE = 500.0, 0.02
"""Hz, of the samples of the motion, and s of rest that are played before it."""
_ELSEWHERE = 5e-3
"""m; a path that begins farther from where the log ends is another one."""
_WAY = ("way", "way_yaw", "way_joints")
"""Keys of a free path that are of another start."""


@dataclass(frozen=True, slots=True)
class Begun:
    """A scene that begins with what a log leaves.

    Attributes:
        scene: of the motion that goes on.
        liquids: how its liquids swing then, and how well that is known, by object.
    """

    scene: Scene
    liquids: Mapping[str, ObservedLiquid]

    @property
    def text(self) -> str:
        """How well the heights at the walls are known, in words."""
        known = {name: 1e3 * float(np.max(item.height_spread)) for name, item in self.liquids.items()}
        parts = ", ".join(f"{name} to {value:.2g} mm" for name, value in known.items())
        return f"begins with the swing that the log leaves, known at the wall (one standard deviation): {parts}"


def after_log(scene: Scene, log: JointLog, wait: float = 0.0, gauges: Mapping[str, Gauge] | None = None) -> Begun:
    """The scene with the swing that a recorded motion and a wait leave, in the joints in which the arm stands.

    Args:
        scene: of the next motion, with the objects that were carried, which stood on the tray with liquids at rest.
        log: of the motion before, from rest to rest.
        wait: s, from its end on.
        gauges: heights that were measured meanwhile, on the clock of the log.

    Raises:
        ScenarioError: the log is not of this arm or of no whole motion, it ends somewhere else than the path begins, or
            a liquid stands above its limit then.
        ModelError: the liquids cannot be integrated.
    """
    if not 0.0 <= wait < np.inf:
        raise ScenarioError(f"wait = {wait:g} s: 0 or more is needed")
    recorded = recorded_motion(log, scene)
    motion, end = recorded.held(), recorded.end + stopping_time(recorded)
    record = samples(
        motion, scene.robot.joints, Span(recorded.begin - _BEFORE, recorded.begin, end, end + wait + _BEFORE), _RATE
    )
    whole = full_scene(scene)
    liquids = observed_liquids(replay(record, whole), whole, gauges, at=end + wait)
    swings = {f"cargo.{name}.initial_swing": swing_table(item.swing) for name, item in liquids.items()}
    return Begun(_standing(scene.changed(swings), record.joint_position[-1], log.origin), liquids)


def _standing(scene: Scene, q: np.ndarray, origin: str) -> Scene:
    """The scene with joints (n,) at its start, rad: of a free path as stated, of others as those that it is near to."""
    if scene.source["path"]["type"] == "free":
        return scene.changed({"path.start": {"joints": q.tolist()}, **{f"path.{key}": None for key in _WAY}})
    place = kinematics(scene.robot).poses(q[None], tool=scene.tray.tool)[0][0]
    start = scene.path.at([0.0])[0, :3]
    if np.linalg.norm(place - start) > _ELSEWHERE:
        ends, begins = (", ".join(format_quantity(float(x), "length") for x in point) for point in (place, start))
        raise ScenarioError(
            f"{scene.name}: its path begins at {begins}, and {origin} ends at {ends}; start the path there"
        )
    return scene
