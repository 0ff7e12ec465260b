"""Joints in degrees with a column of time, as spreadsheets and many teach pendants want them."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from nospill.errors import PlanFolderError
from nospill.export.base import Exporter
from nospill.files import atomic_text
from nospill.scene import Scene
from nospill.trajectory import Trajectory


def _anything_goes(scene: Scene) -> str | None:
    return None


def _write(trajectory: Trajectory, scene: Scene, path: Path) -> None:
    table = np.column_stack([trajectory.t, np.degrees(trajectory.joint_position)])
    header = ",".join(["t_s", *(f"{joint}_deg" for joint in scene.robot.joints)])
    text = io.StringIO()
    np.savetxt(text, table, fmt="%.10f", delimiter=",", header=header, comments="")
    atomic_text(path, text.getvalue())


def _read(path: Path, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    try:
        table = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    except (OSError, ValueError) as error:
        raise PlanFolderError(f"{path}: cannot be read as times and joint angles ({error})") from error
    if table.shape[1] != 1 + len(scene.robot.joints):
        raise PlanFolderError(f"{path}: {table.shape[1]} columns; a time and {len(scene.robot.joints)} joints wanted")
    return table[:, 0] - table[0, 0], np.radians(table[:, 1:])


TIMED_DEGREES = Exporter(
    name="timed-degrees",
    file_name="joints_deg.csv",
    title="time in s and joints in deg, comma, with a header",
    reason_against=_anything_goes,
    write=_write,
    read=_read,
)
"""Times and joint angles in degrees as an exporter."""
