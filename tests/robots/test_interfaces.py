"""The interfaces of the arms, and the limits that they bring."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.robots.description.catalog import ROBOTS, load_robot
from nospill.robots.interfaces import INTERFACES, interface_of, limited_by

FCI = INTERFACES["fci"]


@pytest.mark.parametrize("name", ROBOTS)
def test_an_arm_of_the_catalogue_has_interfaces_of_the_table_that_fit_its_joints(name: str) -> None:
    arm = load_robot(name)
    assert arm.interfaces is not None
    for interface in arm.interfaces:
        assert interface_of(arm, interface) is INTERFACES[interface]


@pytest.mark.parametrize(
    ("arm", "name", "message"),
    [
        ("ur5e", "fci", 'interface is "fci", which ur5e lacks; it has ur-servoj, jtc$'),
        ("comau-smart-six", "jtc", 'interface is "jtc", which comau-smart-six lacks; none of its interfaces is known$'),
        ("franka-fr3", "fcl", r'interface "fcl" is not known; there are fci, .*; did you mean "fci"\?$'),
    ],
)
def test_an_interface_that_an_arm_lacks_is_refused(arm: str, name: str, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        interface_of(load_robot(arm), name)


@pytest.mark.parametrize(
    ("name", "stated", "rate"),
    [("jtc", None, 500.0), ("jtc", 125.0, 125.0), ("ur-servoj", 125.0, 125.0), ("rsi-12ms", 83.333, 1000.0 / 12.0)],
)
def test_the_rate_is_the_usual_one_or_one_that_the_interface_has(name: str, stated: float | None, rate: float) -> None:
    assert INTERFACES[name].rate_of(stated) == pytest.approx(rate, rel=1e-4)


@pytest.mark.parametrize(
    ("name", "stated", "message"),
    [("jtc", 50.0, "jtc has 100 to 1000 Hz"), ("fci", 500.0, "fci has 1000 Hz; leave it out")],
)
def test_other_rates_are_refused(name: str, stated: float, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        INTERFACES[name].rate_of(stated)


def test_the_limits_of_an_arm_are_the_lesser_of_both() -> None:
    """Those of libfranka's header: 10 rad/s^2, 5000 rad/s^3 and the speeds, each less 0.001."""
    arm = load_robot("franka-fr3")
    own = limited_by(arm, FCI)
    assert own.max_acceleration == pytest.approx(np.full(7, 9.999))
    assert own.max_jerk == pytest.approx(np.full(7, 4999.999))
    assert own.max_speed == pytest.approx(np.array([2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26]) - 0.001)
    assert arm.braking is not None and own.braking is not None
    assert own.braking.offset == pytest.approx(arm.braking.offset + 0.001)
    assert own.braking.ahead == 0.001
    assert limited_by(arm, INTERFACES["jtc"]) is arm


def test_limits_of_braking_scale_with_the_speed() -> None:
    braking = load_robot("franka-fr3").braking
    assert braking is not None
    less, way = braking.scaled(0.7), np.linspace(0.1, 2.0, 9)[:, None]
    own, theirs = (np.sqrt(2.0 * item.deceleration * way) - item.offset for item in (braking, less))
    assert theirs == pytest.approx(0.7 * own, abs=1e-12)
