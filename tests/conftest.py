"""What several test files share: measured data, and smooth motions that need no solver."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import pytest

from nospill.ocp.answer import export_samples
from nospill.ocp.guess import Start, smooth_start
from nospill.ocp.stages import Stages
from nospill.robots.inverse import JointPath, joint_paths
from nospill.scenario import read_scenario
from nospill.scene import Scene
from nospill.trajectory import Trajectory

# No compiler at work behind the tests, and none of the user's compiled functions in them.
os.environ.setdefault("NOSPILL_COMPILE", "off")


@dataclass(frozen=True)
class SmoothMotion:
    """A scene with a quintic motion along its path, on the grid of the optimal control problem and as exported."""

    scene: Scene
    stages: Stages
    trajectory: Trajectory


@cache
def _joint_path(name: str) -> JointPath:
    scene = read_scenario(name)
    return joint_paths(scene.robot, scene.path, tool_position=scene.tray.offset, tool_yaw=scene.tray.yaw_on_flange)[0]


@cache
def _smooth_motion(name: str, cargo: int | None, intervals: int, start: Start) -> SmoothMotion:
    scene = read_scenario(name)
    scene = replace(scene, cargo=scene.cargo[:cargo])
    stages = smooth_start(scene, _joint_path(name), intervals, start)
    return SmoothMotion(scene, stages, export_samples(scene, stages))


@pytest.fixture(scope="session")
def smooth_motion() -> Callable[..., SmoothMotion]:
    """Make (once) the smooth motion of an example: name, number of objects kept, intervals, and how it starts."""

    def make(
        name: str,
        *,
        cargo: int | None = None,
        intervals: int = 200,
        stretch: float = 1.0,
        skew: float = 0.0,
        tilt: tuple[float, float] = (0.0, 0.0),
    ) -> SmoothMotion:
        return _smooth_motion(name, cargo, intervals, Start(stretch, skew, tilt))

    return make


@pytest.fixture(scope="session")
def measured() -> Path:
    """The folder of measured and published data, named by NOSPILL_DATA; tests that ask for it are skipped without."""
    folder = Path(os.environ.get("NOSPILL_DATA", Path(__file__).parents[2] / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"measured data missing: {folder}; set NOSPILL_DATA")
    return folder
