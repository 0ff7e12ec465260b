"""The joint file of the laboratory that published the experiments (LAR-IRMA, Smart SiX).

Six columns in rad separated by ";", one row every 2 ms, no header and no time. The file starts with at least 500
identical rows, one second at rest in which the controller reaches the start. Written with 12 decimals: with 6, rounding
alone would show as up to 2.5 rad/s^2 of acceleration at this rate.
"""

from __future__ import annotations

import io
import math
from pathlib import Path

import numpy as np

from nospill.core.files import atomic_text
from nospill.errors import PlanFolderError, ScenarioError
from nospill.export.base import Exporter
from nospill.motion.holds import hold_periods
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.scene.scene import Scene

LAB_RATE = 500.0
"""Rows the laboratory's controller plays per second, Hz."""

JOINTS = 6
HOLD_ROWS = 500
"""Identical rows the controller wants before the motion."""

DECIMALS = 12


def write_lab_csv(joints: np.ndarray, path: str | Path, *, rate: float, hold: float = 1.0) -> None:
    """Write a joint motion as the laboratory's file.

    Args:
        joints: (samples, 6) joint positions, rad.
        path: file to write, at once or not at all.
        rate: samples per second of `joints`, Hz; must be what the controller plays, 500.
        hold: rest before the motion, s, at least 1.

    Raises:
        ScenarioError: the motion does not fit the format.
        PlanFolderError: the file cannot be written.
    """
    joints = np.asarray(joints, dtype=float)
    columns = joints.shape[1] if joints.ndim == 2 else 0
    reason = _reason_against(rate, columns)
    if reason is not None:
        raise ScenarioError(reason)
    if len(joints) < 2 or not np.all(np.isfinite(joints)):
        raise ScenarioError(f"{path}: the lab file wants at least 2 samples, all finite; this motion has {len(joints)}")
    rest = round(hold * rate) if math.isfinite(hold) else 0
    if rest < HOLD_ROWS:
        raise ScenarioError(
            f"{path}: hold is {hold:g} s; the lab's controller wants 1 s of rest or more before the motion"
        )
    rows = np.vstack([np.repeat(joints[:1], rest, axis=0), joints])
    rows = np.round(rows, DECIMALS) + 0.0  # turns -0.0 into 0.0
    text = io.StringIO()
    np.savetxt(text, rows, fmt=f"%.{DECIMALS}f", delimiter=";")
    atomic_text(path, text.getvalue())


def read_lab_csv(path: str | Path, *, rate: float, held: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Read a laboratory's file without the rest it starts with.

    Every row that equals the first counts as rest; the last of them is the motion's first sample.

    Args:
        path: the file.
        rate: rows per second, Hz.
        held: how many of the rows of rest belong to the motion, beyond those the format wants.

    Returns:
        Time (samples,) in s from 0 and joint positions (samples, 6) in rad.

    Raises:
        PlanFolderError: no such file, or a row that is not six finite numbers, or less rest than the format wants.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").rstrip().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not a text file"
        raise PlanFolderError(f"cannot read {path}: {reason}; write it again with nospill plan") from error
    rows = np.array([_row(line, f"{path}, line {number}") for number, line in enumerate(lines, 1)]).reshape(-1, JOINTS)
    moved = np.flatnonzero(np.any(rows != rows[:1], axis=1))
    identical = int(moved[0]) if len(moved) else len(rows)
    if identical < HOLD_ROWS + held:
        wanted = f"the lab's format wants {HOLD_ROWS} or more"
        wanted += f", and the hold before the motion {held}" if held else ""
        raise PlanFolderError(f"{path}: starts with {identical} identical rows; {wanted}")
    motion = rows[identical - 1 - held :]
    return np.arange(len(motion)) / rate, motion


def _row(line: str, where: str) -> list[float]:
    try:
        values = [float(cell) for cell in line.split(";")]
    except ValueError:
        values = []
    if len(values) != JOINTS or not all(map(math.isfinite, values)):
        raise PlanFolderError(f'{where}: "{line[:60]}" is not six finite numbers separated by ";"')
    return values


def _reason_against(rate: float, joints: int) -> str | None:
    if joints != JOINTS:
        return f"the lab's joint file has {JOINTS} columns; this motion has {joints} joints"
    if rate != LAB_RATE:
        wanted = f"the lab's controller plays {LAB_RATE:g} rows a second"
        return f"rate is {rate:g} Hz; {wanted}; use --rate 500, or 500 Hz under [output]"
    return None


def _scene_reason(scene: Scene, rate: float) -> str | None:
    return _reason_against(rate, len(scene.robot.joints))


def _write(samples: JointSamples, scene: Scene, path: Path) -> None:
    write_lab_csv(samples.position, path, rate=round(samples.rate, 3))


def _read(path: Path, scene: Scene) -> JointSamples:
    t, joints = read_lab_csv(path, rate=LAB_RATE, held=hold_periods(scene.motion, LAB_RATE)[0])
    return JointSamples(t, joints)


LAB_CSV = Exporter(
    name="lab-csv",
    suffixes=(".robot.csv",),
    title="six joints in rad, ';', 500 Hz, 1 s of rest first (LAR-IRMA, Smart SiX)",
    receiver="the laboratory's controller: a row every 2 ms under position control (quintic spline)",
    interpolation=QUINTIC_SPLINE,
    reason_against=_scene_reason,
    write=_write,
    read=_read,
    plan_file="robot.csv",
)
"""The laboratory's joint file as an exporter."""
