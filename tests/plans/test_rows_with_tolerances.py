"""Motions in a row of liquids whose numbers may be off: each variant goes on with the swing that it has left itself."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from nospill.certification.certificate import certify, judge
from nospill.certification.corners import corner_traces
from nospill.certification.replay import replay
from nospill.errors import ScenarioError
from nospill.margins import Ranges, margins
from nospill.motion.trajectory import Trajectory
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, motion_maxima
from nospill.plans.rows import swing_after, with_residual_slosh
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene
from nospill.scene.swing import LiquidOffset, coordinates
from nospill.scene.tolerances import Corner, corner_scenes
from nospill.transcription.starting_motions import Start
from tests.builders import joint_path_of, smooth_record

RADIUS, LEVEL, OFF, WAIT, DAMPING = 0.035, 0.025, 0.004, 0.1, 0.02
OUT, BACK = 1.3, 1.35
A, B = [0.7, -0.25, 0.4], [0.7, 0.25, 0.4]


def line(start: list[float], end: list[float], **changes: Any) -> Scene:
    """A shallow cup on a level line."""
    cup = {"name": "a", "at": [-0.06, 0.0], "shape": "cylinder", "radius": RADIUS, "height": 0.1, "liquid": "water"}
    cup |= {"liquid_height": LEVEL, "empty_mass": 0.1, "max_slosh_height": 0.03, "damping": DAMPING}
    table: dict[str, Any] = {
        "robot": {"model": "ur10e"},
        "tray": {"size": [0.335, 0.25], "friction": 0.45, "offset": 0.108},
        "cargo": [cup],
        "path": {"type": "line", "start": start, "end": end},
        "motion": {"tilt": "fixed"},
        "planning": {"slosh_modes": 2},
        "tolerance": {"liquid_height": OFF, "damping": [0.5, 2.0]},
    }
    return scene_from_table({**table, **changes}, name="row")


def played(scene: Scene, stretch: float) -> Plan:
    """A plan of a smooth motion that no solver made."""
    record = smooth_record(scene, joint_path_of(scene), 100, Start(stretch))
    judgement = judge(record, scene)
    return Plan(scene, record, judgement.certificate, motion_maxima(judgement, scene), PlanningReport.empty())


@cache
def row() -> tuple[Plan, Plan]:
    """Out, and back after the wait."""
    out = played(line(A, B), OUT)
    return out, played(with_residual_slosh(line(B, A), out, WAIT), BACK)


def corners(scene: Scene) -> dict[str, Corner]:
    return {corner.texts["a"]: corner for corner in corner_scenes(scene)}


def offset_of(text: str) -> LiquidOffset:
    """Read a variant's text."""
    parts = dict(part.rsplit(" ", 1) for part in text.replace(" mm", "").split(", ")) if text else {}
    rise, factor = float(parts.get("fill", 0.0)) / 1e3, float(parts.get("damping", "x1").removeprefix("x"))
    return LiquidOffset(rise, factor)


def test_every_corner_is_integrated_through_both_motions() -> None:
    """The first mode by SciPy: a bead on the parabola whose textbook frequency is sqrt(g k tanh k h), k = 1.8412/R."""
    out, back = row()
    found = corners(back.scene)
    assert len(found) > 6
    k = 1.841183781 / RADIUS
    offsets = [offset_of(text) for text in found]
    level = np.array([LEVEL + offset.liquid_height for offset in offsets])
    omega = np.sqrt(9.80665 * k * np.tanh(k * level))
    ratio, bowl = 2.0 * DAMPING * np.array([offset.damping for offset in offsets]) * omega, omega**2 / 9.80665
    state = np.zeros((2, len(found)))  # all corners side by side
    for plan, sign, rest in ((out, 1.0, WAIT), (back, -1.0, 0.0)):
        record = plan.trajectory
        pushed = CubicSpline(record.t, sign * 0.5 * record.s_acceleration)  # the line is 0.5 m long

        def rate(t: float, y: np.ndarray, pushed=pushed, end=record.t[-1]) -> np.ndarray:
            place, speed = y.reshape(2, -1)
            slope = bowl * place
            pull = -ratio * speed - omega**2 * place - bowl * slope * speed**2 - (pushed(t) if t < end else 0.0)
            return np.concatenate([speed, pull / (1.0 + slope**2)])

        for begin, end in ((0.0, record.t[-1]), (record.t[-1], record.t[-1] + rest)):
            state = solve_ivp(rate, (begin, end), state.ravel(), rtol=1e-8, atol=1e-10).y[:, -1].reshape(2, -1)
    largest = 0.0
    for (text, corner), place, speed, own in zip(found.items(), *state, omega, strict=True):
        end = replay(back.trajectory, corner.scene)
        displaced = end.slosh_displacement[-1, 1], end.slosh_velocity[-1, 1] / own
        assert np.allclose(displaced, (place, speed / own), atol=1.5e-5), text
        largest = max(largest, float(np.hypot(*displaced)))
    assert largest > 1.5e-3  # there is something to compare


