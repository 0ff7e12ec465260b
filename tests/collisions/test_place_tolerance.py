"""Objects whose place may be off: their bodies hold them at every place that the tolerance allows."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.certification.certificate import certify
from nospill.collisions.along_path import nearest_of_tray
from nospill.collisions.bodies import Body, cargo_shape, scene_bodies
from nospill.errors import ScenarioError
from nospill.path_search.branches import free_paths
from nospill.robots.description.urdf_tree import about_axis
from nospill.scenario.loading import load
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.transcription.starting_motions import Start
from tests.builders import joint_paths_of, smooth_record

OFF = 0.02
ROD = {"name": "rod", "shape": "box", "length": 0.06, "width": 0.04, "height": 0.2, "mass": 0.3, "at": [0.05, 0.0]}


def reach(item: Cargo, direction: np.ndarray, off: tuple[float, float] = (0.0, 0.0)) -> float:
    """Largest coordinate along a unit vector of the tray frame of an object off its place, by its own corners."""
    shape, turn = cargo_shape(item), about_axis((0.0, 0.0, 1.0), item.yaw)
    points = item.place + [*off, 0.0] + shape.points @ turn.T
    return float(np.max(points @ direction + math.hypot(*direction[:2]) * shape.discs))


def body_reach(body: Body, item: Cargo, direction: np.ndarray) -> float:
    turn = about_axis((0.0, 0.0, 1.0), item.yaw)
    points = item.place + body.shape.points @ turn.T
    return float(np.max(points @ direction + math.hypot(*direction[:2]) * body.shape.discs))


@given(yaw=st.floats(-3.0, 3.0), turn=st.floats(0.0, 6.3), rise=st.floats(-1.5, 1.5), off=st.floats(1e-4, 0.05))
def test_a_body_reaches_as_far_as_at_its_corners(yaw: float, turn: float, rise: float, off: float) -> None:
    """Support functions: that of all places in a square is that of its four corners, no more and no less."""
    direction = np.array([math.cos(rise) * math.cos(turn), math.cos(rise) * math.sin(turn), math.sin(rise)])
    for stated in load("mixed-tray").cargo:
        item = replace(stated, yaw=yaw)
        wide = Body(item.name, 0, cargo_shape(item, place_tolerance=off), np.zeros(3), np.eye(3))
        at_corners = max(reach(item, direction, (x, y)) for x in (-off, off) for y in (-off, off))
        assert body_reach(wide, item, direction) == pytest.approx(at_corners, abs=1e-9)


def scene_with(changed_scene, position: float, obstacle_x: float, **more: object) -> Scene:
    beam = {"name": "beam", "shape": "box", "size": [0.1, 1.5, 1.5], "at": [obstacle_x, 0.0, 1.25], "clearance": 0.005}
    changes = {
        "cargo": [{**ROD, "tolerance": {"position": position}}],
        "path": {"type": "line", "start": [0.6, -0.2, 0.4], "end": [0.6, 0.2, 0.4], "yaw": [0.0, 0.0]},
        "motion": {"tilt": "fixed"},
        "tray": {"size": [0.2, 0.1], "offset": 0.1, "friction": 0.4},
        "robot": {"model": "ur10e"},
        "obstacle": [beam],
        **more,
    }
    return changed_scene("coffee-to-go", {key: value for key, value in changes.items() if value is not None})


FACE = 0.6 + 0.05 + 0.03
"""m; x of the rod's outer side along the path."""


def test_the_distance_on_the_path_is_that_of_the_widened_object(changed_scene) -> None:
    """30 mm between the rod and a wall, by hand: 10 mm of it are left with a tolerance of 20 mm."""
    for off in (0.0, OFF):
        scene = scene_with(changed_scene, off, FACE + 0.03 + 0.05)
        found = nearest_of_tray(scene, scene.path)
        assert found.slack == pytest.approx(0.03 - off - 0.005, abs=1e-6) and found.pair.first.name == "rod"


def test_the_certificate_includes_the_tolerance_and_says_so(changed_scene) -> None:
    rows = {}
    for off in (0.0, OFF):
        scene = scene_with(changed_scene, off, FACE + 0.03 + 0.05)
        path = free_paths(scene, joint_paths_of(scene))[0]
        certificate = certify(smooth_record(scene, path, 50, Start(2.0)), scene)
        rows[off] = next(row for row in certificate.rows if row.label.startswith("rod to beam"))
    assert rows[0.0].variant == "" and rows[OFF].variant == "position +-20 mm"
    # stated distances lie below the true one by a tenth of what is left of the limit at most
    assert 0.03 - 0.0026 <= rows[0.0].worst_value <= 0.03 + 1e-6
    assert 0.01 - 0.0006 <= rows[OFF].worst_value <= 0.01 + 1e-6


def test_what_may_stand_in_an_obstacle_is_refused(changed_scene) -> None:
    """6 mm from the wall as stated, 14 mm inside at the end of its tolerance."""
    scene = scene_with(changed_scene, OFF, FACE + 0.006 + 0.05)
    with pytest.raises(ScenarioError, match=r'"rod" enters "beam" by 14 mm where .* \(position \+-20 mm\)'):
        free_paths(scene, joint_paths_of(scene))


def test_a_carrier_takes_along_what_stands_in_it(changed_scene) -> None:
    """The vials of a rack are widened by the tolerance of the rack, in which they stand."""
    stated, loose = (changed_scene("vial-rack", {"tolerance": {"position": off}}) for off in (0.0, 0.004))
    before, after = ({body.name: body for body in scene_bodies(scene)} for scene in (stated, loose))
    carried = [item for item in stated.cargo if item.carrier]
    assert carried
    for item in (*carried, *stated.standing):
        assert after[item.name].place_tolerance == 0.004 and before[item.name].place_tolerance == 0.0
        direction = np.array([1.0, 0.0, 0.0])
        wider = body_reach(after[item.name], item, direction) - body_reach(before[item.name], item, direction)
        assert wider == pytest.approx(0.004, abs=1e-9)
