"""Rows of a tray that may leave its path: how far it is beside it, where it begins and ends, how it is turned there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import certify
from nospill.certification.verdict import Certificate, Row
from nospill.motion.trajectory import Trajectory
from nospill.paths.path import Path
from nospill.scene.scene import Scene

WIDTH = 0.05


@pytest.fixture(scope="module")
def solid(smooth_motion) -> tuple[Scene, Trajectory]:
    """One solid on a tray that leans; no liquid to integrate, so that it is judged in a moment."""
    motion = smooth_motion("matrix-rigid", cargo=1, stretch=1.3, tilt=(0.05, -0.03))
    return motion.scene, motion.trajectory


def free(scene: Scene, *, yaw: bool = True) -> Scene:
    return replace(scene, motion=replace(scene.motion, corridor=WIDTH, yaw_free=yaw))


def beside(scene: Scene, bend: tuple[float, ...], shift: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)) -> Scene:
    """The scene with another path: shifted, and bent by some 4 s (1 - s) times as much; m and rad."""
    path = scene.path
    start = path.breaks[:-1]
    added = np.zeros_like(path.coefficients)
    for axis in range(4):
        added[-1, :, axis] = shift[axis] + 4 * bend[axis] * start * (1 - start)
        added[-2, :, axis] = 4 * bend[axis] * (1 - 2 * start)
        added[-3, :, axis] = -4 * bend[axis]
    return replace(scene, path=Path(path.breaks, path.coefficients + added))


def rows_of(certificate: Certificate) -> dict[str, Row]:
    return {row.constraint: row for row in certificate.rows if row.subject in ("tray", "yaw", "z")}


def test_on_the_path_every_row_holds(solid) -> None:
    scene, trajectory = solid
    certificate = certify(trajectory, free(scene))
    rows = rows_of(certificate)
    assert certificate.ok and "path position" not in rows
    assert {"corridor", "goal", "goal attitude", "path attitude", "offset jerk", "yaw jerk"} <= set(rows)
    assert rows["corridor"].worst_value < 1e-9 and rows["corridor"].limit == WIDTH
    given = rows_of(certify(trajectory, scene))
    assert "path position" in given and not {"corridor", "goal", "goal attitude"} & set(given)


@pytest.mark.parametrize(("bend", "holds"), [(0.049, True), (0.051, False)])
def test_the_distance_from_the_path_is_judged_where_the_joints_carry_the_tray(solid, bend: float, holds: bool) -> None:
    scene, trajectory = solid
    moved = beside(free(scene), (0.0, 0.0, bend, 0.0))
    row = rows_of(certify(trajectory, moved))["corridor"]
    assert row.ok == holds
    assert row.worst_value == pytest.approx(bend, rel=1e-4)
    assert np.interp(row.at_s, trajectory.t, trajectory.s) == pytest.approx(0.5, abs=0.02)
    # what the record says of the tray's place changes nothing of it, and is found out
    told = replace(trajectory, tray_position=moved.path.at(trajectory.s)[:, :3])
    certificate = certify(told, moved)
    assert rows_of(certificate)["corridor"] == row
    assert not rows_of(certificate)["recorded position"].ok


@pytest.mark.parametrize(("shares", "holds"), [((1.0, 0.5, 1.0), True), ((1.0, 0.3, 1.0), False), ((0.3, 1.0), True)])
def test_a_width_that_changes_is_that_at_the_place(solid, shares: tuple[float, ...], holds: bool) -> None:
    """The tray is 20 mm beside the middle of its path, in a corridor of 50 mm; 0.3 of that is 15 mm."""
    scene, trajectory = solid
    moved = beside(free(scene), (0.0, 0.0, 0.02, 0.0))
    narrow = replace(moved, motion=replace(moved.motion, corridor_shares=shares))
    certificate = certify(trajectory, narrow)
    row = rows_of(certificate)["corridor"]
    assert row.ok == holds
    s = float(np.interp(row.at_s, trajectory.t, trajectory.s))
    along = s * (len(shares) - 1)
    step = min(int(along), len(shares) - 2)
    u = along - step
    width = WIDTH * (shares[step] + (shares[step + 1] - shares[step]) * u * u * (3 - 2 * u))
    assert row.limit == pytest.approx(width, rel=1e-4)
    assert row.worst_value == pytest.approx(0.02 * 4 * s * (1 - s), rel=1e-3)


def test_the_ends_stay_those_of_the_path(solid) -> None:
    scene, trajectory = solid
    rows = rows_of(certify(trajectory, beside(free(scene), (0.0,) * 4, (0.0, 0.0, 0.03, 0.0))))
    assert rows["corridor"].ok and not rows["goal"].ok and rows["goal attitude"].ok
    assert rows["goal"].worst_value == pytest.approx(0.03, rel=1e-6)


def test_a_free_yaw_is_held_at_its_ends_only(solid) -> None:
    scene, trajectory = solid
    turned = beside(scene, (0.0, 0.0, 0.0, 0.4))
    assert not rows_of(certify(trajectory, free(turned, yaw=False)))["path attitude"].ok
    rows = rows_of(certify(trajectory, free(turned)))
    assert rows["path attitude"].ok and rows["goal attitude"].ok and rows["yaw jerk"].worst_value != 0.0
    rows = rows_of(certify(trajectory, beside(free(scene), (0.0,) * 4, (0.0, 0.0, 0.0, 0.2))))
    assert not rows["goal attitude"].ok
    assert rows["goal attitude"].worst_value == pytest.approx(0.2, rel=1e-6)


def test_the_jerk_beside_the_path_is_judged(solid) -> None:
    scene, trajectory = solid
    moved = beside(free(scene), (0.0, 0.0, 0.04, 0.0))
    calm = rows_of(certify(trajectory, moved))["offset jerk"]
    assert calm.ok and calm.worst_value != 0.0
    slow = replace(moved, motion=replace(moved.motion, path_jerk_limit=0.5 * abs(calm.worst_value) / moved.path_length))
    assert not rows_of(certify(trajectory, slow))["offset jerk"].ok
