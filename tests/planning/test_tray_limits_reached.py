"""Planned motions at limits of the tray's speed and acceleration: reached, held, as long as closed forms say."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from nospill.certification.certificate import certify
from nospill.certification.verdict import Certificate, Row
from nospill.diagnosis.quasi_static import longer_time
from nospill.diagnosis.search import Searcher, Trials
from nospill.errors import NoSolutionError
from nospill.laws.constraints import TrayAcceleration, TraySpeed
from nospill.planning.planner import plan
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene
from tests.builders import joint_path_of

pytestmark = pytest.mark.slow

LENGTH, SPEED, ACCELERATION = 0.7, 0.4, 1.5
"""m, m/s, m/s^2."""


def line(**motion: Any) -> Scene:
    """A solid carried level along y."""
    table: Any = read_scenario("pp-two-cups").source
    start, end = ([1.1, sign * LENGTH / 2, 0.9] for sign in (-1, 1))
    table["path"] = {"type": "line", "start": start, "end": end, "yaw": [0.0, 0.0]}
    table["motion"] = {"end": "residual", **motion}
    table["planning"] = {}
    sizes = {"shape": "cylinder", "radius": "35 mm", "height": "60 mm", "mass": "0.3 kg"}
    table["cargo"] = [{"name": "can", "at": [0.0, 0.0], **sizes}]
    return scene_from_table(table, name="line")


def own(certificate: Certificate, name: str) -> Row:
    return next(row for row in certificate.rows if row.constraint == name)


def test_a_line_at_limited_speed_and_acceleration_is_a_trapezoid() -> None:
    """It takes length/speed + speed/acceleration, and a little for the jerk; both limits are met at any rate."""
    found = plan(line(max_speed=f"{SPEED} m/s", max_acceleration=f"{ACCELERATION} m/s^2"))
    least = LENGTH / SPEED + SPEED / ACCELERATION
    assert found.certificate.ok and least < found.duration < 1.02 * least
    for certificate in (found.certificate, certify(found.trajectory, found.scene, rate=8000.0)):
        for constraint in (TraySpeed, TrayAcceleration):
            row = own(certificate, constraint.name)
            assert row.ok and 0.99 < row.use <= 1.0 and row.unit == constraint.unit
    assert found.limiting_text.startswith("speed of the tray is at its limit for")
    assert "(speed of the tray)" in found.savings_text and "(acceleration of the tray)" in found.savings_text
    # d(length/speed + speed/acceleration) for a tenth more of either limit
    saved = {row.split(" | ")[0]: value for row, value in found.report.savings.items()}
    assert saved[TraySpeed.name] == pytest.approx(0.1 * (LENGTH / SPEED - SPEED / ACCELERATION), rel=0.05)
    assert saved[TrayAcceleration.name] == pytest.approx(0.1 * SPEED / ACCELERATION, rel=0.05)


def test_left_out_of_the_plan_the_limits_fail_in_the_certificate() -> None:
    names = {TraySpeed.name, TrayAcceleration.name}
    found = plan(line(max_speed="0.8 m/s", max_acceleration="3 m/s^2"), ignore=names)
    assert {row.constraint for row in found.certificate.rows if not row.ok} == names


def test_a_crawl_is_planned_between_the_nodes_too() -> None:
    """At 0.1 m/s the tray speeds up within an interval of the grid, and keeps its limit on the way."""
    found = plan(line(max_speed="100 mm/s"))
    assert found.certificate.ok and found.duration == pytest.approx(LENGTH / 0.1, rel=0.025)


def test_a_limit_too_low_for_the_time_is_named_with_what_helps() -> None:
    with pytest.raises(NoSolutionError, match=r"held back by tray speed of tray") as failed:
        plan(line(max_speed="20 mm/s"))
    reason = failed.value.reason
    assert reason is not None
    changes = {change.place: change.value for change in reason.changes}
    assert set(changes) == {"motion.max_duration", "motion.max_speed"}
    assert isinstance(changes["motion.max_duration"], float) and 35.0 < changes["motion.max_duration"] < 45.0


def test_the_duration_that_helps_is_that_of_a_smooth_motion_within_the_limits() -> None:
    """A quintic is 15/8 times as fast in its middle as on average."""
    scene = line(max_speed="50 mm/s", max_duration="20 s")
    trials = Trials(cast("Searcher", SimpleNamespace(scene=scene)), joint_path_of(scene))
    least = 1.875 * LENGTH / 0.05
    (change,) = longer_time(trials, least / (0.95 * 20.0))  # which the slowest smooth motion takes
    assert change.place == "motion.max_duration" and change.value == pytest.approx(1.05 * least / 0.95)
    assert change.text == "max_duration 29 s instead of 20 s"
