"""A slow motion is the planned one in a greater gravity: the laws of a slowed object against a slow replay."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from nospill.certification.replay import Replay, replay
from nospill.core.frames import SX, body_motion
from nospill.core.trees import constants
from nospill.laws.sample import object_motion, object_states, sample_objects
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.motion import modal_accelerations
from nospill.motion.at_speed import SlowedMotion, at_speed
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene

SPEED = 0.4


def acceleration_and_wrench(scene: Scene, played: Replay, index: int, *, rates: float, with_up: bool):
    """Modal accelerations, force, moment and surface of the only object at one instant of a replay."""
    structure, numbers = structure_of(scene), constants(numbers_of(scene))
    body = played.body[:, index]
    if with_up:
        body = np.concatenate([body, played.tray.rotation[index, 2]])
    tray, q = body_motion(SX(ca.DM(body))), SX(ca.DM(played.slosh_displacement[index]))
    qd = SX(ca.DM(played.slosh_velocity[index] * rates))
    own, item = numbers.objects[0], structure.objects[0]
    change = modal_accelerations(item, own, object_motion(own, tray), q, qd, damp_against_spin=False)
    (sample,) = sample_objects(structure, numbers, tray, (object_states(item, q, qd, change),))
    parts = (change, sample.wrench.force, sample.wrench.moment, sample.surface)
    return [ca.evalf(ca.densify(part)).full().ravel() for part in parts], float(ca.evalf(SX(own.weight)))


@pytest.mark.parametrize(("name", "tense"), [("cup", False), ("mug", True), ("bottle", False)])
def test_forces_are_those_of_the_slow_motion(smooth_motion: Callable, name: str, tense: bool) -> None:
    """Over the square of the speed; displacements are the same, their rates follow the clock."""
    motion = smooth_motion("mixed-tray", stretch=0.8, tilt=(0.15, -0.1))
    (cargo,) = (item for item in motion.scene.cargo if item.name == name)
    if tense:
        cargo = _with_tension(cargo)
    scene = replace(motion.scene, cargo=(cargo,))
    slow = at_speed(motion.trajectory, SPEED)
    fast, slower = (replay(item, scene, rate=item.rate) for item in (motion.trajectory, slow))
    slowed = replace(scene, cargo=(replace(cargo, speed=SPEED),))
    for index in (len(fast.t) // 5, len(fast.t) // 2):
        there, weight = acceleration_and_wrench(scene, slower, index, rates=1.0, with_up=False)
        planned = replace(
            slower,
            body=fast.body,
            tray=fast.tray,
        )
        here, heavy = acceleration_and_wrench(slowed, planned, index, rates=1.0 / SPEED, with_up=True)
        for ours, theirs in zip(here[:3], there[:3], strict=True):
            np.testing.assert_allclose(ours, theirs / SPEED**2, rtol=1e-8, atol=1e-9 * heavy)
        np.testing.assert_allclose(here[3], there[3], rtol=1e-8, atol=1e-12)
        assert heavy == pytest.approx(weight / SPEED**2)


def _with_tension(cargo: Cargo) -> Cargo:
    """A liquid with a third more stiffness from surface tension, of which no gravity changes anything."""
    assert cargo.filling is not None
    modes = cargo.filling.modes
    oscillators = tuple(
        replace(mode, tension=mode.frequency**2 / 3.0, frequency=mode.frequency * np.sqrt(4.0 / 3.0))
        for mode in modes.oscillators
    )
    return replace(cargo, filling=replace(cargo.filling, modes=replace(modes, oscillators=oscillators)))


def test_a_slowed_motion_is_that_of_the_slowed_record(smooth_motion: Callable) -> None:
    trajectory = smooth_motion("matrix-liquid", stretch=1.0).trajectory
    slow = SlowedMotion(trajectory.motion, SPEED)
    other = at_speed(trajectory, SPEED).motion
    t = np.linspace(0.0, trajectory.end_time / SPEED, 50)
    for order in range(3):
        np.testing.assert_allclose(slow(t, order), other(t, order), rtol=1e-9, atol=1e-9)
