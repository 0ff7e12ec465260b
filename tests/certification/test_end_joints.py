"""The row `end joints`: a plan from stated joints begins in them, and one that does not is found out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import nospill as ns
from nospill.certification.certificate import certify
from nospill.robots.joint_paths.search import joint_paths
from nospill.scenario import read_scenario, scene_from_table

pytestmark = pytest.mark.slow
PLACES = [{"position": [0.75, -0.5, 0.45]}, {"position": [0.75, 0.5, 0.45], "yaw": "30 deg"}]


def test_a_plan_begins_and_ends_in_the_stated_joints() -> None:
    table = read_scenario("cups-around-a-column").source
    table = {key: value for key, value in table.items() if key not in ("obstacle", "planning")}
    table |= {"motion": {"tilt": "fixed"}, "cargo": table["cargo"][:1], "planning": {"intervals": 40, "slosh_modes": 1}}  # type: ignore[index]
    free = scene_from_table({**table, "path": {"type": "free", "start": PLACES[0], "goal": PLACES[1]}}, name="free")
    every = joint_paths(free.robot, free.path, tool=free.tray.tool)
    q = every[-1].q[[0, -1]]  # not those that are taken by themselves
    ends = {"start": {"joints": q[0].tolist()}, "goal": {"joints": q[1].tolist()}}
    scene = scene_from_table({**table, "path": {"type": "free", **ends}}, name="joints")
    plan = ns.plan(scene)
    assert plan.certificate.ok
    np.testing.assert_allclose(plan.trajectory.joint_position[[0, -1]], q, atol=1e-6)
    (row,) = [row for row in plan.certificate.rows if row.constraint == "end joints"]
    assert row.ok and row.worst_value < 1e-6
    moved = replace(plan.scene, path=replace(plan.scene.path, ends=(None, q[1] + 2 * np.pi)))
    rows = {row.constraint: row for row in certify(plan.trajectory, moved).rows}
    assert not rows["end joints"].ok and rows["end joints"].worst_value == pytest.approx(2 * np.pi, rel=1e-6)
    assert "end joints" not in {row.constraint for row in certify(plan.trajectory, replace(moved, path=free.path)).rows}
