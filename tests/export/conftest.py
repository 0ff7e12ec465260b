"""A plan without a solver, and samples in the shape every exporter takes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from nospill.certificate import judge
from nospill.interpolation import JointSamples
from nospill.plans import Plan, PlanningReport, Starts, motion_maxima


@pytest.fixture(scope="session")
def gentle_plan(smooth_motion) -> Callable[..., Plan]:
    """A certified plan of an example, slow enough to keep every limit with room: its name, and how many objects."""

    @cache
    def make(name: str, cargo: int | None = None) -> Plan:
        motion = smooth_motion(name, cargo=cargo, stretch=0.8 if name == "matrix-rigid" else 1.3)
        judgement = judge(motion.trajectory, motion.scene)
        assert judgement.certificate.ok
        report = PlanningReport(1.0, 0.5, 10, 1, Starts(1, 1, 1, (2.0,)), {"solve": 0.5}, "none", {})
        maxima = motion_maxima(judgement, motion.scene)
        return Plan(motion.scene, motion.trajectory, judgement.certificate, maxima, report)

    return make


def curve(samples: int = 40, joints: int = 6, rate: float = 500.0) -> JointSamples:
    """A rest-to-rest quintic in every joint, with different ends; times as whole nanoseconds."""
    t = np.round(np.arange(samples) / rate * 1e9) / 1e9
    u, length = (t / t[-1])[:, None], t[-1]
    start, way = np.linspace(-1.3, 2.1, joints), np.linspace(0.5, -3.0, joints)
    return JointSamples(
        t,
        start + way * (10 * u**3 - 15 * u**4 + 6 * u**5),
        way * (30 * u**2 - 60 * u**3 + 30 * u**4) / length,
        way * (60 * u - 180 * u**2 + 120 * u**3) / length**2,
    )


@pytest.fixture(scope="session")
def samples() -> Callable[..., JointSamples]:
    """Make the `curve`."""
    return curve
