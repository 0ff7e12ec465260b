"""Builders of what many tests need: changed tables, the joint path of a scene, the folder of measured data."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from benchmarks.slosh.validate import data_folder
from nospill.motion.trajectory import Trajectory
from nospill.robots.joint_paths.search import JointPath, joint_paths
from nospill.scene.scene import Scene
from nospill.transcription.export_samples import export_samples
from nospill.transcription.starting_motions import Start, smooth_start


def changed_table(table: Mapping[str, Any], changes: Mapping[str, object]) -> dict[str, Any]:
    """A scenario's table with new values by place, for example {"motion.tilt": "fixed", "cargo.0.mass": 0.2}."""
    changed: Any = copy.deepcopy(dict(table))
    for place, value in changes.items():
        *parents, key = place.split(".")
        entry = changed
        for parent in parents:
            entry = entry[int(parent)] if isinstance(entry, list) else entry.setdefault(parent, {})
        entry[int(key) if isinstance(entry, list) else key] = value
    return changed


def joint_paths_of(scene: Scene, *, samples: int = 101) -> list[JointPath]:
    """Every joint motion that carries the scene's level tray along its path."""
    return joint_paths(scene.robot, scene.path, tool=scene.tray.tool, samples=samples)


def joint_path_of(scene: Scene, *, samples: int = 101) -> JointPath:
    """The first of them."""
    return joint_paths_of(scene, samples=samples)[0]


def smooth_record(scene: Scene, path: JointPath, intervals: int, start: Start) -> Trajectory:
    """A smooth motion of a scene as a plan records it: with one mode of each liquid."""
    model = scene.with_one_mode()
    return export_samples(model, smooth_start(model, path, intervals, start))


def measured_data(name: str = "") -> Path:
    """A file or folder of measured and published data, where NOSPILL_DATA says; the test skips without it."""
    place = data_folder() / name
    if not place.exists():
        pytest.skip(f"measured data are not here: {place}; NOSPILL_DATA names their folder")
    return place