def test_rows_are_those_of_one_long_motion() -> None:
    """Out, wait and back as one record from rest: the same heights at every corner, with no swing handed on."""
    out, back = row()
    first, second, dt = out.trajectory, back.trajectory, 1.0 / out.trajectory.rate
    still = np.repeat(first.joint_position[-1:], round(WAIT / dt) - 1, axis=0)
    joints = np.vstack([first.joint_position, still, second.joint_position])
    whole = Trajectory.of_joints(dt * np.arange(len(joints)), first.joints, joints)
    seam = dt * (len(first.t) + len(still))
    alone = {t.variant: t for t in corner_traces(second, back.scene) if t.constraint == "slosh height"}
    together = {t.variant: t for t in corner_traces(whole, line(A, B)) if t.constraint == "slosh height"}
    assert alone.keys() == together.keys()
    heights = []
    for text, trace in alone.items():
        later = together[text].value[together[text].t >= seam - 1e-9]
        assert np.max(trace.value) == pytest.approx(np.max(later), rel=2e-3), text
        heights.append(float(np.max(trace.value)))
    rows = [row for row in certify(second, back.scene).rows if row.constraint == "slosh height"]
    fullest = max(alone.values(), key=lambda trace: float(np.max(trace.use)))  # corners have limits of their own
    assert rows[0].worst_value == pytest.approx(float(np.max(fullest.value)), rel=1e-6)
    # with the swing of the stated liquid for all, as if nothing were off in the motion before, it is another height
    stated = replace(back.scene, cargo=tuple(corner_at_stated(back.scene)))
    wrong = {t.variant: np.max(t.value) for t in corner_traces(second, stated) if t.constraint == "slosh height"}
    assert max(abs(wrong[text] / np.max(trace.value) - 1.0) for text, trace in alone.items()) > 0.03


def corner_at_stated(scene: Scene) -> list[Any]:
    """The cargo, whose every variant begins with the swing of the stated liquid."""
    (cup,) = scene.cargo
    assert cup.filling is not None and cup.filling.initial_swing is not None
    swing = cup.filling.initial_swing
    alike = replace(swing, variants=tuple((offset, replace(swing, variants=())) for offset, _ in swing.variants))
    return [replace(cup, filling=replace(cup.filling, initial_swing=alike))]


def test_a_third_motion_goes_on_from_the_second_at_every_corner() -> None:
    _, back = row()
    left = swing_after(back, 0.0, line(A, B).cargo)["a"]
    for text, corner in corners(back.scene).items():
        end, (cup,) = replay(back.trajectory, corner.scene), corner.scene.cargo
        own = left.of(offset_of(text))
        assert own is not None
        found = coordinates(own, cup.oscillators)
        np.testing.assert_allclose(found[0], end.slosh_displacement[-1], atol=1e-7)


def test_swings_of_variants_survive_writing() -> None:
    scene = row()[1].scene
    again = scene_from_table(tomllib.loads(scene.text()), name="again")
    ours, theirs = (item.cargo[0].filling.initial_swing for item in (scene, again))  # type: ignore[union-attr]
    assert ours == theirs and ours is not None and len(ours.variants) > 4


def test_swings_that_nobody_knows_are_refused() -> None:
    out, back = row()
    source = back.scene.source
    swing = {key: value for key, value in source["cargo"][0]["initial_swing"].items() if key != "variant"}  # type: ignore[index,call-overload]
    with pytest.raises(
        ScenarioError, match=r"initial_swing is not known of a with fill .*: give it in initial_swing\."
    ):
        back.scene.changed({"cargo.a.initial_swing": swing})
    certain = replace(out, scene=out.scene.changed({"tolerance": None}))
    onwards = played(with_residual_slosh(line(B, A).changed({"tolerance": None}), certain, WAIT), BACK)
    with pytest.raises(ScenarioError, match=r"row, the motion before, begins with a swing that is not known with fill"):
        with_residual_slosh(line(A, B), onwards, WAIT)
    with pytest.raises(ScenarioError, match=r'"a" begins with the swing .* --fill 0 --damping 1\.\.1 --position 0'):
        margins(back, samples=3)
    margins(back, samples=3, ranges=Ranges(fill=0.0, damping=(1.0, 1.0), position=0.0))
    # a corner that swings higher than its limit, though the stated liquid does not
    low = max(np.max(t.value) for t in corner_traces(out.trajectory, out.scene) if t.constraint == "slosh height")
    with pytest.raises(ScenarioError, match=r"the surface stands .* when the motion begins with fill .*, above"):
        crests = [_crest(own) for _, own in row()[1].scene.cargo[0].filling.initial_swing.variants]  # type: ignore[union-attr]
        assert max(crests) < low
        back.scene.changed({"cargo.a.max_slosh_height": 0.98 * max(crests)})


def _crest(swing: Any) -> float:
    """Height at the wall by the first mode alone and the second, m."""
    scene = row()[1].scene
    gains = [mode.surface_gain for mode in scene.cargo[0].oscillators]
    return abs(sum(gain * y for gain, (_, y) in zip(gains, swing.displacement, strict=False)))
