"""From the rules to an approach: as fast as they allow, and slower where what the tray carries does not bear it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.approach.judge import judge_segment
from nospill.approach.profile import jerk_limited
from nospill.approach.segment import Segment, sampled
from nospill.certification.verdict import Certificate
from nospill.errors import ModelError
from nospill.scene.scene import ApproachRules, Scene

SLOWEST = 10.0
"""How many times as long an approach may take as its limits alone ask for."""

_STRETCHES = (1.25, 1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 6.4, 8.0)
_PLANNED_SHARE = 0.99
"""Part of a limit that is planned with at most: the spline through samples rounds corners and overshoots by 0.4 %."""


@dataclass(frozen=True, slots=True)
class Approach:
    """A segment and what the judge says of it."""

    segment: Segment
    certificate: Certificate


def find_approach(scene: Scene, rules: ApproachRules, end: np.ndarray) -> Approach:
    """Find an approach that the judge certifies.

    The way is a straight line in joint space and does not depend on how fast it goes. It is tried as fast as the
    limits allow, then ten times as slowly: where that is not certified either, nothing between will do, as slip and
    slosh grow with the speed and what remains is the lean of the tray. Else it is slowed down step by step.

    Args:
        scene: with the robot, the tray and the cargo.
        rules: where it starts and what it must keep to.
        end: (n,) joint positions at which the motion begins, rad.

    Returns:
        The fastest of those tried that is certified, or the slowest one with its verdict.

    Raises:
        MissingExtraError: ruckig is not installed.
        ModelError: ruckig finds no motion, or a liquid leaves its cup even in the slowest.
    """
    profile = jerk_limited(
        rules.start,
        end,
        max_speed=rules.max_speed * min(rules.speed_scale, _PLANNED_SHARE),
        max_acceleration=rules.max_acceleration * min(rules.acceleration_scale, _PLANNED_SHARE),
        max_jerk=rules.max_jerk * _PLANNED_SHARE,
    )

    def tried(stretch: float) -> Approach:
        segment = sampled(profile, scene.robot.joints, rate=scene.output_rate, loaded=rules.loaded, stretch=stretch)
        return Approach(segment, judge_segment(segment, scene, rules, end))

    def certified(stretch: float) -> Approach | None:
        try:
            approach = tried(stretch)
        except ModelError:  # a liquid leaves its cup: not as fast as that
            return None
        return approach if approach.certificate.ok else None

    fastest = certified(1.0)
    if fastest is not None:
        return fastest
    slowest = tried(SLOWEST)
    if not slowest.certificate.ok:
        return slowest
    return next((approach for stretch in _STRETCHES if (approach := certified(stretch)) is not None), slowest)
