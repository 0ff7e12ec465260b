"""A motion beside a path whose ends were moved."""

from __future__ import annotations

import numpy as np

from nospill.laws.scene_parameters import structure_of
from nospill.path_search.candidates import with_path
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene
from nospill.transcription.layout import layout_of
from nospill.transcription.starting_motions import quintic, smooth_start
from nospill.transcription.trajectory_start import on_moved_path
from tests.builders import joint_path_of


def along(goal: list[float], yaw: float) -> Scene:
    table = read_scenario("cups-around-a-column").source | {"obstacle": []}
    ends = {"type": "free", "start": {"position": [0.6, -0.3, 0.5]}, "goal": {"position": goal, "yaw": yaw}}
    scene, s = scene_from_table({**table, "path": ends}, name="moved"), np.linspace(0.0, 1.0, 21)
    arc = scene.path.at(s) + np.outer(np.sin(np.pi * s), [0.0, 0.0, 0.15, 0.0])
    return with_path(scene.with_one_mode(), arc[:, :3], arc[:, 3]).with_one_mode()


def test_the_tray_goes_where_it_went_and_to_the_new_end_by_a_quintic_in_time() -> None:
    before, scene = along([0.6, 0.3, 0.5], 0.2), along([0.65, 0.36, 0.45], -0.1)
    motion = smooth_start(before, joint_path_of(before), 40)
    moved = on_moved_path(motion, before, scene)
    freedom = layout_of(structure_of(scene)).freedom
    beside = moved.table[:, [3 * chain for chain in (*freedom.offset_chains, *freedom.turn_chains)]]
    share = quintic(np.linspace(0.0, 1.0, 41))[0][:, None]
    led = before.path.at(motion.table[:, 0]) + share * (scene.path.at(1.0) - before.path.at(1.0))
    np.testing.assert_allclose(scene.path.at(moved.table[:, 0]) + beside, led, atol=1e-12)
    for chain in (*freedom.offset_chains, *freedom.turn_chains):  # rates are those of the places
        place, rate, change = moved.table[:, 3 * chain : 3 * chain + 3].T
        np.testing.assert_allclose(np.gradient(place, moved.interval)[2:-2], rate[2:-2], atol=0.02)
        np.testing.assert_allclose(np.gradient(rate, moved.interval)[2:-2], change[2:-2], atol=0.2)
