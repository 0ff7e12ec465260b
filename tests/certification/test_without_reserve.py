"""What happens on the tray: of a run (`executed`) and of the line of what a plan survives, by one law.

Both play joints with nothing in reserve: the judge's replay, and a coarse one. Heights are linear here, for the second
order counts in the one as a higher crest and in the other as a lower rim: the same crests reach it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nospill.certification.certificate import judge_joints
from nospill.certification.tracked_rows import Followed, without_reserve
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.like_objects import hull_objects
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene


def _as_stated(scene: Scene) -> Scene:
    return scene


def _with_tolerances(scene: Scene) -> Scene:
    """Neither looks at corners: what happens is asked of the objects as they are stated."""
    return scene.changed({"tolerance": {"friction": "10 %", "position": "1 mm"}})


def _with_reserves(scene: Scene) -> Scene:
    return scene.changed({"tray.friction_reserve": 0.2, "tray.footprint_reserve": 0.2})


def _with_lids(scene: Scene) -> Scene:
    open_ones = [
        {key: value for key, value in table.items() if key != "max_slosh_height"} for table in scene.source["cargo"]
    ]
    return scene.changed({"cargo": [table | {"lid": True} for table in open_ones]})


@pytest.mark.parametrize(
    ("name", "variant"),
    [
        ("matrix-liquid-tilt", _as_stated),
        ("matrix-liquid-tilt", _with_tolerances),
        ("matrix-liquid-tilt", _with_reserves),
        ("matrix-liquid-tilt", _with_lids),
        ("vial-rack", _as_stated),
    ],
)
def test_a_run_is_judged_by_the_law_of_what_a_plan_survives(
    name: str, variant: Callable[[Scene], Scene], smooth_motion: Callable
) -> None:
    motion = smooth_motion(name, cargo=2) if name == "matrix-liquid-tilt" else smooth_motion(name)
    scene, planned = variant(motion.scene.changed({"motion.slosh_height": "linear"})), motion.trajectory
    joints = planned.joint_position, planned.joint_speed, planned.joint_acceleration
    record = Trajectory.of_joints(planned.t, scene.robot.joints, *joints)
    judged = judge_joints(record, scene)
    of_run = without_reserve(judged.replay, scene, judged.certificate.rows)
    followed = Followed.of(record, scene, judged.certificate.rows)
    (of_line,) = followed.rows(followed.motion, after=0.05)
    outer = {item.name for item in hull_objects(scene)}
    known = {row: use for row, use in of_run.items() if row.constraint != Clearance.name and row.subject in outer}
    assert known
    assert known.keys() == {row for row in of_line if row.constraint != Clearance.name}
    assert any(row.constraint == SloshHeight.name for row in known) is (variant is not _with_lids)
    for row, use in known.items():
        assert float(np.max(of_line[row])) == pytest.approx(use, rel=1e-2, abs=2e-3), row.label
