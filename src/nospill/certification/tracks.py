"""Liquids along a motion as samples, whatever liquids the motion was planned for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from nospill.certification.certificate import constraint_traces
from nospill.certification.record_checks import recorded_coordinates
from nospill.certification.replay import Replay, replay
from nospill.certification.verdict import Trace
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.scene_parameters import object_structure, structure_of
from nospill.motion.at_speed import at_speed
from nospill.motion.trajectory import SloshTrack, Trajectory
from nospill.scene.cargo import Cargo
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
    traces = constraint_traces(trajectory, scene, played, points=(EvaluationPoint.OBJECT,))
    tracks = _tracks(trajectory, scene, played, traces)
    return {names[name]: track for name, track in tracks.items() if name in names}


def judged_tracks(
    trajectory: Trajectory, scene: Scene, played: Replay, traces: Iterable[Trace]
) -> dict[str, SloshTrack]:
    """The liquids as they were judged, at the samples, by object: all modes that the scene's cargo has.

    Args:
        trajectory: the motion, without its holds.
        scene: whose liquids.
        played: its replay, with its holds or without.
        traces: of the replay, those of the slosh height among them.
    """
    filled = {cargo.name for cargo in scene.cargo if cargo.filling}
    return {name: track for name, track in _tracks(trajectory, scene, played, traces).items() if name in filled}


def _tracks(trajectory: Trajectory, scene: Scene, played: Replay, traces: Iterable[Trace]) -> dict[str, SloshTrack]:
    """The same and of every carrier the modal masses that push it, without heights."""
    every, first = round(played.rate / trajectory.rate), round((trajectory.t[0] - played.t[0]) * played.rate)
    picked = slice(first, first + every * (len(trajectory.t) - 1) + 1, every)
    heights = {trace.subject: trace.value[picked] for trace in traces if trace.constraint == SloshHeight.name}
    return {
        cargo.name: SloshTrack(
            played.slosh_displacement[picked, modes],
            played.slosh_velocity[picked, modes],
            heights.get(cargo.name, np.zeros(len(trajectory.t))),
        )
        for cargo, modes in zip(scene.cargo, structure_of(scene).slosh_slices, strict=True)
        if cargo.oscillators
    }


def with_recorded_modes(trajectory: Trajectory, scene: Scene) -> Trajectory:
    """The record with the modes that a scenario records, the first ones; heights are of all."""
    slosh = {}
    for cargo in scene.cargo:
        if cargo.name in trajectory.slosh:
            track, count = trajectory.slosh[cargo.name], recorded_coordinates(cargo, scene)
            slosh[cargo.name] = replace(
                track, displacement=track.displacement[:, :count], velocity=track.velocity[:, :count]
            )
    return replace(trajectory, slosh=slosh)


def variant_tracks(trajectory: Trajectory, scene: Scene, names: Mapping[VariantId, str]) -> dict[str, SloshTrack]:
    """The liquids of some variants of a scene's objects along a motion, likewise.

    Args:
        trajectory: the motion.
        scene: whose objects; the stated ones are taken from the trajectory where it has all of their modes.
        names: variant -> what its track is called; others are left out.
    """
    tracks_of = dict(trajectory.slosh)
    unknown = [
        cargo.name for cargo in scene.cargo if cargo.oscillators and not _is_whole(tracks_of.get(cargo.name), cargo)
    ]
    if unknown:
        tracks_of |= liquid_tracks(trajectory, scene, dict(zip(unknown, unknown, strict=True)))
    for corner in corner_scenes(scene):
        wanted = {name: names[name, text] for name, text in corner.texts.items() if (name, text) in names}
        if wanted:
            tracks = liquid_tracks(at_speed(trajectory, corner.speed), corner.scene, wanted)
            tracks_of |= {name: _in_planned_time(track, corner.speed) for name, track in tracks.items()}
    return tracks_of


def _in_planned_time(track: SloshTrack, speed: float) -> SloshTrack:
    """A liquid of a slow motion on the clock of the planned one."""
    return track if speed == 1.0 else replace(track, velocity=track.velocity / speed)


def _is_whole(track: SloshTrack | None, cargo: Cargo) -> bool:
    return track is not None and track.displacement.shape[1] == object_structure(cargo).coordinates
