"""A box of liquid at the seam of two motions: what a turn has left in its yaw modes goes on."""

from __future__ import annotations

import numpy as np
import pytest

import nospill as ns
from nospill.certification.certificate import judge
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, motion_maxima
from nospill.transcription.starting_motions import Start
from tests.builders import joint_path_of, joint_paths_of, smooth_record

WAIT = 0.1
START, END = [0.6, -0.02, 0.5], [0.6, 0.02, 0.5]


def scene(path: dict[str, object]) -> ns.Scene:
    box = {"name": "tub", "at": [0.0, 0.0], "shape": "box", "length": "160 mm", "width": "90 mm", "height": "95 mm"}
    water = {"liquid": "water", "liquid_height": "40 mm", "max_slosh_height": "30 mm", "empty_mass": "0.3 kg"}
    return ns.load(
        {
            "name": "tub",
            "fidelity": "full",
            "robot": {"model": "ur10e"},
            "tray": {"size": ["400 mm", "300 mm"], "friction": 0.4, "mass": "0.5 kg", "offset": "50 mm"},
            "cargo": [box | water],
            "motion": {"slosh_height": "linear"},
            "planning": {"slosh_modes": 2},
            "path": {"type": "line"} | path,
        }
    )


def residual(t: np.ndarray, q: np.ndarray, whole: ns.Scene) -> float:
    rows = ns.certify_joints(t, q, whole).rows
    return next(row.worst_value for row in rows if row.constraint == "residual height")


def test_yaw_modes_go_on_over_the_seam() -> None:
    """Two motions as one record from rest leave what the second one leaves that begins with the swing of the first."""
    out = scene({"start": START, "end": END, "yaw": [0.0, 2.0]})
    record = smooth_record(out, joint_path_of(out), 60, Start(1.2))
    judged = judge(record, out)
    before = Plan(out, record, judged.certificate, motion_maxima(judged, out), PlanningReport.empty())
    straight = scene({"start": END, "end": START, "yaw": [2.0, 2.0]})
    on = ns.with_residual_slosh(straight, before, WAIT)
    swing, resting = on.cargo[0].filling, straight.cargo[0].filling
    assert swing is not None and resting is not None and swing.initial_swing is not None
    assert swing.turns and not resting.turns and swing.initial_swing.yaws
    ends = record.joint_position[-1]
    way = min(joint_paths_of(straight), key=lambda path: float(np.abs(path.q[0] - ends).max()))
    following = smooth_record(straight, way, 60, Start(2.5)).joint_position
    np.testing.assert_allclose(following[0], ends, atol=1e-6)
    stands = np.repeat(ends[None], round(WAIT * record.rate) - 1, axis=0)
    q = np.concatenate([record.joint_position, stands, following])
    whole = residual(np.arange(len(q)) / record.rate, q, out)
    assert residual(np.arange(len(following)) / record.rate, following, on) == pytest.approx(whole, rel=1e-3)
    alone = {"displacement": swing.initial_swing.displacement, "velocity": swing.initial_swing.velocity}
    without = straight.changed({"cargo.tub.initial_swing": {key: [*map(list, rows)] for key, rows in alone.items()}})
    other = residual(np.arange(len(following)) / record.rate, following, without)
    assert abs(other / whole - 1.0) > 0.02
