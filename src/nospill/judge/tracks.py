"""Liquids along a motion as samples, whatever liquids the motion was planned for."""

from __future__ import annotations

from collections.abc import Mapping

from nospill.judge.certificate import constraint_traces
from nospill.judge.replay import replay
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.scene_parameters import structure_of
from nospill.motion.trajectory import SloshTrack, Trajectory
from nospill.scene.scene import Scene
from nospill.scene.tolerances import corner_scenes
from nospill.scene.variants import VariantId


def liquid_tracks(trajectory: Trajectory, scene: Scene, names: Mapping[str, str]) -> dict[str, SloshTrack]:
    """The liquids of a scene along a motion, integrated as for its certificate, at the samples.

    Args:
        trajectory: the motion; its own liquids are not read.
        scene: whose liquids.
        names: object -> what its track is called; others are left out.
    """
    played = replay(trajectory, scene)
    every = round(played.rate / trajectory.rate)
    traces = constraint_traces(trajectory, scene, played, points=(EvaluationPoint.OBJECT,))
    heights = {trace.subject: trace.value[::every] for trace in traces if trace.constraint == SloshHeight.name}
    found = {}
    for cargo, own in zip(scene.cargo, structure_of(scene).slosh_slices, strict=True):
        if cargo.oscillators and cargo.name in names:
            parts = (played.slosh_displacement[::every, own], played.slosh_velocity[::every, own])
            found[names[cargo.name]] = SloshTrack(*parts, heights[cargo.name])
    return found


def variant_tracks(trajectory: Trajectory, scene: Scene, names: Mapping[VariantId, str]) -> dict[str, SloshTrack]:
    """The liquids of some variants of a scene's objects along a motion, likewise.

    Args:
        trajectory: the motion.
        scene: whose objects; where they are certain, there is nothing to add to the trajectory's own liquids.
        names: variant -> what its track is called; others are left out.
    """
    found = dict(trajectory.slosh)
    for corner in corner_scenes(scene):
        wanted = {name: names[name, text] for name, text in corner.texts.items() if (name, text) in names}
        found |= liquid_tracks(trajectory, corner.scene, wanted) if wanted else {}
    return found
