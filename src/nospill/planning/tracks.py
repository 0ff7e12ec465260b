"""Liquids of a scene along a motion whose problem held other liquids."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from nospill.judge.certificate import constraint_traces
from nospill.judge.replay import replay
from nospill.laws.constraints.base import Place
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.scene_parameters import structure_of
from nospill.motion.trajectory import SloshTrack, Trajectory
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import Candidate, exported
from nospill.planning.task import Task
from nospill.scene.scene import Scene
from nospill.scene.tolerances import corner_scenes
from nospill.transcription.guess import from_trajectory
from nospill.transcription.stages import Stages


def recorded(candidate: Candidate) -> Trajectory:
    """The samples of a motion with the stated liquids of the whole scene, which is what a plan records.

    Raises:
        ModelError: the joints cannot follow, or the liquids cannot be integrated.
    """
    trajectory, scene = exported(candidate), candidate.task.scene
    if [item.name for item in candidate.active.scene.cargo] == [item.name for item in scene.cargo]:
        return trajectory
    return replace(trajectory, slosh=_tracks(trajectory, scene, {item.name: item.name for item in scene.cargo}))


def started_from(task: Task, active: ActiveSet, trajectory: Trajectory, intervals: int) -> Stages:
    """A motion of the whole scene as a start for the members of a problem."""
    names = task.names()
    found = dict(trajectory.slosh)
    for corner in corner_scenes(task.scene):
        wanted = {name: names[name, text] for name, text in corner.texts.items() if (name, text) in active.members}
        found |= _tracks(trajectory, corner.scene, wanted) if wanted else {}
    return from_trajectory(active.scene, replace(trajectory, slosh=found), intervals)


def _tracks(trajectory: Trajectory, scene: Scene, names: Mapping[str, str]) -> dict[str, SloshTrack]:
    """The liquids of a scene along a motion as the judge integrates them, at the samples.

    Args:
        trajectory: the motion; its own liquids are not read.
        scene: whose liquids.
        names: object -> what its track is called; others are left out.
    """
    played = replay(trajectory, scene)
    every = round(played.rate / trajectory.rate)
    traces = constraint_traces(trajectory, scene, played, places=(Place.OBJECT,))
    heights = {trace.subject: trace.value[::every] for trace in traces if trace.constraint == SloshHeight.name}
    found, first = {}, 0
    for cargo, item in zip(scene.cargo, structure_of(scene).objects, strict=True):
        own = slice(first, first + item.coordinates)
        first = own.stop
        if item.oscillators and cargo.name in names:
            parts = (played.slosh_displacement[::every, own], played.slosh_velocity[::every, own])
            found[names[cargo.name]] = SloshTrack(*parts, heights[cargo.name])
    return found
