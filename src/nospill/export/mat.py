"""A MATLAB file (version 5): time, joint positions, speeds and accelerations, with names and units.

Variables: t (m, 1), q, qd, qdd (m, n), joint_names (1, n cell), units and about (structures of text). Who plays the
file decides how; `about.interpolation` names what is certified, a quintic polynomial per segment through q, qd and qdd
of both its ends (in Simulink: a lookup of the coefficients; in MATLAB: `quinticpolytraj` of the Robotics System
Toolbox with velocity and acceleration boundary conditions).
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from nospill.core.files import atomic_bytes
from nospill.errors import PlanFolderError
from nospill.export.base import Exporter, checked_samples, full_columns, require_joints
from nospill.motion.interpolation import QUINTIC_HERMITE, JointSamples
from nospill.scene.scene import Scene

UNITS = {"t": "s", "q": "rad", "qd": "rad/s", "qdd": "rad/s^2"}
"""Variables and their units."""


def _write(samples: JointSamples, scene: Scene, path: Path) -> None:
    from scipy.io import savemat

    speed, acceleration = full_columns(samples)
    names = np.empty((1, len(scene.robot.joints)), dtype=object)
    names[0] = scene.robot.joints
    content = io.BytesIO()
    variables = {"t": samples.t[:, None], "q": samples.position, "qd": speed, "qdd": acceleration}
    about = {"scenario": scene.name, "robot": scene.robot.name, "interpolation": QUINTIC_HERMITE.title}
    savemat(content, variables | {"joint_names": names, "units": UNITS, "about": about}, do_compression=True)
    atomic_bytes(path, content.getvalue())


def _read(path: Path, scene: Scene) -> JointSamples:
    from scipy.io import loadmat

    try:
        content = loadmat(io.BytesIO(path.read_bytes()), simplify_cells=True)
    except OSError as error:
        raise PlanFolderError(f"cannot read {path}: {error.strerror}; write it again with nospill export") from error
    except Exception as error:  # the library lets whatever a damaged file provokes through
        reason = " ".join(str(error).split()) or type(error).__name__
        raise PlanFolderError(f"{path}: damaged, or not a MATLAB file of version 5 ({reason[:120]})") from error
    missing = [name for name in (*UNITS, "joint_names", "units") if name not in content]
    if missing:
        raise PlanFolderError(f"{path}: the variable {missing[0]} is missing")
    require_joints(np.atleast_1d(content["joint_names"]).tolist(), scene, path)
    if content["units"] != UNITS:
        raise PlanFolderError(f"{path}: its units are {str(content['units'])[:120]}; {UNITS} are expected")
    t_shape = (np.size(content["t"]),)
    shape = (*t_shape, len(scene.robot.joints))
    columns = {name: _column(content[name], t_shape if name == "t" else shape, f"{path}, {name}") for name in UNITS}
    return checked_samples(JointSamples(columns["t"], columns["q"], columns["qd"], columns["qdd"]), path)


def _column(values: Any, shape: tuple[int, ...], where: str) -> np.ndarray:
    array = np.asarray(values)
    if array.shape == tuple(size for size in shape if size != 1):  # the library drops axes of one
        array = array.reshape(shape)
    if array.shape != shape or array.dtype.kind not in "fiu" or not np.all(np.isfinite(array)):
        found = f"an array of shape {array.shape}, {array.dtype}"
        raise PlanFolderError(f"{where}: {found}; finite numbers of shape {shape} are expected")
    return array.astype(float)


MAT = Exporter(
    name="mat",
    suffixes=(".mat",),
    title="MATLAB file: t, q, qd, qdd with joint names and units",
    receiver="MATLAB or Simulink: a quintic polynomial per segment through position, speed and acceleration",
    interpolation=QUINTIC_HERMITE,
    reason_against=lambda scene, rate: None,
    write=_write,
    read=_read,
    uneven=True,
)
"""A file for MATLAB."""
