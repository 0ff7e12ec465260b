"""A box of water turned on the spot: what the certificate says of its surface, against an integration of its own.

The oracle reads the yaw of the exported motion and nothing else of the program: modes of a rectangle odd along both
sides, up to eleven half waves along each, under its angular acceleration, over the whole wall.
"""

from __future__ import annotations

import numpy as np
import pytest

from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.verdict import Row
from nospill.planning.planner import plan
from nospill.scene.scene import Scene
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.transcription.starting_motions import Start
from tests.builders import joint_path_of, smooth_record
from tests.scene.test_turning import scene_of

SIDES, LEVEL = (0.24, 0.2), 0.04


def row(judgement: Judgement, constraint: str) -> Row:
    (found,) = [item for item in judgement.certificate.rows if item.constraint == constraint]
    return found


def crests(judgement: Judgement, scene: Scene) -> tuple[float, float]:
    """Greatest height along the wall during the motion and in the 4 s after it, m."""
    played, (a, b) = judgement.replay, SIDES
    step, alpha = 1.0 / played.rate, played.body[5]
    waves = [(m, n) for m in range(1, 23, 2) for n in range(1, 23, 2)]
    m, n = np.array(waves, dtype=float).T
    k = np.pi * np.hypot(m / a, n / b)
    kappa = k * np.tanh(k * LEVEL)
    omega = np.sqrt(STANDARD_GRAVITY * kappa)
    share = 16 / np.pi**2 * ((a / m) ** 2 - (b / n) ** 2) / (a * b * k**2)
    known = {round(mode.frequency, 6): mode.damping for mode in scene.cargo[0].oscillators if mode.yaws}
    damping = np.array([known.get(round(value, 6), 0.02) for value in omega])
    swings, decay = omega * np.sqrt(1 - damping**2), damping * omega
    factor, q, qd, rows = np.exp(-decay * step), np.zeros(len(k)), np.zeros(len(k)), []
    push = np.concatenate([(alpha[1:] + alpha[:-1]) / 2, np.zeros(round(4.0 / step))])
    for value in push:
        rest = -kappa * share * value / omega**2
        apart = q - rest
        cosine, sine = np.cos(swings * step), np.sin(swings * step) / swings
        q = rest + factor * (apart * cosine + (qd + decay * apart) * sine)
        qd = factor * (qd * cosine - (omega**2 * apart + decay * qd) * sine)
        rows.append(q)
    half, part = np.array(SIDES) / 2, np.linspace(0.0, 1.0, 81)[:, None]
    wall = np.concatenate([half * np.hstack([part, 0 * part + 1]), half * np.hstack([0 * part + 1, part])])
    sign = np.sin(m * np.pi / 2) * np.sin(n * np.pi / 2)
    shape = sign * np.sin(np.outer(wall[:, 0], m * np.pi / a)) * np.sin(np.outer(wall[:, 1], n * np.pi / b))
    height = np.max(np.abs(np.array(rows) @ shape.T), axis=1)
    return float(np.max(height[: len(alpha)])), float(np.max(height[len(alpha) :]))


def spot(modes: int) -> Scene:
    """The linear law is looked at, of all modes."""
    return scene_of({"planning.slosh_modes": modes, "motion": {"slosh_height": "linear"}})


def test_a_fast_turn_is_refused_for_what_its_water_does() -> None:
    scene = spot(6)
    record = smooth_record(scene, joint_path_of(scene), 30, Start(stretch=0.5))
    judgement = judge_motion(record, scene)
    height, residual = row(judgement, "slosh height"), row(judgement, "residual height")
    during, after = crests(judgement, scene)
    assert during > 0.005
    assert not residual.ok
    assert height.worst_value == pytest.approx(during, rel=0.03)
    assert residual.worst_value == pytest.approx(after, rel=0.03)
    twist = row(judgement, "twist")
    assert twist.worst_value > 0.0


@pytest.mark.slow
def test_a_planned_turn_keeps_its_water_in_its_limits() -> None:
    found = plan(spot(6).changed({"planning.intervals": 40}))
    assert found.certificate.ok
    assert found.duration == pytest.approx(0.89, abs=0.03)
    scene = spot(20)  # a motion with corners in its jerk leaves modes swinging that six do not have
    judgement = judge_motion(found.trajectory, scene)
    during, after = crests(judgement, scene)
    assert row(judgement, "slosh height").worst_value == pytest.approx(during, rel=0.03)
    assert row(judgement, "residual height").worst_value == pytest.approx(after, rel=0.01)
