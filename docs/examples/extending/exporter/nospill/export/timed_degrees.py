"""Joints in degrees with a column of time, as spreadsheets and many teach pendants want them."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from nospill.core.files import atomic_text
from nospill.errors import PlanFolderError
from nospill.export.base import Exporter, checked_samples
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.scene.scene import Scene


def _anything_goes(scene: Scene, rate: float) -> str | None:
    return None


def _write(samples: JointSamples, scene: Scene, path: Path) -> None:
    table = np.column_stack([samples.t, np.degrees(samples.position)])
    header = ",".join(["t_s", *(f"{joint}_deg" for joint in scene.robot.joints)])
    text = io.StringIO()
    np.savetxt(text, table, fmt="%.12f", delimiter=",", header=header, comments="")
    atomic_text(path, text.getvalue())


def _read(path: Path, scene: Scene) -> JointSamples:
    try:
        table = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    except (OSError, ValueError) as error:
        raise PlanFolderError(f"{path}: cannot be read as times and joint angles ({error})") from error
    if table.shape[1] != 1 + len(scene.robot.joints):
        raise PlanFolderError(f"{path}: {table.shape[1]} columns; a time and {len(scene.robot.joints)} joints wanted")
    return checked_samples(JointSamples(table[:, 0], np.radians(table[:, 1:])), path)


TIMED_DEGREES = Exporter(
    name="timed-degrees",
    suffixes=(".deg.csv",),
    title="time in s and joints in deg, comma, with a header",
    receiver="a spreadsheet, or a controller that puts a smooth curve through the rows",
    interpolation=QUINTIC_SPLINE,
    reason_against=_anything_goes,
    write=_write,
    read=_read,
    plan_file="joints.deg.csv",
)
"""Times and joint angles in degrees as an exporter."""
