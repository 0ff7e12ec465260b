"""Uses at other speeds: those of the motion that a controller plays in another time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.judge.certificate import judge_motion
from nospill.judge.other_speeds import SPEEDS, SpeedUse, uses_at
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import Role
from nospill.motion.at_speed import at_speed
from nospill.plans.warnings.speeds import other_speeds


def test_a_slower_record_is_a_motion(smooth_motion: Callable) -> None:
    """Rates are the derivatives of what they are rates of."""
    slower = at_speed(smooth_motion("mixed-tray", tilt=(0.1, 0.05)).trajectory, 0.4)
    for position, rate in (("s", "s_rate"), ("tilt", "tilt_rate"), ("joint_position", "joint_speed")):
        found = np.gradient(getattr(slower, position), slower.t, axis=0)[2:-2]
        size = np.abs(getattr(slower, rate)).max()
        assert np.allclose(found, getattr(slower, rate)[2:-2], atol=2e-3 * size)
    found = np.gradient(slower.joint_speed, slower.t, axis=0)[2:-2]
    assert np.allclose(found, slower.joint_acceleration[2:-2], atol=1e-2 * np.abs(slower.joint_acceleration).max())


@pytest.mark.parametrize("speed", [1.0, 0.63])
def test_uses_are_those_of_a_certificate_of_the_slower_motion(smooth_motion: Callable, speed: float) -> None:
    motion = smooth_motion("mixed-tray", stretch=0.8, tilt=(0.1, 0.05))
    (use,) = uses_at(motion.trajectory, motion.scene, [speed])
    scene = replace(motion.scene, output_rate=motion.scene.output_rate * speed)
    rows = judge_motion(at_speed(motion.trajectory, speed), scene).certificate.rows
    largest = {
        role: max(row.use for row in rows if row.constraint in BY_NAME and BY_NAME[row.constraint].role is role)
        for role in (Role.LIQUID, Role.CONTACT)
    }
    assert use.liquid == pytest.approx(largest[Role.LIQUID], rel=2e-3)
    assert use.contact == pytest.approx(largest[Role.CONTACT], rel=2e-3)


def test_a_leaning_tray_played_at_a_tenth_stands_at_its_lean(smooth_motion: Callable) -> None:
    """What is left is the weight: the slip of a solid is tan(lean) over the friction, whatever the motion was."""
    motion = smooth_motion("matrix-rigid", cargo=1, tilt=(0.2, 0.0))
    (use,) = uses_at(motion.trajectory, motion.scene, [0.01])
    lean = np.max(np.arccos(np.cos(motion.trajectory.tilt[:, 0]) * np.cos(motion.trajectory.tilt[:, 1])))
    assert use.liquid == 0.0
    assert use.contact == pytest.approx(np.tan(lean) / motion.scene.cargo[0].planned_friction, rel=2e-3)


def test_a_broken_limit_is_warned_of_and_a_kept_one_not() -> None:
    kept = tuple(SpeedUse(speed, 0.99, 1.0, "slip | c1") for speed in SPEEDS)
    assert list(other_speeds(kept)) == []
    worse = (*kept[:3], SpeedUse(0.5, 1.52, 1.1, "residual height | c4"), *kept[4:])
    (warning,) = other_speeds(worse)
    assert warning.value == 1.52 and warning.subject == "motion"
    assert "at 50 % of the speed residual height of c4 uses 152 % of its limit" in warning.text
    assert "1 of 12 lower speeds" in warning.text and "motion.speed_range" in warning.text
    (warning,) = other_speeds(worse, (0.6, 1.0))
    assert warning.text.endswith("keep the speed between 60 and 100 %, which is certified.")
