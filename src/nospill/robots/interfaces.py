"""Interfaces by which an arm takes a command, one line each: its period, and what it refuses.

An interface reads a position of every joint each period. Some check the differences of these positions before the arm
moves, and stop it where a limit is broken.

Franka Control Interface [libfranka 0.21, `rate_limiting.h`]: the limits of acceleration and jerk less 0.001 of their
units, and those of speed less 0.001 rad/s. That is where libfranka's own rate limiter aims, so that it leaves a motion
within them alone. The limit of speed near the end of a joint is that of the place which the joint reaches. A command of
joints has no limits of the hand: those are of Cartesian commands. Its measured speed is watched in every mode, against
3 m/s (`cartesian_velocity_violation`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.suggestions import nearest
from nospill.errors import ScenarioError
from nospill.robots.robot import Robot

SAME_RATE = 1e-4
"""Part by which a rate may differ from one of an interface: 83.33 Hz are a period of 12 ms."""


@dataclass(frozen=True, slots=True)
class Checks:
    """What an interface checks of the differences of a command, each period.

    Attributes:
        acceleration: of every joint, rad/s^2.
        jerk: likewise, rad/s^3.
        speed_kept: what is kept of every limit of speed, rad/s.
        hand_speed: limit of the hand as measured, m/s.
    """

    acceleration: float
    jerk: float
    speed_kept: float
    hand_speed: float


@dataclass(frozen=True, slots=True)
class Interface:
    """One way into a controller.

    Attributes:
        name: key in the table.
        title: what it is, in one line.
        rates: positions a second that it reads, Hz, the usual one first; where `any_rate`, the usual, least and
            greatest.
        any_rate: whether a controller may be set to any rate between.
        joints: how many it is for; None for any.
        checks: what it refuses, or None where nobody states that.
    """

    name: str
    title: str
    rates: tuple[float, ...]
    any_rate: bool = False
    joints: int | None = None
    checks: Checks | None = None

    def rate_of(self, stated: float | None) -> float:
        """The rate that is stated, Hz; the usual one where none is.

        Raises:
            ScenarioError: the interface does not read so many positions a second.
        """
        if stated is None:
            return self.rates[0]
        if self.any_rate:
            _, least, greatest = self.rates
            if least <= stated <= greatest:
                return stated
            raise ScenarioError(f"update_rate is {stated:g} Hz; {self.name} has {least:g} to {greatest:g} Hz")
        for own in self.rates:
            if abs(stated / own - 1.0) <= SAME_RATE:
                return own
        rates = " or ".join(f"{own:.6g}" for own in self.rates)
        raise ScenarioError(f"update_rate is {stated:g} Hz; {self.name} has {rates} Hz; leave it out")


INTERFACES: Mapping[str, Interface] = {
    item.name: item
    for item in (
        Interface(
            "fci",
            "Franka Control Interface, joint positions each 1 ms",
            (1000.0,),
            joints=7,
            checks=Checks(acceleration=10.0 - 1e-3, jerk=5000.0 - 1e-3, speed_kept=1e-3, hand_speed=3.0),
        ),
        Interface("ur-servoj", "Universal Robots, servoj each 2 ms, or 8 ms on CB3", (500.0, 125.0), joints=6),
        Interface("rsi-4ms", "KUKA Robot Sensor Interface, corrections each 4 ms", (250.0,)),
        Interface("rsi-12ms", "KUKA Robot Sensor Interface, corrections each 12 ms", (1000.0 / 12.0,)),
        Interface("egm", "ABB Externally Guided Motion, joint references each 4 ms", (250.0,)),
        Interface(
            "jtc",
            "ROS 2 joint_trajectory_controller, which asks the drives at its update rate",
            (500.0, 100.0, 1000.0),
            any_rate=True,
        ),
    )
}
"""Every interface by its name."""


def interface_of(robot: Robot, name: str) -> Interface:
    """The interface of an arm by its name.

    Raises:
        ScenarioError: there is none of this name, or the arm lacks it; says what it has.
    """
    if name not in INTERFACES:
        near = nearest(name, INTERFACES, likeness=0.5)
        hint = f'; did you mean "{near}"?' if near else ""
        raise ScenarioError(f'interface "{name}" is not known; there are {", ".join(INTERFACES)}{hint}')
    found = INTERFACES[name]
    if robot.interfaces is not None and name not in robot.interfaces:
        has = f"it has {', '.join(robot.interfaces)}" if robot.interfaces else "none of its interfaces is known"
        raise ScenarioError(f'interface is "{name}", which {robot.name} lacks; {has}')
    if found.joints is not None and len(robot.joints) != found.joints:
        raise ScenarioError(
            f'interface is "{name}", which is for {found.joints} joints; {robot.name} has {len(robot.joints)}'
        )
    return found


def limited_by(robot: Robot, interface: Interface) -> Robot:
    """The arm as an interface lets it move: its own limits, and those of the interface where they are less."""
    checks = interface.checks
    if checks is None:
        return robot
    braking, source = robot.braking, f"as {interface.name} checks it (robots/interfaces.py)"
    if braking is not None:
        kept = read_only(braking.offset + checks.speed_kept)
        braking = replace(braking, offset=kept, ahead=1.0 / interface.rates[0])
    return replace(
        robot,
        max_speed=read_only(robot.max_speed - checks.speed_kept),
        max_acceleration=_least(robot.max_acceleration, checks.acceleration, len(robot.joints)),
        max_jerk=_least(robot.max_jerk, checks.jerk, len(robot.joints)),
        braking=braking,
        sources={
            name: f"{text}; {source}" if name in ("speed", "acceleration", "jerk", "braking") else text
            for name, text in robot.sources.items()
        },
    )


def _least(limit: np.ndarray | None, most: float, joints: int) -> np.ndarray:
    return read_only(np.full(joints, most) if limit is None else np.minimum(limit, most))
