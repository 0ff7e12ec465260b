"""Uses at other speeds: those of the motion that a controller plays in another time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import judge_motion
from nospill.certification.other_speeds import SPEEDS, SpeedUse, uses_at
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


def test_heights_and_rims_are_those_of_a_certificate_of_the_slower_motion(smooth_motion: Callable) -> None:
    """The crest after the end counts, too: a liquid that rests after its own motion swings on after a slower one."""
    motion = smooth_motion("matrix-liquid", cargo=1)
    (use,) = uses_at(motion.trajectory, motion.scene, [0.63])
    scene = replace(motion.scene, output_rate=motion.scene.output_rate * 0.63)
    rows = judge_motion(at_speed(motion.trajectory, 0.63), scene).certificate.rows
    crests = [abs(row.worst_value) for row in rows if row.constraint in ("slosh height", "residual height")]
    assert use.height == pytest.approx(max(crests), rel=2e-3)
    cup = scene.cargo[0]
    assert cup.filling is not None and use.below_rim is not None
    assert use.below_rim == pytest.approx(cup.container.height - cup.filling.liquid_height - use.height, abs=1e-9)
    assert use.rim_use == pytest.approx(use.height / (cup.container.height - cup.filling.liquid_height))


KEPT = tuple(SpeedUse(speed, 0.99, 1.0, "slip | c1", "slip | c1", 8e-3, 12e-3) for speed in SPEEDS)


def _but(item: SpeedUse) -> tuple[SpeedUse, ...]:
    return (*KEPT[:3], item, *KEPT[4:])


def test_liquids_that_swing_below_the_rim_are_no_danger() -> None:
    assert list(other_speeds(KEPT)) == []
    swinging = _but(SpeedUse(0.5, 3.69, 0.9, "residual height | c4", "slip | c1", 13.8e-3, 8e-3))
    (warning,) = other_speeds(swinging)
    assert warning.value == 3.69 and warning.subject == "motion"
    assert (
        "at all 12 lower speeds that were looked at nothing spills, slides or tips; liquids swing on, at most 13.8 mm, "
        "8.0 mm below the rim: at 50 % of the speed residual height of c4 is 369.0 % of the stated limit"
    ) in warning.text
    assert all(item.safe for item in swinging)


@pytest.mark.parametrize(
    ("item", "words"),
    [
        (SpeedUse(0.5, 3.0, 1.37, "residual height | c4", "slip | c1", 1e-3, 9e-3), "slip of c1 uses 137.0 % of its"),
        (SpeedUse(0.5, 3.0, 0.5, "residual height | c4", "slip | c1", 22e-3, -2e-3), "a liquid rises 2.0 mm over its"),
        (SpeedUse(0.5, 0.0, 1.37, "tip | box", "tip | box"), "tip of box uses 137.0 % of its limit"),
    ],
)
def test_what_spills_slides_or_tips_is_named(item: SpeedUse, words: str) -> None:
    (warning,) = other_speeds(_but(item))
    assert not item.safe and warning.value is not None and warning.value > 1.0
    assert f"at 50 % of the speed {words}" in warning.text and "nothing spills" not in warning.text
    assert "1 of 12 lower speeds are unsafe" in warning.text and "motion.speed_range" in warning.text
    (warning,) = other_speeds(_but(item), (0.6, 1.0))
    assert warning.text.endswith("keep the speed between 60 and 100 %, which is certified.")
