"""A rack whose vials crest high is judged with every vial by itself, one whose vials do not with four for all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.carriers import LUMPED_UP_TO, with_liquids_apart
from nospill.certification.certificate import certify
from nospill.certification.replay import replay
from nospill.certification.traces import constraint_traces
from nospill.certification.verdict import Trace
from nospill.laws.constraints.base import OF_OBJECTS
from nospill.motion.trajectory import Trajectory
from nospill.scenario import scene_from_table
from nospill.scene.carriers import with_single_liquids
from nospill.scene.scene import Scene
from nospill.transcription.starting_motions import Start
from tests.builders import joint_path_of, smooth_record

RADIUS = 0.011


def tried(stretch: float) -> tuple[Scene, Trajectory, tuple[Trace, ...], float]:
    """A rack that turns on a smooth motion: its traces with four liquids for all, and the greatest crest over R."""
    rack = {"name": "rack", "shape": "box", "length": 0.15, "width": 0.125, "height": 0.04, "mass": 0.34}
    vial = {"name": "vial", "carrier": "rack", "at": [0.0, 0.0], "seat_height": 0.009, "shape": "cylinder"}
    vial |= {"radius": RADIUS, "height": 0.046, "liquid": "water", "liquid_height": 0.016, "empty_mass": 0.003}
    table = {
        "robot": {"model": "ur10e"},
        "tray": {"size": [0.31, 0.36], "friction": 0.87, "offset": 0.08},
        "cargo": [{**rack, "at": [0.045, 0.1]}, {**vial, "array": {"count": [5, 4], "pitch": [0.026, 0.026]}}],
        "path": {"type": "line", "start": [0.7, -0.3, 0.4], "end": [0.7, 0.3, 0.4], "yaw": ["0 deg", "120 deg"]},
        "planning": {"slosh_modes": 1},
    }
    scene = scene_from_table(table, name="rack")
    record = smooth_record(scene, joint_path_of(scene), 100, Start(stretch))
    traces = constraint_traces(record, scene, replay(record, scene), points=OF_OBJECTS)
    crest = max(float(np.max(trace.value)) for trace in traces if trace.constraint == "slosh height")
    return scene, record, traces, crest / RADIUS


def of_rack(traces: tuple[Trace, ...]) -> dict[str, float]:
    return {trace.constraint: float(np.max(trace.use)) for trace in traces if trace.subject == "rack"}


def test_high_crests_are_judged_vial_by_vial() -> None:
    scene, record, traces, crest = tried(0.4)
    assert crest > LUMPED_UP_TO
    apart = with_liquids_apart(traces, record, scene)
    assert [trace.id for trace in apart] == [trace.id for trace in traces]
    few, single = of_rack(traces), of_rack(apart)
    assert few.keys() == single.keys() == {"slip", "tip", "lift", "twist"}
    assert max(abs(single[name] - few[name]) for name in few) > 1e-4  # there is a difference
    rows = {row.constraint: row for row in certify(record, scene).rows if row.subject == "rack"}
    for name in ("slip", "tip", "twist"):
        assert rows[name].use == pytest.approx(single[name], rel=1e-5)
    others = [trace for trace in apart if trace.subject != "rack"]
    assert all(any(trace is own for own in traces) for trace in others)


def test_a_rack_is_pressed_by_the_sum_of_all_vials_at_high_crests() -> None:
    """Pressing forces, N, of the rack by itself and of every vial, which has its own row of lift."""
    scene, record, traces, _ = tried(0.4)
    rack, *vials = scene.cargo
    shown = {trace.subject: trace.value for trace in traces if trace.constraint == "lift"}
    bare = replace(scene, cargo=(scene.changed({"cargo": scene.source["cargo"][:1]}).cargo[0],))  # type: ignore[index]
    single = replace(scene, cargo=(with_single_liquids(rack),))
    alone = {
        name: next(trace.value for trace in found if trace.constraint == "lift")
        for name, of in (("bare", bare), ("single", single))
        for found in [constraint_traces(record, of, replay(record, of), points=OF_OBJECTS)]
    }
    masses = {cargo.name: cargo.total.mass for cargo in scene.cargo}
    total = alone["bare"] * bare.cargo[0].total.mass + sum(shown[vial.name] * masses[vial.name] for vial in vials)
    np.testing.assert_allclose(alone["single"] * masses["rack"], total, rtol=2e-6)
    assert np.abs(shown["rack"] * masses["rack"] / total - 1.0).max() > 2e-5  # four for all are not as near


def test_low_crests_are_judged_with_four_for_all() -> None:
    scene, record, traces, crest = tried(1.6)
    assert crest < LUMPED_UP_TO
    assert with_liquids_apart(traces, record, scene) == traces
