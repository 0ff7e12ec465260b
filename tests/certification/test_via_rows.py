"""Rows about places that the tray passes and regions that it stays in: on the joints as they are played."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import certify
from nospill.certification.verdict import Certificate, Row
from nospill.motion.trajectory import Trajectory
from nospill.scene.places import Region, Via
from nospill.scene.scene import Scene


@pytest.fixture(scope="module")
def moved(smooth_motion) -> tuple[Scene, Trajectory]:
    """One solid on a tray that leans; no liquid to integrate, so that it is judged in a moment."""
    motion = smooth_motion("matrix-rigid", cargo=1, stretch=1.3, tilt=(0.05, -0.03))
    scene = motion.scene
    return replace(scene, motion=replace(scene.motion, corridor=0.05)), motion.trajectory


SIDES = ("+x", "-x", "+y", "-y", "top", "bottom")


def row_of(certificate: Certificate, constraint: str, subject: str) -> Row:
    (found,) = [row for row in certificate.rows if (row.constraint, row.subject) == (constraint, subject)]
    return found


@pytest.mark.parametrize(("radius", "holds"), [(0.0301, True), (0.0299, False)])
def test_the_nearest_instant_of_the_whole_motion_counts(moved, radius: float, holds: bool) -> None:
    scene, trajectory = moved
    place, along = scene.path.at(0.4)[0, :3], scene.path.derivative(0.4)[0, :3]
    beside = np.cross(along, (0.0, 0.0, 1.0))
    beside *= 0.03 / np.linalg.norm(beside)
    x, y, z = (place + beside).tolist()
    passed = replace(scene, motion=replace(scene.motion, via=(Via("door", (x, y, z), radius, 0.4),)))
    certificate = certify(trajectory, passed)
    row = row_of(certificate, "via", "door")
    assert (row.ok, certificate.ok, row.limit, row.unit) == (holds, holds, radius, "m")
    assert row.worst_value == pytest.approx(0.03, abs=2e-5)
    assert np.interp(row.at_s, trajectory.t, trajectory.s) == pytest.approx(0.4, abs=0.01)
    # what the record says of the tray's place changes nothing of it
    told = replace(trajectory, tray_position=np.tile((x, y, z), (len(trajectory.t), 1)))
    assert row_of(certify(told, passed), "via", "door") == row


def test_tray_and_cargo_stay_in_a_region_between_the_samples_too(moved) -> None:
    scene, trajectory = moved
    tray = scene.tray.size
    low, high = (limit(trajectory.tray_position, axis=0) for limit in (np.min, np.max))
    middle, size = (low + high) / 2, high - low + 2 * (np.hypot(*tray) / 2 + 0.3)
    around = Region("cell", tuple(middle.tolist()), tuple(size.tolist()), 0.0)
    certificate = certify(trajectory, replace(scene, regions=(around,)))
    rows = [row for row in certificate.rows if row.constraint == "clearance"]
    assert all(row.ok for row in rows)
    sides = [row.subject for row in rows if "cell" in row.subject]  # the other rows are of the arm with itself
    assert sorted(sides) == sorted(f"tray and cargo to cell {side}" for side in SIDES)  # links may leave it
    # the box that the object on the tray leaves by its height alone
    (item,) = scene.cargo
    lid = float(high[2]) + 0.5 * item.container.height
    flat = replace(around, position=(*around.position[:2], lid - around.size[2] / 2))
    certificate = certify(trajectory, replace(scene, regions=(flat,)))
    row = row_of(certificate, "clearance", "tray and cargo to cell top")
    assert not row.ok and not certificate.ok
    assert -1.2 * item.container.height < row.worst_value < -0.4 * item.container.height
    others = [
        row for row in certificate.rows if row.constraint == "clearance" and row.subject != "tray and cargo to cell top"
    ]
    assert all(row.ok for row in others)
